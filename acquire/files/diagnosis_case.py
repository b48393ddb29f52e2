"""What `exidyn diagnose` is given: a nominal robot, and runs with what each is for."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from exidyn.identify.diagnosis.questions.shape import Shaped
from exidyn.identify.errors import RecordingError
from exidyn.identify.fit.identification import same_robot
from exidyn.identify.model import Model
from exidyn.identify.recordings.importers import import_source, kind_of
from exidyn.identify.recordings.importers.case_folder import nominal_model
from exidyn.identify.recordings.recording import Recording
from exidyn.identify.robot_files.robot_file import builtin_names, read_model
from exidyn.identify.robot_files.urdf import ENDINGS

from .payload_runs import carrying, distinct_bodies

ROLE = "identify"
"""Role of a run that does not contain its own."""


COMPARISON_CUTOFF = 25.0
"""Low-pass of the comparison of case folders [Hz], a part of their format: residuals of different programs
are comparable only behind the same filter."""


class Case(NamedTuple):
    """One robot and its runs.

    Attributes:
        name: Of the case; of the robot where it has none.
        model: Nominal.
        runs: What each is for, and its recording.
        before: Shapes that a diagnosis of some of these runs has found.
    """

    name: str
    model: Model
    runs: list[tuple[str, Recording]]
    before: Sequence[Shaped] = ()


def case_folders(sources: Sequence[str]) -> list[Path]:
    """The sources, if all are folders with case.toml; none if they are a robot and runs.

    Raises:
        RecordingError: Some are and some are not.
    """
    cases = [Path(source) for source in sources if _is_case(source)]
    if cases and len(cases) < len(sources):
        others = ", ".join(source for source in sources if not _is_case(source))
        raise RecordingError(
            f"{others}: no case folder, as the others are; give either cases, or a robot and runs"
        )
    return [path if path.is_dir() else path.parent for path in cases]


def _is_case(source: str) -> bool:
    return Path(source).exists() and not _is_robot(source) and kind_of(Path(source)) == "case_folder"


def _is_robot(source: str) -> bool:
    """Whether it describes a robot: a file of that kind, or a name of those built in."""
    path = Path(source)
    return source in builtin_names() or path.suffix in (".toml", *ENDINGS) and path.name != "case.toml"


def read_case(folder: Path) -> Case:
    """The case in a folder."""
    recordings = import_source(folder, kind="case_folder")
    name = recordings[0].name.partition("/")[0] if recordings else folder.name
    return Case(name, nominal_model(folder), [(role_of(run), run) for run in recordings])


def role_of(recording: Recording) -> str:
    """The role that a run contains."""
    return recording.settings.get("role") or ROLE


def recorded_case(given: argparse.Namespace) -> Case:
    """The robot and the runs of a command line; without a robot, the one in the recordings.

    Raises:
        RecordingError: There are no runs.
    """
    model = read_model(given.sources[0]) if _is_robot(given.sources[0]) else None
    runs = [
        (role_of(recording), recording)
        for source in given.sources[0 if model is None else 1 :]
        for recording in import_source(Path(source), model)
    ]
    for role in ("slow", "validate"):
        runs += [(role, one) for path in getattr(given, role) for one in import_source(path, model)]
    for run in given.payload:
        runs += [("payload", carrying(one, run)) for one in import_source(run.path, model)]
    if not runs:
        raise RecordingError("a robot and no run: give at least one recording behind it")
    named = distinct_bodies([recording for _, recording in runs])
    roles = [role for role, _ in runs]
    model = model or same_robot(named)
    return Case(model.robot.name, model, list(zip(roles, named, strict=True)))
