"""Encoder offset: a joint that differs from its encoder's reading by a constant angle."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin

from ...arm.newton_euler import joints_of
from ...effects import Effect, JointSpring, SpringBalancer
from ...model import Model
from ..findings.arm import Arm
from ..findings.finding import Finding
from ..findings.kind import Kind
from ..questions.candidate import Candidate
from ..runs.driven import Driven

SPRINGS = (SpringBalancer, JointSpring)
"""Effects besides bodies whose torque depends on position."""
MISSET = 0.03
"""How far a joint may be from its encoder's reading [rad]: a tooth of a belt, a mark set by eye."""
ZERO_STEP = 1e-4
"""Of the difference by an encoder's zero [rad]."""


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


def _held(arm: Arm, finding: Finding) -> Arm:
    """A joint whose zero is elsewhere: it hangs on its parent, and on springs, as at the encoder's zero."""
    robot, joint = arm.model.robot, finding.joints[0]
    kinematics, zero = robot.kinematics.copy(), finding.parameters["zero"].value
    one = joints_of(kinematics)[joint]
    shift = (
        pin.SE3(pin.exp3(one.axis * zero), np.zeros(3))
        if one.revolute
        else pin.SE3(np.eye(3), one.axis * zero)
    )
    kinematics.jointPlacements[joint + 1] = kinematics.jointPlacements[joint + 1] * shift
    return _springs_from(arm.on(replace(robot, kinematics=kinematics)), joint, zero)


def _springs_from(arm: Arm, joint: int, zero: float) -> Arm:
    """With the springs of a joint where they are at the encoder's zero."""
    effects = tuple(_turned(effect, arm.model.robot.joints[joint], zero) for effect in arm.model.effects)
    arm = replace(arm, model=replace(arm.model, effects=effects))
    stiffness = arm.by_name.get(f"Ks{joint + 1}", 0.0)
    return arm.with_values({f"Ts{joint + 1}": stiffness * zero}) if stiffness else arm


def _turned(effect: Effect, joint: str, angle: float) -> Effect:
    """A balancer of a joint, turned about it; any other effect as it is."""
    if not isinstance(effect, SpringBalancer) or effect.joint != joint:
        return effect
    turned = effect.phi + angle
    return replace(effect, phi=float(np.arctan2(np.sin(turned), np.cos(turned))))


KIND = Kind(
    sentence="{joint} has an encoder offset: it stands {zero:size mrad} {zero:beyond|short of} its reading",
    drawn_against=("position", "load"),
    ask=encoder_zeros,
    held=_held,
    mistaken_for=("link_inertia", "base_tilt"),
    settled_by="a run with a body of known mass on the flange",
)
