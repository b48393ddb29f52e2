r"""Modified Denavit-Hartenberg tables (Khalil): geometry and standard parameters, row by row.

The placement of frame j in its antecedent's frame is

.. math::
    T = R_x(\alpha)\, T_x(d)\, R_z(\theta + q)\, T_z(r)
    \quad\text{or, for a prismatic joint,}\quad
    T = R_x(\alpha)\, T_x(d)\, R_z(\theta)\, T_z(r + q).
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from ..arm.rigid_regressor import INERTIAL
from ..arm.robot import FLANGE
from ..errors import BrokenTree, RobotError
from .kinematics import (
    Kinematics,
    Part,
    add_joint,
    body_doubts,
    inertia_elements,
    inertia_matrix,
    rigid_inertia,
)
from .toml_fields import boolean, check_keys, number, parse_toml, string, tables

GEOMETRY = ("alpha", "d", "theta_offset", "r")
ANGLES = ("alpha", "theta_offset")
TURN = 2 * np.pi
"""Largest angle that a table may need [rad]; angles in degrees, such as 90, are far above."""
ROW_KEYS = ("joint", "antecedent", "sigma", "degrees", *GEOMETRY, *INERTIAL, "Ia")
CONVENTION = "mdh-khalil"
SIGMA = {0: "revolute", 1: "prismatic", 2: "fixed"}


def parse_mdh(text: str, name: str, where: str = "modified-DH file") -> Kinematics:
    """Kinematics from a file of `[[link]]` rows with `convention = "mdh-khalil"`."""
    table = parse_toml(text, where)
    check_keys(table, ("convention", "link"), where)
    if table.get("convention", CONVENTION) != CONVENTION:
        raise RobotError(f"{where}: convention {table['convention']!r}; only '{CONVENTION}' is known")
    return mdh_kinematics(tables(table.get("link"), "link"), name)


def mdh_kinematics(rows: Sequence[Mapping[str, Any]], name: str) -> Kinematics:
    """Kinematics from the rows of a modified-DH table; the last fixed row is the flange."""
    model = pin.Model()
    model.name = name
    frames: dict[str, Part] = {}
    fixed: list[Part] = []
    rotors: dict[str, float] = {}
    for place, row in enumerate(rows):
        label = _label(row, place, frames)
        where = f"mdh row {place + 1} ({label})"
        frame = _antecedent(row, place, frames, where)
        frame = Part(frame.joint, frame.placement * _transform(row, where))
        sigma = row.get("sigma", 0)
        if not isinstance(sigma, int) or sigma not in SIGMA:
            raise RobotError(f"{where}: sigma {sigma!r}; valid: 0 (revolute), 1 (prismatic), 2 (fixed)")
        kind = SIGMA[sigma]
        if kind == "fixed":
            fixed.append(frame)
            if "Ia" in row:
                raise RobotError(f"{where}: Ia belongs to a joint that moves; sigma 2 is fixed")
        else:
            joint = pin.JointModelRZ() if kind == "revolute" else pin.JointModelPZ()
            index = add_joint(model, frame.joint, joint, frame.placement, label, f"link{model.njoints}")
            frame = Part(index, pin.SE3.Identity())
            if "Ia" in row:
                rotors[label] = number(row["Ia"], f"{where} Ia", low=0.0)
        if frame.joint > 0:
            model.appendBodyToJoint(frame.joint, _body(row, where), frame.placement)
        frames[label] = frame
    last = [frame.placement for frame in fixed if frame.joint == model.njoints - 1]
    flange = (last[-1], FLANGE) if last else (pin.SE3.Identity(), f"link{model.njoints - 1}")
    return Kinematics(model, None, *flange, rotors, body_doubts(model))


def _label(row: Mapping[str, Any], place: int, frames: Mapping[str, Part]) -> str:
    check_keys(row, ROW_KEYS, f"mdh row {place + 1}")
    joint = row.get("joint", place + 1)
    label = f"joint{joint}" if isinstance(joint, int) else string(joint, f"mdh row {place + 1} joint")
    if label in frames:
        raise BrokenTree(f"mdh row {place + 1}: two rows are called '{label}'; give each its own name")
    return label


def _antecedent(row: Mapping[str, Any], place: int, frames: Mapping[str, Part], where: str) -> Part:
    """Frame of the row's antecedent, given by name or number (0: base); by default the row before."""
    names = list(frames)
    antecedent = row.get("antecedent", place)
    if isinstance(antecedent, int) and 0 <= antecedent <= place:
        antecedent = names[antecedent - 1] if antecedent else ""
    if antecedent == "":
        return Part(0, pin.SE3.Identity())
    if not isinstance(antecedent, str) or antecedent not in frames:
        raise BrokenTree(
            f"{where}: antecedent {antecedent!r} is not a row above it. Valid: 0 (base), {', '.join(names)}"
        )
    return frames[antecedent]


def _transform(row: Mapping[str, Any], where: str) -> pin.SE3:
    """Transform of a row at q = 0."""
    geometry = {key: number(row.get(key, 0.0), f"{where} {key}") for key in GEOMETRY}
    if boolean(row.get("degrees", False), f"{where} degrees"):
        geometry |= {key: float(np.radians(geometry[key])) for key in ANGLES}
    for key in ANGLES:
        if abs(geometry[key]) > TURN:
            raise RobotError(
                f"{where}: {key} is {geometry[key]:g} rad, more than a whole turn ({TURN:.4g}). If the row "
                "is in degrees, write degrees = true in it"
            )
    alpha, d, theta, r = geometry.values()
    tilt = pin.SE3(pin.rpy.rpyToMatrix(alpha, 0.0, 0.0), np.zeros(3))
    turn = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, theta), np.array([d, 0.0, 0.0]))
    return tilt * turn * pin.SE3(np.eye(3), np.array([0.0, 0.0, r]))


def _body(row: Mapping[str, Any], where: str) -> pin.Inertia:
    """Inertia from standard parameters about the row's frame; XY is the matrix element, -integral xy dm."""
    *inertia, mx, my, mz, m = (number(row.get(key, 0.0), f"{where} {key}") for key in INERTIAL)
    if m == 0:
        if any((*inertia, mx, my, mz)):
            raise RobotError(
                f"{where}: M is 0 but other parameters are not; give standard parameters of a body with "
                "mass, not base parameters"
            )
        return pin.Inertia.Zero()
    center = np.array([mx, my, mz]) / m
    about_origin = inertia_matrix(inertia)
    shift = m * (center @ center * np.eye(3) - np.outer(center, center))
    try:
        return rigid_inertia(m, center, inertia_elements(about_origin - shift), where)
    except BrokenTree as error:
        raise BrokenTree(f"{error}. {_hint(about_origin, shift)}") from error


def _hint(about_origin: np.ndarray, shift: np.ndarray) -> str:
    """Hint about moments of inertia that are too small for the mass and its distance from the origin.

    Inertias are about the origin of the row's frame: in the row, and of the mass alone, (3, 3) [kg m^2].
    """
    small = [
        f"{name} is {about_origin[k, k]:g}, but M, MX, MY, MZ alone make {shift[k, k]:g}"
        for k, name in enumerate(("XX", "YY", "ZZ"))
        if about_origin[k, k] < shift[k, k]
    ]
    why = "; ".join(small) or "XX, YY or ZZ is too small, or XY, XZ or YZ too large"
    return f"A row's XX ... ZZ are about the origin of its frame, not about the center of mass: {why}"
