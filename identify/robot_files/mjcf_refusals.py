"""Refusal of the content of an MJCF that no model can represent."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..errors import RobotError
from .mjcf_dcmotors import is_dc_motor, require_readable
from .mjcf_elements import HOLD, actuators, drives_joint, enum_of, joint_equalities, joint_name, name_of

ROUNDING = 1e-12
"""Largest difference between shares of gravity that is due to rounding."""


def check_mjcf(model: Any, parts: Sequence[int], joints: Sequence[int], where: str) -> None:
    """Refuse forces and constraints that act neither on a single joint nor on rigid bodies.

    `parts` are the indices of the joint that moves each body, 0 for the base; `joints` those that move.
    """
    for check in (_unknown_forces, _springs, _equalities, _tendons, _actuators):
        for refused in check(model, parts, set(joints)):
            raise RobotError(f"{where}: {refused}")


def _unknown_forces(model: Any, parts: Sequence[int], joints: set[int]) -> Iterator[str]:
    for name in ("density", "viscosity"):
        if value := getattr(model.opt, name):
            yield f"option {name}={value:g}: models have no fluid drag. Set it to 0"
    if model.nflex:
        yield "flex: models have no soft bodies. Remove it"
    for kind in ("body", "actuator"):
        for index, plugin in enumerate(getattr(model, f"{kind}_plugin")):
            if plugin >= 0 and (kind == "actuator" or parts[index]):
                yield f"{kind} '{name_of(model, kind, index)}' has a plugin, whose forces are unknown"


def _springs(model: Any, parts: Sequence[int], joints: set[int]) -> Iterator[str]:
    for joint in sorted(joints):
        name, dof = joint_name(model, joint), model.jnt_dofadr[joint]
        for term, table, row in (
            ("stiffness", "jnt_stiffnesspoly", joint),
            ("damping", "dof_dampingpoly", dof),
            ("springyield", "jnt_springyield", joint),
        ):
            if np.any(_rows(model, table)[row : row + 1]):
                how = "a spring that yields" if term == "springyield" else f"{term} that is a polynomial"
                yield f"joint '{name}' has {how}; a model has one coefficient. Remove the others"


def _rows(model: Any, table: str) -> np.ndarray:
    """A table of the compiled model; empty if this version of MuJoCo does not have it."""
    return np.asarray(getattr(model, table, np.empty(0)))


def _equalities(model: Any, parts: Sequence[int], joints: set[int]) -> Iterator[str]:
    coupled = {e: {follower, leader} for e, follower, leader in joint_equalities(model)}
    for e in range(model.neq):
        name = f"equality '{name_of(model, 'equality', e)}'"
        if e in coupled:
            if coupled[e] <= joints:
                first, second = (joint_name(model, joint) for joint in sorted(coupled[e]))
                yield f"{name} couples joints '{first}' and '{second}', which no model can represent. {HOLD}"
        elif model.eq_active0[e] and _ties(model, e, parts):
            yield f"{name} closes a loop of links, or ties a tendon; a model is a tree. {HOLD}"


def _ties(model: Any, equality: int, parts: Sequence[int]) -> bool:
    """Whether an equality, other than one of joints, connects bodies that move relative to each other."""
    kind, ends = model.eq_objtype[equality], (model.eq_obj1id[equality], model.eq_obj2id[equality])
    if model.eq_type[equality] == enum_of("mjtEq", "mjEQ_JOINT"):
        return False
    if kind == enum_of("mjtObj", "mjOBJ_SITE"):
        ends = tuple(model.site_bodyid[end] for end in ends)
    elif kind != enum_of("mjtObj", "mjOBJ_BODY"):
        return True
    return len({parts[end] if end >= 0 else 0 for end in ends}) > 1


TENDON_FORCES = ("stiffness", "damping", "frictionloss", "armature", "stiffnesspoly", "dampingpoly")


def _tendons(model: Any, parts: Sequence[int], joints: set[int]) -> Iterator[str]:
    for tendon in range(model.ntendon):
        for kind in TENDON_FORCES:
            force = np.any(_rows(model, f"tendon_{kind}")[tendon : tendon + 1])
            if force and moves(model, tendon, parts, joints):
                name = name_of(model, "tendon", tendon)
                yield f"tendon '{name}' has {kind}, a force on several joints, which models lack. {HOLD}"


def moves(model: Any, tendon: int, parts: Sequence[int], joints: set[int]) -> bool:
    """Whether the length of a tendon changes when joints that are not held move."""
    start = model.tendon_adr[tendon]
    wraps = range(start, start + model.tendon_num[tendon])
    kinds = {kind: enum_of("mjtWrap", f"mjWRAP_{kind}") for kind in ("JOINT", "SITE", "SPHERE", "CYLINDER")}
    ends = set()
    for wrap in wraps:
        kind, index = model.wrap_type[wrap], int(model.wrap_objid[wrap])
        if kind == kinds["JOINT"] and index in joints:
            return True
        if kind == kinds["SITE"]:
            ends.add(parts[model.site_bodyid[index]])
        elif kind in (kinds["SPHERE"], kinds["CYLINDER"]):
            ends.add(parts[model.geom_bodyid[index]])
    return len(ends) > 1


def _actuators(model: Any, parts: Sequence[int], joints: set[int]) -> Iterator[str]:
    known = {enum_of("mjtGain", f"mjGAIN_{kind}") for kind in ("FIXED", "AFFINE")}
    by_tendon = enum_of("mjtTrn", "mjTRN_TENDON")
    for index in actuators(model):
        name, where = f"actuator '{name_of(model, 'actuator', index)}'", model.actuator_trntype[index]
        target = int(model.actuator_trnid[index][0])
        if drives_joint(model, index):
            acts = target in joints
        elif where == by_tendon:
            acts = moves(model, target, parts, joints)
            if acts and model.wrap_type[model.tendon_adr[target]] != enum_of("mjtWrap", "mjWRAP_JOINT"):
                yield f"{name} pulls a spatial tendon; a model has motors of joints. Remove it"
        else:
            of_body = where == enum_of("mjtTrn", "mjTRN_BODY")
            acts = bool(parts[target if of_body else model.site_bodyid[target]])
            if acts:
                yield f"{name} acts on a site, a body or a crank; a model has motors of joints. Remove it"
        if not acts:
            continue
        if np.any(_rows(model, "actuator_dampingpoly")[index : index + 1]):
            yield f"{name} has damping that is a polynomial; a model has one coefficient. Remove the others"
        if is_dc_motor(model, index):
            yield from require_readable(model, index, name)
        elif model.actuator_gaintype[index] not in known:
            yield f"{name} has its own physics; make it a motor, position, velocity or dcmotor"


def gravity_share(model: Any, parts: Sequence[int], joints: Sequence[int], where: str) -> float:
    """Share of gravity that `gravcomp` leaves to the motors: the same for all bodies and joints."""
    bodies = [body for body in range(model.nbody) if parts[body] and model.body_mass[body] > 0.0]
    shares = [float(model.body_gravcomp[body]) for body in bodies]
    passive = {not model.jnt_actgravcomp[joint] for joint in joints}
    if not any(shares) or passive == {False}:
        return 1.0
    if max(shares) - min(shares) > ROUNDING:
        different = next(
            body for body, share in zip(bodies, shares, strict=True) if abs(share - shares[0]) > ROUNDING
        )
        raise RobotError(
            f"{where}: gravcomp differs between bodies '{name_of(model, 'body', bodies[0])}' and "
            f"'{name_of(model, 'body', different)}'; a model has one gravity. Use one value for all of them"
        )
    if passive == {True, False}:
        names = ", ".join(joint_name(model, joint) for joint in joints if model.jnt_actgravcomp[joint])
        raise RobotError(f"{where}: actuatorgravcomp is set for {names} only; set it for all joints or none")
    return 1.0 - shares[0]
