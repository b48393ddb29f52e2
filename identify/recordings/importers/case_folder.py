"""A folder with case.toml: a nominal robot with tolerances, and its runs as tables."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from ...arm.robot import Limits, Robot
from ...effects import (
    CoulombFriction,
    CurrentOffset,
    Effect,
    JointEffect,
    Prior,
    RigidBody,
    RotorInertia,
    SpringBalancer,
    ViscousFriction,
    known_parameters,
)
from ...errors import ExidynError, NotAFile, RecordingError, RobotError
from ...model import Model
from ...robot_files import toml_fields as toml
from ...robot_files.description import read_kinematics
from ..recording import KnownPayload, Recording
from ..tables.import_table import import_table
from ..tables.table import read_csv

FORMAT = 1

WITHIN = 3.0**-0.5
"""Standard deviation over tolerance if the value is certainly within it, uniformly distributed."""
GUESSED = 1.0
"""Standard deviation over tolerance of friction, which is only a guess: its formula is approximate."""
JOINT_TERMS: dict[str, tuple[type[JointEffect], str, str, str, float]] = {
    "rotor_inertia": (RotorInertia, "Ia", "rotor_inertia", "rotor_inertia_tolerance", WITHIN),
    "viscous": (ViscousFriction, "Fv", "friction_viscous", "friction_tolerance", GUESSED),
    "coulomb": (CoulombFriction, "Fc", "friction_coulomb", "friction_tolerance", GUESSED),
    "offset": (CurrentOffset, "Off", "", "", GUESSED),
}
"""Term -> effect, name of its parameters, keys of their believed values and of their tolerance, and standard
deviation over that tolerance; offsets have no values."""

SPRING = ("d21", "d22", "phi")
"""Keys of the geometry of a balancer."""


def import_case_folder(source: Path, model: Model | None = None, role: str | None = None) -> list[Recording]:
    """Import the runs of a case, each with the nominal model that the case states.

    Args:
        source: Path of the folder, or of its case.toml.
        model: Model that replaces the model of the case.
        role: Role of the runs to import; by default all.
    """
    folder = source if source.is_dir() else source.parent
    case = _read(folder / "case.toml")
    model = model or nominal_model(folder)
    with _of(folder):
        name = toml.string(_table(case, "case")["name"], "[case] name")
        runs = [_run(run) for run in toml.rows(case, "runs")]
    return [
        recording
        for file, known in runs
        if role in (None, known["settings"].get("role"))
        for recording in import_table(
            read_csv, folder / file, model, name=f"{name}/{Path(file).name.split('.')[0]}", **known
        )
    ]


def nominal_model(folder: Path) -> Model:
    """Nominal model of a case, with priors from its tolerances."""
    case = _read(folder / "case.toml")
    with _of(folder):
        path = folder / toml.string(_table(case, "robot")["urdf"], "[robot] urdf")
    kinematics = read_kinematics(path).model
    with _of(folder):
        robot = _robot(case, kinematics)
        return _model(robot, _table(case, "believed"))


@contextmanager
def _of(folder: Path) -> Iterator[None]:
    """Context in which errors get the name of the file."""
    where = folder / "case.toml"
    try:
        yield
    except KeyError as error:
        raise RecordingError(f"{where}: key {error} is missing") from error
    except ExidynError as error:
        raise RecordingError(f"{where}: {error}") from error


def _read(path: Path) -> dict[str, Any]:
    try:
        case = toml.parse_toml(toml.read_text(path), str(path))
    except RobotError as error:
        raise NotAFile(str(error)) from error
    table = case.get("case")
    version = table.get("format") if isinstance(table, Mapping) else None
    if version != FORMAT:
        raise NotAFile(f"{path}: [case] format is {version}; this version reads {FORMAT}")
    return case


def _table(table: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """A table inside a table."""
    if not isinstance(table[key], Mapping):
        raise RecordingError(f"[{key}] is {table[key]!r}; expected a table")
    return table[key]


def _robot(case: Mapping[str, Any], kinematics: pin.Model) -> Robot:
    believed, limits, n = _table(case, "believed"), _table(case, "limits"), kinematics.nv
    gravity = toml.numbers(believed["gravity"], 3, "[believed] gravity")
    kinematics.gravity = pin.Motion(gravity, np.zeros(3))
    keys = ("position_lower", "position_upper", "velocity", "acceleration", "torque")
    known = {key: toml.numbers(limits[key], n, f"[limits] {key}", infinite=True) for key in keys}
    drive = {key: toml.numbers(believed[key], n, f"[believed] {key}") for key in ("drive_gain", "gear_ratio")}
    for key, values in drive.items():
        if not np.all(values):
            raise RecordingError(
                f"[believed] {key}: {values.tolist()} has a zero; give 1 where it is unknown"
            )
    return Robot(
        name=toml.string(_table(case, "robot")["name"], "[robot] name"),
        kinematics=kinematics,
        limits=Limits(jerk=np.full(n, np.inf), **known),
        drive_gain_tolerance=np.full(n, WITHIN * _tolerance(believed, "drive_gain_tolerance")),
        drive_gain_bounded=True,
        inertial_tolerance=WITHIN * _tolerance(believed, "inertial_tolerance"),
        drive_gain=drive["drive_gain"],
        gear_ratio=drive["gear_ratio"],
    )


def _tolerance(believed: Mapping[str, Any], key: str) -> float:
    return toml.number(believed[key], f"[believed] {key}", 0.0)


def _model(robot: Robot, believed: Mapping[str, Any]) -> Model:
    effects: list[Effect] = [RigidBody()]
    stated: dict[str, Prior] = {}
    bounded: set[str] = set()
    terms = _table(believed, "terms")
    for term, (kind, name, values, tolerance, share) in JOINT_TERMS.items():
        present = np.flatnonzero(_flags(terms[term], robot.dof, f"[believed.terms] {term}")).tolist()
        if present:
            effects.append(kind(tuple(robot.joints[joint] for joint in present)))
        if present and values:
            nominal = toml.numbers(believed[values], robot.dof, f"[believed] {values}").tolist()
            std = share * _tolerance(believed, tolerance)
            term_priors = {f"{name}{joint + 1}": _prior(nominal[joint], std) for joint in present}
            stated |= term_priors
            bounded |= term_priors.keys() if share == WITHIN else set()
    if toml.boolean(terms["balancer"], "[believed.terms] balancer"):
        spring, term_priors = _balancer(robot, _table(believed, "balancer"), believed)
        effects.append(spring)
        stated |= term_priors
        bounded |= term_priors.keys()
    return Model(robot, tuple(effects), stated, frozenset(bounded))


def _flags(value: object, count: int, where: str) -> list[bool]:
    """True or false for each joint."""
    if not isinstance(value, list) or len(value) != count:
        raise RecordingError(f"{where}: expected true or false for each of {count} joints; found {value!r}")
    return [toml.boolean(flag, where) for flag in value]


def _balancer(
    robot: Robot, balancer: Mapping[str, Any], believed: Mapping[str, Any]
) -> tuple[SpringBalancer, dict[str, Prior]]:
    values = {key: toml.number(balancer[key], f"[believed.balancer] {key}") for key in (*SPRING, "Kr", "K0")}
    joint = toml.integer(balancer["joint"], "[believed.balancer] joint", 1)
    if joint > robot.dof:
        raise RecordingError(f"[believed.balancer] joint: {joint}, but the robot has {robot.dof}")
    # Without its own tolerance, the spring is as well known as the masses that it carries.
    tolerance = toml.number(
        balancer.get("tolerance", believed["inertial_tolerance"]), "[believed.balancer] tolerance", 0.0
    )
    effect = SpringBalancer(robot.joints[joint - 1], **{key: values[key] for key in SPRING})
    return effect, {name: _prior(values[name], WITHIN * tolerance) for name in ("Kr", "K0")}


def _prior(value: float, tolerance: float) -> Prior:
    """Prior from a relative tolerance; the standard deviation of a value of zero is infinite."""
    return Prior(value, tolerance * abs(value) if value else np.inf)


def _run(run: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """File of a run, and its payload and settings as arguments of `import_table`."""
    settings = {key: str(value) for key, value in run.items() if key not in ("file", "payload")}
    payload = KnownPayload("L", _known(_table(run, "payload"))) if "payload" in run else None
    return toml.string(run["file"], "[[runs]] file"), {"payload": payload, "settings": settings}


def _known(payload: Mapping[str, Any]) -> tuple[tuple[str, float], ...]:
    com, inertia = (
        toml.numbers(payload[key], count, f"[[runs]] payload {key}").tolist() if key in payload else None
        for key, count in (("com", 3), ("inertia", 6))
    )
    return known_parameters(toml.number(payload["mass"], "[[runs]] payload mass"), com, inertia)
