"""Rounds: the contents of a study's folder; a step is done once its result exists."""

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
from .choice_file import FORMAT, RoundChoice

CHOICE, NEXT, NOTEBOOK, ROBOT = "choice.json", "next.toml", "notebook.html", "robot.toml"
"""Names of files: a choice, the chosen motion, the notebook of the study, and its robot."""
ATTEMPTS = "attempt-*.mcap"
"""Pattern of the files of runs that were stopped before their end."""


@dataclass(frozen=True)
class Round:
    """A run and its results, in a folder; rounds are numbered from 1."""

    number: int
    folder: Path

    @property
    def name(self) -> str:
        """Name of the round."""
        return self.folder.name

    @property
    def plan(self) -> Path:
        """File of the motion; absent if the run is an existing recording."""
        return self.folder / "plan.toml"

    @property
    def run(self) -> Path:
        """File of the recording."""
        return self.folder / "run.mcap"

    @property
    def fit(self) -> Path:
        """Folder of the results of `exidyn identify` on all runs so far."""
        return self.folder / "fit"

    @property
    def diagnosis(self) -> Path:
        """Folder of the choice and of the results of `exidyn diagnose` on all runs so far."""
        return self.folder / "diagnosis"

    @property
    def choice(self) -> RoundChoice | None:
        """The choice made after this run, if any; raises `NotAFile` if its format has another version."""
        path = self.diagnosis / CHOICE
        if not path.exists():
            return None
        table = read_json(path)
        if not isinstance(table, dict) or table.get("exidyn_study") != FORMAT:
            raise NotAFile(
                f"{path} is not a choice of a study in format {FORMAT}; start in another folder (--output)"
            )
        return checked(table, RoundChoice, str(path))

    @property
    def stops(self) -> list[str]:
        """Reason of each stop before the end of a run, in order."""
        return [why_it_ended(read_recording(path).outcome) for path in sorted(self.folder.glob(ATTEMPTS))]

    def recording(self) -> Recording:
        """Read the recording; raises `NotAFile` if the file is not a recording."""
        [recording] = import_source(self.run)
        return recording


def rounds(folder: Path) -> list[Round]:
    """All rounds that were begun, in order."""
    begun: list[Round] = []
    while (candidate := _round(folder, len(begun) + 1)).folder.is_dir():
        begun.append(candidate)
    return begun


def next_round(folder: Path) -> Round:
    """The last round if it is unfinished or ended the study, otherwise a new round."""
    begun = rounds(folder)
    if begun and ((choice := begun[-1].choice) is None or choice.verdict != RUN):
        return begun[-1]
    return _round(folder, len(begun) + 1)


def forget_end(folder: Path, options: dict[str, Any]) -> None:
    """Delete the last diagnosis of a study that ended if its options have changed since."""
    begun = rounds(folder)
    choice = begun[-1].choice if begun else None
    if choice is not None and choice.verdict != RUN and choice.asked != options:
        shutil.rmtree(begun[-1].diagnosis)


def require_same_robot(folder: Path, model: Model) -> None:
    """Write the robot of a study to its folder; raise `DifferentRobot` if another robot is there."""
    path, text = folder / ROBOT, model_text(model)
    if not path.exists():
        write_whole(path, text)
    elif (before := path.read_text(encoding="utf-8")) != text:
        name = read_model(path).robot.name
        pairs = zip(before.splitlines(), text.splitlines(), strict=False)
        line = next(
            (f"'{there}' there, '{here}' here" for there, here in pairs if there != here), "more lines"
        )
        raise DifferentRobot(
            f"{folder} holds a study of {name}, described by {path}; your {model.robot.name} differs "
            f"({line}). Start in another folder (--output)"
        )


def _round(folder: Path, number: int) -> Round:
    return Round(number, folder / f"round-{number:02d}")


def fill_folder(result: Path, fill: Callable[[Path], None]) -> None:
    """Fill a folder unless it exists; it appears under its name only when it is complete."""
    if result.exists():
        return
    part = result.with_name(result.name + ".part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    fill(part)
    os.replace(part, result)


def tell(words: object) -> None:
    """Print a sentence on standard error, above any progress bar; on one line if it is not a terminal."""
    tqdm.write(visible(complaint(f"exidyn: {' '.join(str(words).split())}")), beneath(sys.stderr))


def ask(request: str) -> None:
    """Ask a person to do something, and wait until it is done; raises `NotConfirmed` without a terminal."""
    print(f"{request}, then press Enter: ", end="", file=sys.stderr, flush=True)
    try:
        input()
    except EOFError:
        print(file=sys.stderr)
        raise NotConfirmed(
            "there is no terminal to answer in, so nothing was moved. "
            "Run the same command in a terminal to continue"
        ) from None
