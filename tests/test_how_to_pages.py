"""The how-to pages of docs run as they stand: every block, in order, in an empty folder.

A block of the shell with a title, such as ```sh title="On the robot", needs hardware and is not run;
`test_pages.py` parses its commands. A block of another language whose title is the name of a file is written
to that file.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"^( *)```(\w+)(?: title=\"([^\"]*)\")?\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
"""Indent, language, title and text of a fenced block."""
LONGEST = 900.0
"""Time after which a block has hung [s]."""
PEERS = pytest.mark.clocked
ALONE = ("csv", "payload", "compensate", "mujoco")
WITH_PEERS = ("so101", "can", "serial", "ur", "franka", "kuka")
PAGES = {f"how-to-{name}": [PEERS] * (name in WITH_PEERS) for name in ALONE + WITH_PEERS}
"""Page -> further marks of its test: those with peers keep to the clock."""
NEEDS = {
    "how-to-mujoco": ("mujoco",),
    "how-to-so101": ("mujoco", "serial"),
    "how-to-can": ("can", "msgpack"),
    "how-to-serial": ("serial",),
    "how-to-franka": ("pylibfranka", "franky_sim"),
}
"""Packages of extras without which a page cannot run."""
BUSY = re.compile("nothing was received|of the last second's (cycles|samples)|no cycle for|clock went on by")
"""Why a run is stopped where a busy computer misses cycles; all other stops are a fault of the page."""
TRIES = 3
"""How often a page with a peer is run, at most, where its runs are stopped so."""


class BlockFailed(AssertionError):
    """A block ended with another exit code than 0; the text has the end of what it printed.

    `busy` is whether a run in it was stopped because cycles were missed.
    """

    def __init__(self, code: int, block: str, printed: str) -> None:
        super().__init__(f"exit code {code} of\n{block}\n{printed[-1500:]}")
        self.busy = bool(BUSY.search(printed))


class Block(NamedTuple):
    """A fenced block of a page; the title is empty where it has none."""

    language: str
    title: str
    text: str


def blocks_of(text: str) -> list[Block]:
    """All fenced blocks of a page that state a language."""
    return [
        Block(language, title, re.sub(f"^{indent}", "", block, flags=re.MULTILINE))
        for indent, language, title, block in BLOCK.findall(text)
    ]


def steps_of(blocks: list[Block], folder: Path) -> Iterator[list[str]]:
    """Commands that run the blocks; the files of the page are written on the way."""
    for number, block in enumerate(blocks):
        if block.language == "sh" and not block.title:
            script = folder / f".step-{number}.sh"
            script.write_text(f"set -e -o pipefail\n{block.text}", encoding="utf-8")
            yield ["bash", str(script)]
        elif block.language == "python":
            script = folder / f".step-{number}.py"
            script.write_text(block.text, encoding="utf-8")
            yield [sys.executable, str(script)]
        elif "." in block.title and block.language != "sh":
            (folder / block.title).write_text(block.text, encoding="utf-8")


def tools(folder: Path) -> dict[str, str]:
    """The environment of a page, in which `exidyn` and `python` are this interpreter's."""
    programs = folder / ".bin"
    programs.mkdir()
    for name, arguments in (("exidyn", " -m exidyn.acquire.command_line"), ("python", ""), ("python3", "")):
        (programs / name).write_text(f'#!/bin/sh\nexec "{sys.executable}"{arguments} "$@"\n')
        (programs / name).chmod(0o755)
    return os.environ | {"PATH": f"{programs}:{os.environ['PATH']}", "OMP_NUM_THREADS": "1"}


def run_page(text: str, folder: Path) -> int:
    """Run a page in a folder with a yes for every question; the number of blocks that were run.

    Raises:
        BlockFailed: A block ended with another exit code than 0.
    """
    environment = tools(folder)
    (folder / "tests").symlink_to(ROOT / "tests")
    answers = folder / ".answers"
    answers.write_text("yes\n" * 20_000)
    count = 0
    groups: list[int] = []
    try:
        for command in steps_of(blocks_of(text), folder):
            printed = folder / f"{command[-1]}.log"
            with answers.open() as told, printed.open("w") as out:
                streams = {"stdin": told, "stdout": out, "stderr": out}
                process = subprocess.Popen(
                    command, cwd=folder, env=environment, start_new_session=True, **streams
                )
            groups.append(process.pid)
            code = process.wait(LONGEST)
            if code != 0:
                block = Path(command[-1]).read_text(encoding="utf-8")
                raise BlockFailed(code, block, printed.read_text(encoding="utf-8", errors="replace"))
            count += 1
    finally:
        for group in groups:  # peers that a block has left in the background
            with suppress(ProcessLookupError):
                os.killpg(group, signal.SIGKILL)
    return count


def run_page_again(text: str, folder: Path, tries: int) -> int:
    """Run a page, and from its beginning again where missed cycles stopped a run of it."""
    for number in range(tries):
        (attempt := folder / f"try-{number}").mkdir()
        try:
            return run_page(text, attempt)
        except BlockFailed as failed:
            if not failed.busy:
                raise
    pytest.skip("this computer is too busy for the peer: cycles were missed in each try")


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("name", [pytest.param(name, marks=marks, id=name) for name, marks in PAGES.items()])
def test_a_how_to_page_runs_as_it_stands(name, tmp_path):
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed")
    for package in NEEDS.get(name, ()):
        pytest.importorskip(package)
    text = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
    tries = TRIES if PEERS in PAGES[name] else 1
    assert run_page_again(text, tmp_path, tries) >= 2


def test_every_how_to_page_is_run():
    assert sorted(PAGES) == sorted(page.stem for page in (ROOT / "docs").glob("how-to-*.md"))


def test_blocks_for_hardware_state_where_they_are_run():
    """A title is either where a block is run or the name of a file, which no block of the shell is."""
    titles = {
        block.title
        for name in PAGES
        for block in blocks_of((ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8"))
        if block.language == "sh" and block.title
    }
    assert titles == {"On the robot"}


PAGE = """
Save this as `names.csv`:

```csv title="names.csv"
a,b
```

1. Indented, in a list:

   ```sh
   grep -q a,b names.csv
   exidyn --help | head -1
   ```

```sh title="On the robot"
false
```

```toml
never = "a file"
```

```python
print(open("names.csv").read())
```
"""


@pytest.mark.slow
def test_a_page_is_run_block_by_block(tmp_path):
    assert run_page(PAGE, tmp_path) == 2
    assert sorted(path.name for path in tmp_path.glob("[!.]*")) == ["names.csv", "tests"]
    assert (tmp_path / ".step-4.py.log").read_text() == "a,b\n\n"


@pytest.mark.parametrize("wrong", ["false\ntrue", "false | true"])
def test_a_page_whose_command_fails_is_reported(tmp_path, wrong):
    with pytest.raises(AssertionError, match="exit code"):
        run_page(f"```sh\n{wrong}\n```\n", tmp_path)


def test_a_page_is_run_again_where_cycles_were_missed(tmp_path):
    """The second try finds the file that the first has left."""
    missed = "echo nothing was received from joint1 for 5 cycles; exit 1"
    assert run_page_again(f"```sh\n[ -e ../done ] || {{ touch ../done; {missed}; }}\n```\n", tmp_path, 3) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["done", "try-0", "try-1"]


@pytest.mark.parametrize("printed", ["tracking error 0.3 rad, limit 0.26", "Did you mean --mass?"])
def test_a_page_is_not_run_again_for_a_fault_of_its_own(tmp_path, printed):
    with pytest.raises(BlockFailed, match=re.escape(printed)):
        run_page_again(f"```sh\necho '{printed}'; exit 1\n```\n", tmp_path, 3)
    assert len(list(tmp_path.iterdir())) == 1
