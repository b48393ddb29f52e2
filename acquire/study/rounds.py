"""Rounds: what the folder of a study holds; a step whose result is there is done."""

import os
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

from exidyn.identification.errors import DifferentRobot, NotAFile
from exidyn.identification.fit.fit_file import read_json
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.robot_text import model_text
from exidyn.identification.schema import checked
from exidyn.quoting import visible
from exidyn.trajectories.next_run.choice import RUN

from ..arguments.parser import complaint
from ..run.errors import NotConfirmed
from ..screen import beneath
from ..terminal.json_output import write_whole
from ..terminal.recording_text import why_it_ended
from .choice_schema import ChoiceFile

CHOICE, NEXT, NOTEBOOK, ROBOT = "choice.json", "next.toml", "notebook.html", "robot.toml"
"""Files: of a choice, of the motion that was chosen, of the whole study, of the arm it is about."""
ATTEMPTS = "attempt-*.mcap"
"""Runs of a round that were stopped before their end."""
FORMAT = 2
"""Of `CHOICE`."""


@dataclass(frozen=True)
class Round:
    """One run and what came of it, numbered from 1, in a folder."""

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
        """What was chosen behind it; None before. Raises `NotAFile` for a choice of another version."""
        path = self.diagnosis / CHOICE
        if not path.exists():
            return None
        table = read_json(path)
        if not isinstance(table, dict) or table.get("exidyn_study") != FORMAT:
            raise NotAFile(
                f"{path} is no choice of a study, format {FORMAT}; begin in another folder (--output)"
            )
        checked(table, ChoiceFile, str(path))
        return table

    @property
    def stops(self) -> list[str]:
        """Why each of its runs was stopped that was stopped before its end, in order."""
        return [why_it_ended(read_recording(path).outcome) for path in sorted(self.folder.glob(ATTEMPTS))]

    def recording(self) -> Recording:
        """Its run; raises `NotAFile` where it is none."""
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


def require_same_robot(folder: Path, model: Model) -> None:
    """Write down which arm a study is about; raise `DifferentRobot` where it was about another one."""
    path, text = folder / ROBOT, model_text(model)
    if not path.exists():
        write_whole(path, text)
    elif (before := path.read_text(encoding="utf-8")) != text:
        name = read_model(path).robot.name
        pairs = zip(before.splitlines(), text.splitlines(), strict=False)
        line = next((f"'{one}' there, '{other}' here" for one, other in pairs if one != other), "more lines")
        raise DifferentRobot(
            f"{folder} holds a study of {name} as {path} states it, not of this {model.robot.name} ({line}); "
            "begin in another folder (--output)"
        )


def _round(folder: Path, number: int) -> Round:
    return Round(number, folder / f"round-{number:02d}")


def fill_folder(result: Path, fill: Callable[[Path], None]) -> None:
    """Fill a folder that appears under its name only when it is complete, unless it is there already."""
    if result.exists():
        return
    part = result.with_name(result.name + ".part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    fill(part)
    os.replace(part, result)


def tell(words: object) -> None:
    """Print a sentence on standard error, above a bar that is there, in one line for scripts."""
    tqdm.write(visible(complaint(f"exidyn: {' '.join(str(words).split())}")), beneath(sys.stderr))


def ask(request: str) -> None:
    """Ask for something in one sentence, and wait until it is done.

    Raises:
        NotConfirmed: There is no terminal to answer in.
    """
    print(f"{request}, then press Enter: ", end="", file=sys.stderr, flush=True)
    try:
        input()
    except EOFError:
        print(file=sys.stderr)
        raise NotConfirmed(
            "there is no terminal to answer in, nothing was moved. The same command goes on from here"
        ) from None
