"""Axis misalignment: a joint's axis that is some tenths of a degree from where the model has it.

Bodies beyond the joint stand and move otherwise. That the joint is elsewhere by some millimetres asks for
no hypothesis: to first order it moves the centres of bodies, which link inertias hold.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pinocchio as pin

from ...arm.newton_euler import joints_of
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..findings.quantities import length
from ..questions.candidate import Candidate
from ..runs.driven import Driven, knots, over_knots
from .parts.motors import on_motors
from .parts.rare import RARE

MISALIGNED = 0.005
"""How far an axis may be from where the model has it [rad]: tenths of a degree, as of an arm that was never
calibrated."""
NAMES = ("first", "second")


def misalignments(model: Model) -> Iterator[Candidate]:
    """Each joint but the first, whose axis leans with the base, about two directions across its axis."""
    slopes = cache(_slopes)
    for joint, one in enumerate(joints_of(model.robot.kinematics)):
        if joint == 0 or not one.revolute:
            continue

        def columns(run: Driven, joint: int = joint) -> np.ndarray:
            every = slopes(run)[:, :, 2 * joint : 2 * joint + 2]
            return on_motors(model.robot, over_knots(run.motion, every))

        yield Candidate(
            "axis_misalignment", (joint,), columns, NAMES, ("rad", "rad"), (-np.inf,) * 2, smooth=True,
            expected=((0.0, MISALIGNED),) * 2, carried=True, prior=RARE, listed=False,
        )  # fmt: skip


def across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two directions across an axis (3,), each of length one, shape (3,)."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


def _slopes(run: Driven) -> np.ndarray:
    """Torque of the bodies per angle about both directions across each axis, at knots, (k, n, 2 n) [N m/rad].

    Each axis has two joints before it that stand still; what a torque changes by with them is a part of
    the derivatives of inverse dynamics.
    """
    kinematics, own, still = _with_still_joints(run.bodies)
    data, motion = kinematics.createData(), run.motion
    rows = knots(motion)
    state = np.zeros((3, len(rows), kinematics.nv))
    state[:, :, own] = motion.position[rows], motion.velocity[rows], motion.acceleration[rows]
    slopes = np.empty((len(rows), len(own), len(still)))
    for place, (position, velocity, acceleration) in enumerate(state.transpose(1, 0, 2)):
        by_position, _, _ = pin.computeRNEADerivatives(kinematics, data, position, velocity, acceleration)
        slopes[place] = by_position[np.ix_(own, still)]
    return slopes


def _with_still_joints(bodies: pin.Model) -> tuple[pin.Model, np.ndarray, np.ndarray]:
    """The arm with two joints before each, and the places of its own joints (n,), and of those two (2 n,)."""
    arm, number = pin.Model(), [0]
    arm.gravity = bodies.gravity
    for index, one in enumerate(joints_of(bodies), start=1):
        parent, placement = number[one.parent + 1], one.placement
        for name, direction in zip(NAMES, across(one.axis), strict=True):
            still = pin.JointModelRevoluteUnaligned(*direction)
            parent = arm.addJoint(parent, still, placement, f"{name}_{index}")
            placement = pin.SE3.Identity()
        parent = arm.addJoint(parent, bodies.joints[index], placement, f"own_{index}")
        arm.appendBodyToJoint(parent, bodies.inertias[index], pin.SE3.Identity())
        number.append(parent)
    own = np.array([arm.joints[place].idx_v for place in number[1:]])
    return arm, own, np.sort(np.concatenate([own - 2, own - 1]))


def _derived(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """By what angle the axis is off."""
    return {"off": length(known, *NAMES)} if NAMES[0] in known else {}


def _held(arm: Arm, finding: Finding) -> Arm:
    """An arm whose axis is elsewhere."""
    robot, [joint] = arm.model.robot, finding.joints
    kinematics = robot.kinematics.copy()
    pairs = zip(NAMES, across(joints_of(kinematics)[joint].axis), strict=True)
    angle = np.sum([finding.parameters[name].value * direction for name, direction in pairs], axis=0)
    shift = pin.SE3(pin.exp3(angle), np.zeros(3))
    kinematics.jointPlacements[joint + 1] = kinematics.jointPlacements[joint + 1] * shift
    return arm.on(replace(robot, kinematics=kinematics))


KIND = Kind(
    sentence="The axis of {joint} is not where the model has it[: it is off by {off:deg}]",
    drawn_against=("position", "load"),
    ask=misalignments,
    derived=_derived,
    held=_held,
    of_body=True,
    mistaken_for=("encoder_offset", "link_inertia", "base_tilt"),
    settled_by="a calibration of the kinematics, or a run with a body of known mass on the flange",
)
