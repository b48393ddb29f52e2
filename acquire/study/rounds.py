"""Rounds: what the folder of a study holds; a step whose result is there is done."""

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from exidyn.identify.errors import NotAFile
from exidyn.identify.fit.fit_file import read_json
from exidyn.identify.recordings.importers import import_source
from exidyn.identify.recordings.recording import Recording
from exidyn.trajectories.next_run.choice import RUN

CHOICE, NEXT, NOTEBOOK = "choice.json", "next.toml", "notebook.html"
"""Files: of a choice, of the motion that was chosen, of the whole study."""
FORMAT = 1
"""Of `CHOICE`."""


@dataclass(frozen=True)
class Round:
    """One run and what came of it.

    Attributes:
        number: From 1.
        folder: Of its files.
    """

    number: int
    folder: Path

    @property
    def name(self) -> str:
        """What it is called."""
        return self.folder.name

    @property
    def plan(self) -> Path:
        """The motion; not there for a recording that exists."""
        return self.folder / "plan.toml"

    @property
    def run(self) -> Path:
        """The recording."""
        return self.folder / "run.mcap"

    @property
    def fit(self) -> Path:
        """Folder of what `exidyn identify` makes of all runs so far."""
        return self.folder / "fit"

    @property
    def diagnosis(self) -> Path:
        """Folder of what `exidyn diagnose` makes of them, and of the choice."""
        return self.folder / "diagnosis"

    @property
    def choice(self) -> dict[str, Any] | None:
        """What was chosen behind it; None before.

        Raises:
            NotAFile: A choice of another version.
        """
        path = self.diagnosis / CHOICE
        if not path.exists():
            return None
        table = read_json(path)
        if not isinstance(table, dict) or table.get("exidyn_study") != FORMAT:
            raise NotAFile(
                f"{path} is no choice of a study, format {FORMAT}; begin in another folder (--output)"
            )
        return table

    def recording(self) -> Recording:
        """Its run.

        Raises:
            NotAFile: It is none.
        """
        [recording] = import_source(self.run)
        return recording


def rounds(folder: Path) -> list[Round]:
    """Those that were begun, in order."""
    found: list[Round] = []
    while (one := _round(folder, len(found) + 1)).folder.is_dir():
        found.append(one)
    return found


def next_round(folder: Path) -> Round:
    """The round in which something is left to do, or a new one behind a choice to go on."""
    every = rounds(folder)
    if every and ((choice := every[-1].choice) is None or choice["verdict"] != RUN):
        return every[-1]
    return _round(folder, len(every) + 1)


def forget_end(folder: Path, asked: dict[str, Any]) -> None:
    """Take back the last diagnosis of a study that ended, where it is asked otherwise now."""
    every = rounds(folder)
    choice = every[-1].choice if every else None
    if choice is not None and choice["verdict"] != RUN and choice["asked"] != asked:
        shutil.rmtree(every[-1].diagnosis)


def _round(folder: Path, number: int) -> Round:
    return Round(number, folder / f"round-{number:02d}")


def made_whole(result: Path, make: Callable[[Path], None]) -> None:
    """Make a folder that appears under its name only when it is whole; nothing where it is there.

    Args:
        result: Its path.
        make: Called with the path of a folder to be filled.
    """
    if result.exists():
        return
    part = result.with_name(result.name + ".part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    make(part)
    os.replace(part, result)
