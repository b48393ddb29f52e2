"""No code decides anything by looking into a sentence: rewording a message changes nothing else."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PHRASE = re.compile(r"[a-z]{2,} [a-z]{2,}")
"""Two words: a sentence or a part of one."""
ASKS = {"startswith", "endswith", "removeprefix", "removesuffix", "partition", "find", "index", "count"}
PATTERNS = {"search", "match", "fullmatch", "compile", "sub"}
OF_OTHERS = {
    ("acquire/arguments/parser.py", "the following arguments are required: "),
    ("acquire/views/viewers.py", r"\x1b\[[0-9;]*m|os error at \S+: "),
    ("identify/schema.py", "^Object missing required field `(.*)`$"),
    ("identify/schema.py", "^Object contains unknown field `(.*)`$"),
    ("identify/schema.py", r"^(?P<text>.*?)(?: - at `(?P<key>key in )?\$(?P<path>.*)`)?$"),
}
"""Messages of argparse, msgspec and Rerun, which give no other sign."""
LABELS = {("acquire/run/perform.py", "link lost"), ("trajectories/planning/wanted.py", " of joint")}
"""The kind of a stop as outcomes have it, and what a user writes of a joint."""


def product_files():
    folders = ("acquire", "drivers", "exidyn", "identify", "trajectories")
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


def decisions(tree):
    """Every phrase that a comparison or a search of text looks for."""
    phrases = {}
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
            phrases |= {name.id: node.value.value for name in node.targets if isinstance(name, ast.Name)}

    def text(node):
        value = phrases.get(node.id) if isinstance(node, ast.Name) else getattr(node, "value", None)
        return value if isinstance(value, str) and PHRASE.search(value) else None

    for node in ast.walk(tree):
        sides = []
        if isinstance(node, ast.Compare) and not any(isinstance(op, ast.Is | ast.IsNot) for op in node.ops):
            sides = [node.left, *node.comparators]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            sides = node.args[:1] if node.func.attr in ASKS | PATTERNS else []
        yield from (found for side in sides if (found := text(side)))


@pytest.mark.parametrize("path", product_files(), ids=lambda path: str(path.relative_to(ROOT)))
def test_no_decision_looks_into_a_sentence(path):
    looked_for = set(decisions(ast.parse(path.read_text(encoding="utf-8"))))
    name = path.relative_to(ROOT).as_posix()
    assert looked_for <= {phrase for file, phrase in OF_OTHERS | LABELS if file == name}


def test_a_decision_by_a_sentence_is_seen():
    tree = ast.parse('NOTE = "is constant"\nif NOTE in warning or text.startswith("no run"):\n    pass\n')
    assert set(decisions(tree)) == {"is constant", "no run"}
