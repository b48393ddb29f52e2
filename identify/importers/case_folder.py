"""A folder with case.toml: a robot as believed, how well, and its runs as tables."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from ..effects import (
    Belief,
    CoulombFriction,
    CurrentOffset,
    Effect,
    JointEffect,
    RigidBody,
    RotorInertia,
    SpringBalancer,
    ViscousFriction,
    known_parameters,
)
from ..errors import NotAFile, RecordingError
from ..model import Model
from ..recording import KnownPayload, Recording
from ..robot import Limits, Robot
from ..urdf import parse_urdf
from .csv_file import import_csv

FORMAT = 1

WITHIN = 3.0**-0.5
"""Standard deviation over the tolerance of what is true within it, all values there being as likely."""
GUESSED = 1.0
"""The same of friction, which is a guess besides: its formula is not quite the arm's."""
JOINT_TERMS: dict[str, tuple[type[JointEffect], str, str, str, float]] = {
    "rotor_inertia": (RotorInertia, "Ia", "rotor_inertia", "rotor_inertia_tolerance", WITHIN),
    "viscous": (ViscousFriction, "Fv", "friction_viscous", "friction_tolerance", GUESSED),
    "coulomb": (CoulombFriction, "Fc", "friction_coulomb", "friction_tolerance", GUESSED),
    "offset": (CurrentOffset, "Off", "", "", GUESSED),
}
"""Term -> effect, name of its parameters, keys of their believed values and of their tolerance, and standard
deviation over that tolerance; offsets have none."""


def import_case_folder(source: Path, model: Model | None = None, role: str | None = None) -> list[Recording]:
    """Import the runs of a case, each with the believed model that the case states.

    Args:
        source: The folder, or its case.toml.
        model: Instead of the model that the case states.
        role: Only the runs of this role.

    Raises:
        NotAFile: There is no case.toml, or it is not one.
        RecordingError: A run is not what the case says.
    """
    folder = source if source.is_dir() else source.parent
    case = _read(folder / "case.toml")
    model = model or believed_model(folder)
    runs = [run for run in case.get("runs", []) if role in (None, run.get("role"))]
    return [_recording(folder, case, run, model) for run in runs]


def believed_model(folder: Path) -> Model:
    """The model that a case states, with its beliefs, which are true within the tolerances it gives.

    Raises:
        NotAFile: There is no case.toml, or it is not one.
        RecordingError: It lacks a key.
    """
    case = _read(folder / "case.toml")
    try:
        robot = _robot(folder, case)
        return _model(robot, case["believed"])
    except KeyError as error:
        raise RecordingError(f"{folder}/case.toml: key {error} is missing") from error


def _read(path: Path) -> dict[str, Any]:
    try:
        case = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise NotAFile(f"{path} cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise NotAFile(f"{path} is not TOML: {error}") from error
    found = case.get("case", {}).get("format")
    if found != FORMAT:
        raise NotAFile(f"{path}: [case] format is {found}; this version reads {FORMAT}")
    return case


def _robot(folder: Path, case: Mapping[str, Any]) -> Robot:
    path = folder / case["robot"]["urdf"]
    try:
        kinematics = parse_urdf(path.read_text(encoding="utf-8"), str(path)).model
    except OSError as error:
        raise NotAFile(f"{path} cannot be read: {error.strerror}") from error
    believed, limits = case["believed"], case["limits"]
    kinematics.gravity = pin.Motion(np.array(believed["gravity"], float), np.zeros(3))
    keys = ("position_lower", "position_upper", "velocity", "acceleration", "torque")
    known = {key: np.array(limits[key], float) for key in keys}
    return Robot(
        name=case["robot"]["name"],
        kinematics=kinematics,
        limits=Limits(jerk=np.full(kinematics.nv, np.inf), **known),
        drive_gain=np.array(believed["drive_gain"], float),
        drive_gain_tolerance=WITHIN * believed["drive_gain_tolerance"],
        inertial_tolerance=WITHIN * believed["inertial_tolerance"],
        gear_ratio=np.array(believed["gear_ratio"], float),
    )


def _model(robot: Robot, believed: Mapping[str, Any]) -> Model:
    effects: list[Effect] = [RigidBody()]
    stated: dict[str, Belief] = {}
    for term, (effect, name, values, tolerance, share) in JOINT_TERMS.items():
        present = [joint for joint, there in enumerate(believed["terms"][term]) if there]
        if present:
            effects.append(effect(tuple(robot.joints[joint] for joint in present)))
        for joint in present if values else []:
            stated[f"{name}{joint + 1}"] = _belief(believed[values][joint], share * believed[tolerance])
    if believed["terms"]["balancer"]:
        balancer = believed["balancer"]
        shape = {key: balancer[key] for key in ("d21", "d22", "phi")}
        effects.append(SpringBalancer(robot.joints[balancer["joint"] - 1], **shape))
        # The case gives no tolerance for the spring: it is as well known as the masses it carries.
        tolerance = balancer.get("tolerance", believed["inertial_tolerance"])
        stated |= {name: _belief(balancer[name], WITHIN * tolerance) for name in ("Kr", "K0")}
    return Model(robot, tuple(effects), stated)


def _belief(value: float, tolerance: float) -> Belief:
    """A value and its deviation; a relative tolerance says nothing about a value of zero."""
    return Belief(value, tolerance * abs(value) if value else np.inf)


def _recording(folder: Path, case: Mapping[str, Any], run: Mapping[str, Any], model: Model) -> Recording:
    payload = run.get("payload")
    known = known_parameters(payload["mass"], payload.get("com"), payload.get("inertia")) if payload else ()
    stem = Path(run["file"]).name.split(".")[0]
    [recording] = import_csv(
        folder / run["file"],
        model,
        name=f"{case['case']['name']}/{stem}",
        payload=KnownPayload("L", known) if payload else None,
        settings={key: str(value) for key, value in run.items() if key not in ("file", "payload")},
    )
    return recording
