"""What the benchmark of size counts, on small sources."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from parts.size import walks
from parts.size.source import counts_of, kinds_of_lines

SOURCE = '''"""A file."""

import os
from os import (
    path,
)

LIMIT = 1
"""Of something."""


class Held:
    """What is held."""

    def far(self, much):  # more
        """How far.

        In metres.
        """
        # a comment
        return len(much)
'''
CALLED = """
from dataclasses import dataclass

def while_imported():
    return 1

def used():
    return sum(x for x in (1, 2))

def not_used():
    return 2

@dataclass
class Held:
    value: int = while_imported()

class Other:
    def method(self):
        return used()

def main():
    return Other().method() + Held().value
"""


def test_lines_are_of_one_kind_each():
    kinds = kinds_of_lines(SOURCE)
    counts = {kind: kinds.count(kind) for kind in set(kinds)}
    assert counts == {"docstring": 7, "import": 4, "code": 4, "comment": 1, "blank": 5}


def test_a_checkout_is_counted_without_what_links_lead_to(tmp_path):
    for name in ("exidyn", "acquire"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "x.py").write_text(SOURCE, encoding="utf-8")
    (tmp_path / "exidyn" / "acquire").symlink_to(tmp_path / "acquire")
    found = counts_of(tmp_path)
    lines = len(SOURCE.splitlines())
    assert (found["files"], found["lines"], found["functions"], found["classes"]) == (2, 2 * lines, 2, 2)
    assert found["files below 40 lines"] == 2
    assert found["functions above 40 lines"] == found["files above 300 lines"] == 0


def test_what_a_process_enters_is_noted_but_not_what_imports_call(tmp_path):
    (tmp_path / "toy").mkdir()
    (tmp_path / "toy" / "called.py").write_text(CALLED, encoding="utf-8")
    shutil.copy(Path(walks.__file__).with_name("entered.py"), tmp_path / "sitecustomize.py")
    hook = {"WALK_PACKAGE": str(tmp_path / "toy"), "WALK_FILE": str(tmp_path / "walk.txt")}
    subprocess.run(
        [sys.executable, "-c", "from toy.called import main; main()"],
        env={**os.environ, **hook, "PYTHONPATH": str(tmp_path)},
        check=True,
    )
    walk = walks.walk_of(tmp_path / "walk.txt")
    assert walk == walks.Walk(functions=3, classes=2, files=1)
