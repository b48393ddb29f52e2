"""Lines, files, functions and classes of a checkout's package."""

import ast
from collections import Counter
from pathlib import Path

FOLDERS = ("acquire", "drivers", "identify", "trajectories")
"""At the top of a checkout; each is a package in exidyn."""
LONG_FILE, SHORT_FILE, LONG_FUNCTION = 300, 40, 40
"""Lines above and below which a file or a function is counted apart."""
KINDS = ("code", "docstring", "import", "comment", "blank")
IMPORTS = (ast.Import, ast.ImportFrom)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def files_of(root: Path) -> list[Path]:
    """The Python files of the package; links, which older checkouts have in exidyn, are not followed."""
    return [
        *(root / "exidyn").glob("*.py"),
        *(path for name in FOLDERS for path in (root / name).rglob("*.py")),
    ]


def counts_of(root: Path) -> Counter[str]:
    """What a checkout's package is made of."""
    found = Counter[str]()
    for path in files_of(root):
        text = path.read_text(encoding="utf-8")
        kinds, tree = kinds_of_lines(text), ast.parse(text)
        functions = [node for node in ast.walk(tree) if isinstance(node, FUNCTIONS)]
        found.update(
            {
                "lines": len(kinds),
                "files": 1,
                **{f"lines: {kind}": kinds.count(kind) for kind in KINDS},
                "functions": len(functions),
                "classes": sum(isinstance(node, ast.ClassDef) for node in ast.walk(tree)),
                f"files above {LONG_FILE} lines": len(kinds) > LONG_FILE,
                f"files below {SHORT_FILE} lines": len(kinds) < SHORT_FILE,
                f"functions above {LONG_FUNCTION} lines": sum(
                    length_of(node, kinds) > LONG_FUNCTION for node in functions
                ),
            }
        )
    return found


def kinds_of_lines(text: str) -> list[str]:
    """What each line of a file is; a text that stands alone behind a constant is a docstring of it."""
    kinds = ["blank" if not line.strip() else "code" for line in text.splitlines()]
    for place, line in enumerate(text.splitlines()):
        if line.lstrip().startswith("#"):
            kinds[place] = "comment"
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, IMPORTS):
            kinds[node.lineno - 1 : node.end_lineno] = ["import"] * (node.end_lineno - node.lineno + 1)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            if isinstance(node.value.value, str):
                kinds[node.lineno - 1 : node.end_lineno] = ["docstring"] * (node.end_lineno - node.lineno + 1)
    return kinds


def length_of(function: ast.FunctionDef | ast.AsyncFunctionDef, kinds: list[str]) -> int:
    """Lines of a function from its `def`, without docstring."""
    within = kinds[function.lineno - 1 : function.end_lineno]
    return len(within) - within.count("docstring")
