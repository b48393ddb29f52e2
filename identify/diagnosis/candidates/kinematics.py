"""Kinematics: joints that are not where the encoder or the model has them.

An encoder zero is off by a constant angle; an axis leans by a few tenths of a degree, which displaces the
bodies beyond it. A joint that is shifted by a few millimeters needs no hypothesis: to first order, it only
shifts the centers of bodies, which link inertias include.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from ...arm.motion import Tangent, knots, over_knots, tangent
from ...arm.newton_euler import joints_of
from ...effects import Effect, JointSpring, SpringBalancer
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding, Hypothesis
from ..findings.kind import Kind
from ..findings.quantities import length
from ..questions.candidate import Candidate
from ..runs.driven import Driven, cached
from .parts import RARE, on_motors

SPRINGS = (SpringBalancer, JointSpring)
"""Effects besides bodies whose torque depends on position."""
MISSET = 0.03
"""Expected error of an encoder zero [rad]: a tooth of a belt, or a mark set by eye."""
ZERO_STEP = 1e-4
"""Step of the finite difference with respect to an encoder zero [rad]."""
MISALIGNED = 0.005
"""Expected error of an axis [rad]: tenths of a degree, as of an arm that was never calibrated."""
NAMES = ("first", "second")


def encoder_zeros(model: Model) -> Iterator[Candidate]:
    """An error of the encoder zero of each joint."""
    springs = replace(model, effects=tuple(e for e in model.effects if isinstance(e, SPRINGS)))

    @cached
    def slopes(run: Driven) -> Tangent:
        return run.unloaded.tangent if run.found is None else tangent(run.found, run.motion)

    for joint in range(model.robot.dof):

        def columns(run: Driven, joint: int = joint) -> np.ndarray:
            bodies = slopes(run).position[joint] @ model.robot.to_motors.T
            return (bodies + _by_position(springs, model, run, joint))[:, :, None]

        yield Candidate(
            "encoder_offset", (joint,), columns, ("zero",), ("rad",), (-np.inf,), expected=((0.0, MISSET),),
            carried=True, loaded=True,
        )  # fmt: skip


def _by_position(springs: Model, model: Model, run: Driven, joint: int) -> np.ndarray:
    """Derivative of the springs' nominal torque with respect to a joint position, shape (t, n) [N m/rad]."""
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
    """The arm with a shifted encoder zero: link and springs are placed relative to the encoder's zero."""
    [joint], zero = finding.joints, finding.parameters["zero"].value
    frame = joints_of(arm.model.robot.kinematics)[joint]
    turned = pin.SE3(pin.exp3(frame.axis * zero), np.zeros(3))
    arm = _shifted(arm, joint, turned if frame.revolute else pin.SE3(np.eye(3), frame.axis * zero))
    effects = tuple(_turned(effect, arm.model.robot.joints[joint], zero) for effect in arm.model.effects)
    arm = replace(arm, model=replace(arm.model, effects=effects))
    stiffness = arm.by_name.get(f"Ks{joint + 1}", 0.0)
    return arm.with_values({f"Ts{joint + 1}": stiffness * zero}) if stiffness else arm


def _shifted(arm: Arm, joint: int, shift: pin.SE3) -> Arm:
    """The arm with a joint displaced on its parent."""
    kinematics = arm.model.robot.kinematics.copy()
    kinematics.jointPlacements[joint + 1] = kinematics.jointPlacements[joint + 1] * shift
    return arm.on(replace(arm.model.robot, kinematics=kinematics))


def _turned(effect: Effect, joint: str, angle: float) -> Effect:
    """A balancer of the joint, turned by the angle; any other effect unchanged."""
    if not isinstance(effect, SpringBalancer) or effect.joint != joint:
        return effect
    turned = effect.phi + angle
    return replace(effect, phi=float(np.arctan2(np.sin(turned), np.cos(turned))))


def misalignments(model: Model) -> Iterator[Candidate]:
    """Leaning axes of all joints but the first, which leans with the base, each about two directions."""
    slopes = cached(_slopes)
    for joint, frame in enumerate(joints_of(model.robot.kinematics)):
        if joint == 0 or not frame.revolute:
            continue

        def columns(run: Driven, joint: int = joint) -> np.ndarray:
            at_knots = slopes(run)[:, :, 2 * joint : 2 * joint + 2]
            return on_motors(model.robot, over_knots(run.motion, at_knots))

        yield Candidate(
            "axis_misalignment", (joint,), columns, NAMES, ("rad", "rad"), (-np.inf,) * 2, smooth=True,
            expected=((0.0, MISALIGNED),) * 2, carried=True, prior=RARE, listed=False,
        )  # fmt: skip


def across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors (3,) perpendicular to an axis (3,) and to each other."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


def _slopes(run: Driven) -> np.ndarray:
    """Torque of the bodies per angle about both directions across each axis, at knots, (k, n, 2 n) [N m/rad].

    It is the derivative of the inverse dynamics of an arm with two additional fixed joints before each axis.
    """
    kinematics, moving, still = _with_still_joints(run.unloaded.bodies)
    data, motion = kinematics.createData(), run.motion
    rows = knots(motion)
    state = np.zeros((3, len(rows), kinematics.nv))
    state[:, :, moving] = motion.position[rows], motion.velocity[rows], motion.acceleration[rows]
    slopes = np.empty((len(rows), len(moving), len(still)))
    for place, (position, velocity, acceleration) in enumerate(state.transpose(1, 0, 2)):
        by_position, _, _ = pin.computeRNEADerivatives(kinematics, data, position, velocity, acceleration)
        slopes[place] = by_position[np.ix_(moving, still)]
    return slopes


def _with_still_joints(bodies: pin.Model) -> tuple[pin.Model, np.ndarray, np.ndarray]:
    """The arm with two joints before each, and the indices of its joints (n,) and the added ones (2 n,)."""
    arm, number = pin.Model(), [0]
    arm.gravity = bodies.gravity
    for index, frame in enumerate(joints_of(bodies), start=1):
        parent, placement = number[frame.parent + 1], frame.placement
        for name, direction in zip(NAMES, across(frame.axis), strict=True):
            still = pin.JointModelRevoluteUnaligned(*direction)
            parent = arm.addJoint(parent, still, placement, f"{name}_{index}")
            placement = pin.SE3.Identity()
        parent = arm.addJoint(parent, bodies.joints[index], placement, f"own_{index}")
        arm.appendBodyToJoint(parent, bodies.inertias[index], pin.SE3.Identity())
        number.append(parent)
    moving = np.array([arm.joints[place].idx_v for place in number[1:]])
    return arm, moving, np.sort(np.concatenate([moving - 2, moving - 1]))


def _off(finding: Finding, known: Mapping[str, Any]) -> dict[str, Any]:
    """Angle by which the axis is off."""
    return {"off": length(known, *NAMES)} if NAMES[0] in known else {}


def _with_axis(arm: Arm, finding: Hypothesis) -> Arm:
    """The arm with the leaning axis."""
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
        settled_by="a run with a body of known mass on the flange (exidyn excite --mass)",
    ),
    "axis_misalignment": Kind(
        family="kinematics",
        sentence="The axis of {joint} is not where the model has it[: it is off by {off:deg}]",
        drawn_against=("position", "load"),
        ask=misalignments,
        derived=_off,
        held=_with_axis,
        of_body=True,
        settled_by="a calibration of the kinematics, or a run with a body of known mass on the flange "
        "(exidyn excite --mass)",
    ),
}
