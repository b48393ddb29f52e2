"""Kinematics: joints that are not where encoder and model have them.

An encoder's zero is off by a constant angle; an axis leans by some tenths of a degree, so that bodies beyond
it stand and move otherwise. That a joint is elsewhere by some millimetres asks for no hypothesis: to first
order it moves the centres of bodies, which link inertias hold.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from ...arm.newton_euler import joints_of
from ...arm.tangent import knots, over_knots
from ...effects import Effect, JointSpring, SpringBalancer
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding, Hypothesis
from ..findings.kind import Kind
from ..findings.quantities import length
from ..questions.candidate import Candidate
from ..runs.driven import Driven
from ..runs.kept import kept
from .parts import RARE, on_motors

SPRINGS = (SpringBalancer, JointSpring)
"""Effects besides bodies whose torque depends on position."""
MISSET = 0.03
"""How far a joint may be from its encoder's reading [rad]: a tooth of a belt, a mark set by eye."""
ZERO_STEP = 1e-4
"""Step of the difference by an encoder's zero [rad]."""
MISALIGNED = 0.005
"""How far an axis may be from where the model has it [rad]: tenths of a degree, as of an arm that was never
calibrated."""
NAMES = ("first", "second")


def encoder_zeros(model: Model) -> Iterator[Candidate]:
    """Each joint in turn."""
    springs = replace(model, effects=tuple(e for e in model.effects if isinstance(e, SPRINGS)))
    for joint in range(model.robot.dof):

        def columns(run: Driven, joint: int = joint) -> np.ndarray:
            bodies = run.tangent.position[joint] @ model.robot.to_motors.T
            return (bodies + _by_position(springs, model, run, joint))[:, :, None]

        yield Candidate(
            "encoder_offset", (joint,), columns, ("zero",), ("rad",), (-np.inf,), expected=((0.0, MISSET),),
            carried=True,
        )  # fmt: skip


def _by_position(springs: Model, model: Model, run: Driven, joint: int) -> np.ndarray:
    """Derivative of the springs' nominal torque by a joint's position, shape (t, n) [N m/rad]."""
    known, shift = dict(zip(model.names, model.nominal_values, strict=True)), np.zeros(model.robot.dof)
    values, shift[joint] = np.array([known[name] for name in springs.names]), ZERO_STEP
    if not springs.effects:
        return np.zeros_like(run.torque)
    sides = [
        springs.torque(replace(run.motion, position=run.motion.position + sign * shift), values)
        for sign in (1, -1)
    ]
    return (sides[0] - sides[1]) / (2 * ZERO_STEP) @ model.robot.to_motors.T


def _with_zero(arm: Arm, finding: Hypothesis) -> Arm:
    """A joint whose zero is elsewhere: link and springs are where they are at the encoder's zero."""
    [joint], zero = finding.joints, finding.parameters["zero"].value
    one = joints_of(arm.model.robot.kinematics)[joint]
    turned = pin.SE3(pin.exp3(one.axis * zero), np.zeros(3))
    arm = _shifted(arm, joint, turned if one.revolute else pin.SE3(np.eye(3), one.axis * zero))
    effects = tuple(_turned(effect, arm.model.robot.joints[joint], zero) for effect in arm.model.effects)
    arm = replace(arm, model=replace(arm.model, effects=effects))
    stiffness = arm.by_name.get(f"Ks{joint + 1}", 0.0)
    return arm.with_values({f"Ts{joint + 1}": stiffness * zero}) if stiffness else arm


def _shifted(arm: Arm, joint: int, shift: pin.SE3) -> Arm:
    """The arm with a joint elsewhere on its parent."""
    kinematics = arm.model.robot.kinematics.copy()
    kinematics.jointPlacements[joint + 1] = kinematics.jointPlacements[joint + 1] * shift
    return arm.on(replace(arm.model.robot, kinematics=kinematics))


def _turned(effect: Effect, joint: str, angle: float) -> Effect:
    """A balancer of a joint, turned about it; any other effect as it is."""
    if not isinstance(effect, SpringBalancer) or effect.joint != joint:
        return effect
    turned = effect.phi + angle
    return replace(effect, phi=float(np.arctan2(np.sin(turned), np.cos(turned))))


def misalignments(model: Model) -> Iterator[Candidate]:
    """Each joint but the first, whose axis leans with the base, about two directions across its axis."""
    slopes = kept(_slopes)
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

    By derivatives of inverse dynamics of an arm with two joints before each axis that stand still.
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


def _off(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """By what angle the axis is off."""
    return {"off": length(known, *NAMES)} if NAMES[0] in known else {}


def _with_axis(arm: Arm, finding: Hypothesis) -> Arm:
    """An arm whose axis is elsewhere."""
    [joint] = finding.joints
    pairs = zip(NAMES, across(joints_of(arm.model.robot.kinematics)[joint].axis), strict=True)
    angle = np.sum([finding.parameters[name].value * direction for name, direction in pairs], axis=0)
    return _shifted(arm, joint, pin.SE3(pin.exp3(angle), np.zeros(3)))


KINDS = {
    "encoder_offset": Kind(
        family="kinematics",
        sentence="{joint} has an encoder offset: it stands {zero:size mrad} {zero:beyond|short of} its "
        "reading",
        drawn_against=("position", "load"),
        ask=encoder_zeros,
        held=_with_zero,
        mistaken_for=("link_inertia", "base_tilt"),
        settled_by="a run with a body of known mass on the flange",
    ),
    "axis_misalignment": Kind(
        family="kinematics",
        sentence="The axis of {joint} is not where the model has it[: it is off by {off:deg}]",
        drawn_against=("position", "load"),
        ask=misalignments,
        derived=_off,
        held=_with_axis,
        of_body=True,
        mistaken_for=("encoder_offset", "link_inertia", "base_tilt"),
        settled_by="a calibration of the kinematics, or a run with a body of known mass on the flange",
    ),
}
"""Name -> what is known of each."""
