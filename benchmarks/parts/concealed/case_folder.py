"""Reads the folder of a case: a nominal robot with tolerances in case.toml, and its runs as tables."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import (
    CoulombFriction,
    CurrentOffset,
    Effect,
    Prior,
    RigidBody,
    RotorInertia,
    SpringBalancer,
    ViscousFriction,
    known_parameters,
)
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.recordings.tables.import_table import import_table
from exidyn.identification.recordings.tables.table import read_csv
from exidyn.identification.robot_files.description import read_kinematics

WITHIN = 3.0**-0.5
"""Standard deviation over tolerance if the value is certainly within it, uniformly distributed."""
GUESSED = 1.0
"""Standard deviation over tolerance of friction, which is only a guess: its formula is approximate."""
JOINT_TERMS = {
    "rotor_inertia": (RotorInertia, "Ia", "rotor_inertia", "rotor_inertia_tolerance", WITHIN),
    "viscous": (ViscousFriction, "Fv", "friction_viscous", "friction_tolerance", GUESSED),
    "coulomb": (CoulombFriction, "Fc", "friction_coulomb", "friction_tolerance", GUESSED),
    "offset": (CurrentOffset, "Off", "", "", GUESSED),
}
"""Term -> effect, name of its parameters, keys of their believed values and of their tolerance, and standard
deviation over that tolerance; offsets have no values."""


def read_case(folder: Path) -> list[Recording]:
    """The runs of a case with its nominal model and known payloads; their settings state their roles."""
    case = tomllib.loads((folder / "case.toml").read_text())
    kinematics = read_kinematics(folder / case["robot"]["urdf"]).model
    believed = case["believed"]
    model = _model(_robot(case, kinematics), believed)
    runs: list[Recording] = []
    for run in case["runs"]:
        name = f"{case['case']['name']}/{Path(run['file']).name.split('.')[0]}"
        payload = KnownPayload("L", known_parameters(**run["payload"])) if "payload" in run else None
        settings = {key: str(value) for key, value in run.items() if key not in ("file", "payload")}
        file = folder / run["file"]
        runs += import_table(read_csv, file, model, name=name, payload=payload, settings=settings)
    return runs


def _robot(case: Mapping[str, Any], kinematics: pin.Model) -> Robot:
    believed, n = case["believed"], kinematics.nv
    kinematics.gravity = pin.Motion(np.array(believed["gravity"]), np.zeros(3))
    keys = ("position_lower", "position_upper", "velocity", "acceleration", "torque")
    limits = {key: np.array(case["limits"][key], float) for key in keys}
    return Robot(
        name=case["robot"]["name"],
        kinematics=kinematics,
        limits=Limits(jerk=np.full(n, np.inf), **limits),
        drive_gain_tolerance=np.full(n, WITHIN * believed["drive_gain_tolerance"]),
        drive_gain_bounded=True,
        inertial_tolerance=WITHIN * believed["inertial_tolerance"],
        drive_gain=np.array(believed["drive_gain"], float),
        gear_ratio=np.array(believed["gear_ratio"], float),
    )


def _model(robot: Robot, believed: Mapping[str, Any]) -> Model:
    effects: list[Effect] = [RigidBody()]
    stated: dict[str, Prior] = {}
    bounded: set[str] = set()
    terms = believed["terms"]
    for term, (kind, name, values, tolerance, share) in JOINT_TERMS.items():
        present = np.flatnonzero(terms[term]).tolist()
        if present:
            effects.append(kind(tuple(robot.joints[joint] for joint in present)))
        if present and values:
            std = share * believed[tolerance]
            priors = {f"{name}{joint + 1}": _prior(believed[values][joint], std) for joint in present}
            stated |= priors
            bounded |= priors.keys() if share == WITHIN else set()
    if terms["balancer"]:
        spring = believed["balancer"]
        geometry = {key: spring[key] for key in ("d21", "d22", "phi")}
        effects.append(SpringBalancer(robot.joints[spring["joint"] - 1], **geometry))
        # Without its own tolerance, the spring is as well known as the masses that it carries.
        std = WITHIN * spring.get("tolerance", believed["inertial_tolerance"])
        priors = {name: _prior(spring[name], std) for name in ("Kr", "K0")}
        stated |= priors
        bounded |= priors.keys()
    return Model(robot, tuple(effects), stated, frozenset(bounded))


def _prior(value: float, tolerance: float) -> Prior:
    """Prior from a relative tolerance; the standard deviation of a value of zero is infinite."""
    return Prior(value, tolerance * abs(value) if value else np.inf)
