"""Walks: how many functions, classes and files are entered from what a person has to what they get."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from .source import FOLDERS

SMALL = (
    "excite cobot --start 0 -90 0 0 0 0 --window 10 --degrees --tick 0.008 --length 5 --period 5 "
    "--harmonics 2 --search 1 -o small.toml"
).split()
"""A motion of some seconds for the recording loop."""
RECORD = "record small.toml --robot cobot --approach --no-rehearsal --yes".split()
PEER = "--robot cobot --series cb3".split()
"""Of UR's peer: a CB3 has cycles of 8 ms, which a busy machine keeps."""
SETTINGS = """driver = "ur_rtde"

[settings]
address = "{}"
cycle = 0.008
rtde_port = {}
program_port = {}
dashboard_port = {}
"""


class Walk(NamedTuple):
    """What is entered on a way, each once."""

    functions: int
    classes: int
    files: int


class Walker:
    """A checkout's `exidyn` in a folder, with a robot and its log.

    Args:
        root: The checkout.
        folder: An empty one.
    """

    def __init__(self, root: Path, folder: Path) -> None:
        self._root, self.folder = root.resolve(), folder.resolve()
        self._package = self.folder / "package" / "exidyn"
        self._package.mkdir(parents=True)
        own = [path for path in (self._root / "exidyn").iterdir() if path.suffix in (".py", ".typed")]
        for path in (*own, *(self._root / name for name in FOLDERS)):
            (self._package / path.name).symlink_to(path)
        # The folder identify is the package identification; it had its own name in older checkouts.
        (self._package / "identification").symlink_to(self._root / "identify")
        (self.folder / "hook").mkdir()
        shutil.copy(Path(__file__).with_name("entered.py"), self.folder / "hook" / "sitecustomize.py")
        self._exidyn(["example", "files", "--output", "."])

    def fit(self) -> Walk:
        """From a CSV log to a fit."""
        return self._walk(
            ["import", "log.csv", "--robot", "robot.toml", "--degrees"],
            ["identify", "log.mcap", "-o", "fit"],
        )

    def diagnosis(self) -> Walk:
        """From two runs to the report of a diagnosis."""
        self._two_runs()
        return self._walk(
            ["diagnose", "robot.toml", "first.mcap", "--validate", "second.mcap", "-o", "found"]
        )

    def page(self) -> Walk:
        """From two runs and the fit that `fit` has written to one page of all."""
        self._two_runs()
        return self._walk(["report", "fit", "first.mcap", "second.mcap"])

    def cycle_of_mock(self) -> Walk:
        """One cycle of the loop, with the mock."""
        return self._cycle("--driver", "mock", "-o", "mock.mcap")

    def cycle_of_ur(self) -> Walk:
        """One cycle of the loop, to UR's socket."""
        with self._peer() as address:
            (self.folder / "cell.toml").write_text(SETTINGS.format(*address.split()), encoding="utf-8")
            return self._cycle("--controller", "cell.toml", "-o", "ur.mcap")

    def _two_runs(self) -> None:
        """The two halves of the log."""
        if (self.folder / "second.mcap").exists():
            return
        header, *rows = (self.folder / "log.csv").read_text(encoding="utf-8").splitlines(keepends=True)
        half = len(rows) // 2
        for name, part in (("first", rows[:half]), ("second", rows[half:])):
            (self.folder / f"{name}.csv").write_text("".join([header, *part]), encoding="utf-8")
            self._exidyn(["import", f"{name}.csv", "--robot", "robot.toml", "--degrees"])

    def _cycle(self, *controller: str) -> Walk:
        if not (self.folder / "small.toml").exists():
            self._exidyn(SMALL)
        return self._walk([*RECORD, *controller], WALK_CYCLES="1")

    def _walk(self, *commands: list[str], **environment: str) -> Walk:
        file = self.folder / "walk.txt"
        file.unlink(missing_ok=True)
        hook = {"WALK_PACKAGE": str(self._package), "WALK_FILE": str(file), **environment}
        for command in commands:
            self._exidyn(command, hook)
        return walk_of(file)

    def _exidyn(self, command: list[str], hook: Mapping[str, str] = {}) -> None:  # noqa: B006
        ran = subprocess.run(
            [sys.executable, "-m", "exidyn.acquire.command_line", *command],
            cwd=self.folder,
            env=self._environment(hook),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        if ran.returncode:
            raise SystemExit(f"exidyn {' '.join(command)} of {self._root} ended with:\n{ran.stderr}")

    def _environment(self, hook: Mapping[str, str]) -> dict[str, str]:
        imports = [self.folder / "hook"] if hook else []
        path = os.pathsep.join(map(str, [*imports, self._package.parent]))
        return {**os.environ, "OMP_NUM_THREADS": "1", "EXIDYN_UNATTENDED": "yes", "PYTHONPATH": path, **hook}

    @contextmanager
    def _peer(self) -> Iterator[str]:
        """UR's peer, a process; gives its address and ports."""
        script = self._root / "tests" / "peers" / "ur_controller.py"
        with subprocess.Popen(
            [sys.executable, script, *PEER],
            env=self._environment({}),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        ) as peer:
            assert peer.stdout is not None
            try:
                yield next(line for line in peer.stdout if line.startswith("ready ")).removeprefix("ready ")
            finally:
                peer.kill()


def walk_of(file: Path) -> Walk:
    """What the lines of a file name, which processes have written by `entered.py`."""
    lines = {tuple(line.split("\t")) for line in file.read_text(encoding="utf-8").splitlines()}
    classes = {(place, name.rpartition(".")[0]) for place, name, _ in lines}
    return Walk(
        functions=sum(number != "0" for _, _, number in lines),
        classes=sum(name != "" and not name.endswith("<locals>") for _, name in classes),
        files=len({place for place, _, _ in lines}),
    )
