"""What commands are given: an arm, runs with what they carry and what each is for, and names that differ."""

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, count
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from exidyn.identification.diagnosis.findings.evidence import Trace
from exidyn.identification.diagnosis.questions.shape import Shaped
from exidyn.identification.diagnosis.runs.usable import HELD_OUT
from exidyn.identification.effects import known_parameters
from exidyn.identification.errors import NeedsPayload, RecordingError
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.fit.identification import same_robot
from exidyn.identification.fit.identified import identified
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source, kind_of
from exidyn.identification.recordings.importers.case_folder import nominal_model
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.description import ENDINGS, NAMED
from exidyn.identification.robot_files.robot_file import builtin_names, read_model

from ..arguments.command import Option, any_number

Named = TypeVar("Named", Recording, Trace)
ARM_HELP = f"fit.json, robot.toml, {NAMED}, recording (.mcap), or built in: "
ROLE = "identify"
"""Role of a run that does not contain its own."""
LOADED = "payload"
"""Role of a run with a body on the flange."""
COMPARISON_CUTOFF = 25.0
"""Low-pass of the comparison of case folders [Hz], a part of their format: residuals of different programs
are comparable only behind the same filter."""


def distinct_names(names: Sequence[str]) -> list[str]:
    """The names, with a number behind each that was there before: run, run #2."""
    found: list[str] = []
    for name in names:
        number, free = 1, name
        while free in found:
            number += 1
            free = f"{name} #{number}"
        found.append(free)
    return found


def renamed(named: Iterable[Named]) -> list[Named]:
    """The same by names that differ."""
    every = list(named)
    names = distinct_names([one.name for one in every])
    return [replace(one, name=name) for one, name in zip(every, names, strict=True)]


def role_words(role: str) -> str:
    """What a run is for, as a person reads it."""
    return "held out" if role == HELD_OUT else role


ARM_HELP += ", ".join(builtin_names())


def read_arm(source: str) -> Model:
    """The model of a robot file, the one that a fit identified, or the one inside a recording.

    Raises:
        RobotError: A robot file that is none, or is wrong.
        NotAFile: A fit or a recording that cannot be read.
        FitError: A fit that no arm which can exist is near.
    """
    if source.endswith(".mcap"):
        return read_recording(source).model
    return identified(read_fit(source)) if source.endswith(".json") else read_model(source)


@dataclass
class PayloadRun:
    """One --payload and the numbers that followed it.

    Attributes:
        path: The run.
        numbers: "mass" [kg], "com" [m] and "inertia" [kg m^2], as `known_parameters` takes them.
    """

    path: Path
    numbers: dict[str, Any] = field(default_factory=dict)

    def known(self) -> tuple[tuple[str, float], ...]:
        """What is known of the body; empty without numbers.

        Raises:
            NeedsPayload: A centre of mass or inertia without mass.
        """
        if not self.numbers:
            return ()
        if "mass" not in self.numbers:
            raise NeedsPayload(
                f"--payload {self.path}: {' and '.join(self.numbers)} given without --mass [kg]"
            )
        return known_parameters(**self.numbers)


class _OfLastPayload(argparse.Action):
    """--mass, --com, --inertia: belong to the last --payload."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Add the number to the run."""
        if not namespace.payload:
            parser.error(f"{option_string} belongs behind the --payload whose body it describes")
        name = str(option_string).lstrip("-")
        numbers = namespace.payload[-1].numbers
        if name in numbers:
            parser.error(f"--payload {namespace.payload[-1].path} has {option_string} twice")
        numbers[name] = values


PAYLOADS = (
    Option(
        "--payload RUN",
        "run with a body on the flange; may be repeated, each with its own --mass",
        lambda path: PayloadRun(Path(path)),
        [],
        repeated=True,
    ),
    Option("--mass KG", "mass of that body [kg]", any_number, dest="payload", action=_OfLastPayload),
    Option(
        "--com X Y Z",
        "its centre of mass in the flange's frame [m]",
        any_number,
        dest="payload",
        action=_OfLastPayload,
    ),
    Option(
        "--inertia XX XY XZ YY YZ ZZ",
        "its inertia about the centre of mass, in the flange's axes [kg m^2]",
        any_number,
        dest="payload",
        action=_OfLastPayload,
    ),
)
"""Runs with a payload, and what may follow each."""


def carrying(recording: Recording, run: PayloadRun) -> Recording:
    """The recording with the body of the command line, or with the one that it brings.

    Raises:
        NeedsPayload: Nothing is known of the body.
    """
    known = run.known()
    if known:
        name = recording.payload.name if recording.payload else "L"
        return replace(recording, payload=KnownPayload(name, known))
    if recording.payload is not None and recording.payload.known:
        return recording
    if "torque" not in recording.signals and np.all(recording.robot.drive_gain == 1.0):
        raise NeedsPayload(
            f"--payload {run.path}: neither the file nor the command line gives the mass of the payload, and "
            "from currents of unknown drive gains no mass can be told. Add --mass KG behind it, or state the "
            "drives: [drive] gain in robot.toml"
        )
    return replace(recording, payload=KnownPayload("L", ()))


def distinct_bodies(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings with one name a body: bodies of which different things are known get different names."""
    names: dict[tuple, str] = {}
    named = []
    for recording in recordings:
        if recording.payload is not None:
            body = recording.payload.name, recording.payload.known
            if body not in names:
                numbered = (f"{body[0]}{number}" for number in count(2))
                names[body] = next(name for name in chain(body[:1], numbered) if name not in names.values())
            recording = replace(recording, payload=KnownPayload(names[body], body[1]))
        named.append(recording)
    return named


class Case(NamedTuple):
    """One nominal robot and its runs.

    Attributes:
        name: Name of the case, or of the robot where it has none.
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
    return Case(name, nominal_model(folder), [(run.settings.get("role") or ROLE, run) for run in recordings])


def recorded_case(given: argparse.Namespace) -> Case:
    """The robot and the runs of a command line; without a robot, the one in the recordings.

    Raises:
        RecordingError: There are no runs.
    """
    model = read_model(given.sources[0]) if _is_robot(given.sources[0]) else None
    runs = [
        (recording.settings.get("role") or ROLE, recording)
        for source in given.sources[0 if model is None else 1 :]
        for recording in import_source(Path(source), model)
    ]
    for role in ("slow", "validate"):
        runs += [(role, one) for path in getattr(given, role) for one in import_source(path, model)]
    for run in given.payload:
        runs += [(LOADED, carrying(one, run)) for one in import_source(run.path, model)]
    if not runs:
        raise RecordingError("a robot and no run: give at least one recording behind it")
    named = distinct_bodies([recording for _, recording in runs])
    roles = [role for role, _ in runs]
    model = model or same_robot(named)
    return Case(model.robot.name, model, list(zip(roles, named, strict=True)))
