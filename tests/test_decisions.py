"""No code decides anything by looking into a sentence: rewording a message changes nothing else."""

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
PHRASE = re.compile(r"[a-z]{2,} [a-z]{2,}")
"""Two words: a sentence or a part of one."""
ASKS = {"startswith", "endswith", "removeprefix", "removesuffix", "partition", "find", "index", "count"}
PATTERNS = {"search", "match", "fullmatch", "compile", "sub"}
OF_OTHERS = {
    ("acquire/arguments/parser.py", "the following arguments are required"),
    ("acquire/views/viewers.py", r"\x1b\[[0-9;]*m|os error at \S+: "),
    ("identify/schema.py", "^Object missing required field `(.*)`$"),
    ("identify/schema.py", "^Object contains unknown field `(.*)`$"),
    ("identify/schema.py", r"^(?P<text>.*?)(?: - at `(?P<key>key in )?\$(?P<path>.*)`)?$"),
}
"""Messages of argparse, msgspec and Rerun, which give no other sign."""
LABELS = {
    "link lost",  # kind of a stop, as outcomes have it
    "of the way",  # unit of a judgment, as its JSON has it
    "sensor noise",  # kind of a share, as diagnosis.json has it
    "nothing that was recorded",  # likewise
    "high frequencies",  # source of a noise floor, as fit.json has it
    "N m against the joint",  # answer to a question, as a proposal's JSON has it
    "not N m: needs gain",  # likewise
    "gain of ",  # beginning of such a question
    "unit of ",  # likewise
    "unit of position",  # such a question
    "an excitation",  # name of a run on offer, as choice.json has it
    "an excitation where the fit knows least",  # likewise
    " of joint",  # what a user writes of a joint
}
"""Values of an enumeration that files, scripts or users know by these words."""


def product_files():
    folders = ("acquire", "drivers", "exidyn", "identify", "trajectories")
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


def constants(tree):
    """Texts by the names that a module gives them."""
    texts = {}
    for node in tree.body:
        if not isinstance(node, ast.Assign):
            continue
        [target, *_] = node.targets
        values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
        names = target.elts if isinstance(target, ast.Tuple) else [target]
        for name, value in zip(names, values, strict=False):
            if isinstance(name, ast.Name) and isinstance(getattr(value, "value", None), str):
                texts[name.id] = value.value
    return texts


@cache
def tree_of(path):
    return ast.parse(path.read_text(encoding="utf-8"))


CONSTANTS = {
    (path.stem, name): text
    for path in product_files()
    for name, text in constants(tree_of(path)).items()
    if name.isupper()
}
"""Text of a constant by the name of its module and its own."""


def decisions(tree):
    """Every phrase that a comparison or a search of text looks for."""
    phrases = constants(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            module = (node.module or "").rpartition(".")[2]
            for alias in node.names:
                if (module, alias.name) in CONSTANTS:
                    phrases[alias.asname or alias.name] = CONSTANTS[module, alias.name]

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


def test_no_decision_looks_into_a_sentence():
    wrong = {}
    for path in product_files():
        name = path.relative_to(ROOT).as_posix()
        allowed = LABELS | {phrase for file, phrase in OF_OTHERS if file == name}
        if looked_for := set(decisions(tree_of(path))) - allowed:
            wrong[name] = looked_for
    assert wrong == {}


def test_a_decision_by_a_sentence_is_seen():
    tree = ast.parse('NOTE = "is constant"\nif NOTE in warning or text.startswith("no run"):\n    pass\n')
    assert set(decisions(tree)) == {"is constant", "no run"}
