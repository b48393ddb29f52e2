"""Inputs of commands: an arm, and runs with payloads, roles and distinct names."""

import argparse
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, count
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from exidyn.identification.diagnosis.findings.evidence import Trace
from exidyn.identification.errors import NeedsPayload, RecordingError
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.fit.identification import same_robot
from exidyn.identification.fit.identified import identified
from exidyn.identification.model import Model
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.description import ENDINGS, NAMED
from exidyn.identification.robot_files.robot_file import builtin_names, read_model

from ..arguments.command import Option, WrongUse, any_number
from ..arguments.run_options import known_body

Named = TypeVar("Named", Recording, Trace)
ARM_HELP = f"fit.json, robot.toml, {NAMED}, recording (.mcap), or built in: {', '.join(builtin_names())}"
ROLE = "identify"
"""Role of a run that does not state one."""
LOADED = "payload"
"""Role of a run with a payload on the flange."""


def distinct_names(names: Sequence[str]) -> list[str]:
    """The names, each repeated one with a number: run, run #2."""
    distinct: list[str] = []
    for name in names:
        number, free = 1, name
        while free in distinct:
            number += 1
            free = f"{name} #{number}"
        distinct.append(free)
    return distinct


def renamed(named: Iterable[Named]) -> list[Named]:
    """The runs with distinct names."""
    runs = list(named)
    names = distinct_names([run.name for run in runs])
    return [replace(run, name=name) for run, name in zip(runs, names, strict=True)]


def read_arm(source: str) -> Model:
    """The model of a robot file, of a fit, or of a recording.

    Raises:
        RobotError: If the robot file is of another kind or wrong.
        NotAFile: If the fit or the recording cannot be read.
        FitError: If no physically consistent arm is near the fit.
    """
    if source.endswith(".mcap"):
        return read_recording(source).model
    return identified(read_fit(source)) if source.endswith(".json") else read_model(source)


def read_runs(paths: Iterable[Path], model: Model | None, **options: Any) -> list[Recording]:
    """Recordings in files or folders; see `import_source` for the arguments and errors."""
    return [recording for path in paths for recording in import_source(path, model, **options)]


def single_recording(path: Path, model: Model | None) -> Recording:
    """The only recording at a path."""
    recordings = import_source(path, model)
    if len(recordings) != 1:
        names = ", ".join(recording.name for recording in recordings)
        raise RecordingError(
            f"{path} holds {len(recordings)} recordings: {names or 'none'}; write the intended one to a "
            "separate file with exidyn import"
        )
    return recordings[0]


@dataclass
class PayloadRun:
    """One --payload and the numbers that follow it."""

    path: Path  # path of the run
    # Keyword arguments of `known_parameters`: "mass" [kg], "com" [m], "inertia" [kg m^2].
    numbers: dict[str, Any] = field(default_factory=dict)


class _OfLastPayload(argparse.Action):
    """Assigns --mass, --com and --inertia to the last --payload."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        """Add the number to the run."""
        if not namespace.payload:
            parser.error(f"{option_string} must follow the --payload that it describes")
        name = str(option_string).lstrip("-")
        numbers = namespace.payload[-1].numbers
        if name in numbers:
            parser.error(f"--payload {namespace.payload[-1].path} has {option_string} twice")
        numbers[name] = values


PAYLOADS = (
    Option(
        "--payload RUN",
        "run with a payload on the flange; may be repeated, each with its own --mass",
        lambda path: PayloadRun(Path(path)),
        [],
        repeated=True,
    ),
    *(
        Option(form, meaning, any_number, dest="payload", action=_OfLastPayload)
        for form, meaning in (
            ("--mass KG", "mass of that payload [kg]"),
            ("--com X Y Z", "its center of mass in the flange frame [m]"),
            (
                "--inertia XX XY XZ YY YZ ZZ",
                "its inertia about the center of mass, along the flange axes [kg m²]",
            ),
        )
    ),
)
"""Options of runs with a payload."""


def carrying(recording: Recording, run: PayloadRun) -> Recording:
    """The recording with the payload of the command line, or else with the recorded payload.

    Raises:
        NeedsPayload: If the mass is unknown and cannot be identified.
    """
    known = known_body(run.numbers, f"--payload {run.path}: ")
    if known:
        name = recording.payload.name if recording.payload else "L"
        return replace(recording, payload=KnownPayload(name, known))
    if recording.payload is not None and recording.payload.known:
        return recording
    if "torque" not in recording.signals and np.all(recording.robot.drive_gain == 1.0):
        raise NeedsPayload(
            f"--payload {run.path}: its mass is unknown, and currents with unknown drive gains do not "
            "determine it. Add --mass KG after this --payload, or state the drive gains: [drive] gain in "
            "robot.toml"
        )
    return replace(recording, payload=KnownPayload("L", ()))


def distinct_bodies(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings with one name per payload: different known parameters mean different payloads."""
    names: dict[tuple, str] = {}
    named = []
    for recording in recordings:
        if recording.payload is not None:
            name, known = key = recording.payload.name, recording.payload.known
            if key not in names:
                numbered = (f"{name}{number}" for number in count(2))
                names[key] = next(free for free in chain([name], numbered) if free not in names.values())
            recording = replace(recording, payload=KnownPayload(names[key], known))
        named.append(recording)
    return named


def recorded_case(args: argparse.Namespace) -> tuple[Model, list[tuple[str, Recording]]]:
    """The nominal model, and role and recording of each run; without --robot, the robot in the recordings.

    Raises `WrongUse` if the robot is given among the runs.
    """
    _refuse_robot_among_runs(args)
    model = read_model(args.robot) if args.robot else None
    runs = [(run.settings.get("role") or ROLE, run) for run in read_runs(args.runs, model)]
    for role in ("slow", "validate"):
        runs += [(role, run) for run in read_runs(getattr(args, role), model)]
    for loaded in args.payload:
        runs += [(LOADED, carrying(run, loaded)) for run in read_runs([loaded.path], model)]
    named = distinct_bodies([recording for _, recording in runs])
    roles = [role for role, _ in runs]
    return model or same_robot(named), list(zip(roles, named, strict=True))


def _refuse_robot_among_runs(args: argparse.Namespace) -> None:
    """Raise with the command to type, since --robot names the robot."""
    for path in args.runs:
        if str(path) in builtin_names() or path.suffix in (".toml", *ENDINGS):
            others = [run for run in args.runs if run != path] or [Path("RUN")]
            corrected = diagnose_words(argparse.Namespace(**vars(args) | {"runs": others}), str(path))
            raise WrongUse(f"{path} is a robot, not a run; type: exidyn {corrected}")


def diagnose_words(args: argparse.Namespace, robot: str | None) -> str:
    """The command, without "exidyn", that diagnoses the runs of a command line."""
    words = ["diagnose", *args.runs]
    for role in ("slow", "validate"):
        words += [f"--{role}", *paths] if (paths := getattr(args, role, [])) else []
    for run in args.payload:
        words += ["--payload", run.path]
        for name, value in run.numbers.items():
            words += [f"--{name}", *(f"{number:g}" for number in np.ravel(value))]
    words += ["--robot", robot] if robot else []
    return shlex.join(map(str, words))
