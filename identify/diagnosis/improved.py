"""Improved: the arm with what was found in it, as far as a model can hold it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from ..effects import Effect, RotorInertia, SpringBalancer
from ..model import Model
from ..newton_euler import joints_of
from ..plant import Transmission
from ..plant.typical import typical_size
from ..rigid_regressor import INERTIAL
from ..robot import Robot
from .finding import Finding
from .trace import Evidence

TEETH = 40.0
"""Resonance of a link on the teeth of a gear with play [Hz]: harder ones strike alike behind a low-pass of
25 Hz."""

LIGHT = 0.01
"""Share of what a joint moves that its motor has where the model gives it no inertia [-]: too little to be
seen in a torque."""


@dataclass(frozen=True, eq=False)
class Arm:
    """An arm that can be simulated.

    Attributes:
        model: Robot and effects.
        values: Its parameters, shape (p,).
        gain: Its drive gains, shape (n,) [N m/A].
        transmission: What is between motors and links.
        left_out: Findings, by their place, that are no part of it.
    """

    model: Model
    values: np.ndarray
    gain: np.ndarray
    transmission: Transmission
    left_out: tuple[int, ...] = ()

    @property
    def by_name(self) -> dict[str, float]:
        """Values of the parameters."""
        return dict(zip(self.model.names, map(float, self.values), strict=True))


def as_believed(evidence: Evidence) -> Arm:
    """The arm at its model's word, with friction and offsets as fitted."""
    model = evidence.model
    return Arm(model, evidence.before, evidence.gain_before, Transmission.rigid(model.robot.dof))


def as_found(evidence: Evidence, findings: Sequence[Finding]) -> Arm:
    """The arm with all that was found, its parameters fitted within their tolerances beside it."""
    model = evidence.model
    arm = Arm(model, evidence.after, evidence.gain_after, Transmission.rigid(model.robot.dof))
    for place, finding in enumerate(findings):
        more = with_finding(arm, finding)
        arm = replace(arm, left_out=(*arm.left_out, place)) if more is None else more
    return arm


def with_finding(arm: Arm, finding: Finding) -> Arm | None:
    """The arm with one finding; None where neither model nor transmission can hold it."""
    if finding.effect in HELD:
        return HELD[finding.effect](arm, finding)
    if finding.candidate.instance is not None:
        return _plus(arm, finding.candidate.instance, finding)
    return None


def _plus(arm: Arm, effect: Effect, finding: Finding) -> Arm | None:
    """With one more effect, or with more of one that is there already."""
    names = [parameter.name for parameter in effect.parameters(arm.model.robot)]
    alike = [one for one in arm.model.effects if _same_shape(one, effect)]
    present = [name for name in names if name in arm.by_name]
    if present and not alike:
        return None  # the same names with another shape: a model cannot hold both
    model = arm.model if present else arm.model + effect
    return _with_values(replace(arm, model=model), {name: finding.parameters[name].value for name in names})


def _same_shape(one: Effect, other: Effect) -> bool:
    shapes = other.shapes()
    return type(one) is type(other) and all(getattr(one, name) == getattr(other, name) for name in shapes)


def _with_values(arm: Arm, more: dict[str, float]) -> Arm:
    """With some parameters larger than they were, and what the model has newly at these values."""
    names = arm.model.names
    before = dict(zip(names, arm.values, strict=False))  # new effects' names are the last
    return replace(arm, values=np.array([before.get(name, 0.0) + more.get(name, 0.0) for name in names]))


def _payload(arm: Arm, finding: Finding) -> Arm | None:
    """The last link with the body on it."""
    robot = arm.model.robot
    body = pseudo_inertia({name: finding.parameters[name].value for name in _moments(finding)})
    placement = robot.flange.homogeneous
    return _heavier(arm, robot.dof - 1, placement @ body @ placement.T)


def _link(arm: Arm, finding: Finding) -> Arm | None:
    """A link with other mass and moments."""
    link = finding.joints[0]
    more = {name: finding.parameters[f"{name}{link + 1}"].value for name in _moments(finding, str(link + 1))}
    return _heavier(arm, link, pseudo_inertia(more))


def _moments(finding: Finding, ending: str = "") -> list[str]:
    return [name for name in INERTIAL if f"{name}{ending}" in finding.parameters]


def _heavier(arm: Arm, link: int, body: np.ndarray) -> Arm | None:
    """A link with a further body, given by its pseudo-inertia (4, 4) in the link's frame."""
    more = {f"{name}{link + 1}": value for name, value in inertial_values(body).items()}
    return _with_values(arm, more) if set(more) <= set(arm.model.names) else None


def pseudo_inertia(values: dict[str, float]) -> np.ndarray:
    """Integral of density times (x, y, z, 1) times its transpose, shape (4, 4); what is not given is zero.

    Unlike an inertia about the centre of mass it is linear, and moves from frame to frame for any numbers.
    """
    xx, xy, xz, yy, yz, zz = (values.get(name, 0.0) for name in ("XX", "XY", "XZ", "YY", "YZ", "ZZ"))
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    out = np.zeros((4, 4))
    out[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    out[:3, 3] = out[3, :3] = [values.get(name, 0.0) for name in ("MX", "MY", "MZ")]
    out[3, 3] = values.get("M", 0.0)
    return out


def inertial_values(pseudo: np.ndarray) -> dict[str, float]:
    """The ten parameters of a body out of its pseudo-inertia (4, 4)."""
    inertia = np.trace(pseudo[:3, :3]) * np.eye(3) - pseudo[:3, :3]
    found = {f"{'XYZ'[i]}{'XYZ'[j]}": inertia[i, j] for i in range(3) for j in range(i, 3)}
    found |= {f"M{axis}": pseudo[place, 3] for place, axis in enumerate("XYZ")}
    return {name: float(({"M": pseudo[3, 3]} | found)[name]) for name in INERTIAL}


def _tilt(arm: Arm, finding: Finding) -> Arm:
    robot = arm.model.robot
    kinematics = robot.kinematics.copy()
    field = np.array(kinematics.gravity.linear)
    known, size = {name: one.value for name, one in finding.parameters.items()}, float(np.linalg.norm(field))
    if "tilt_x" in known:
        turned = field + size * np.array([known["tilt_x"], known["tilt_y"], 0.0])
    else:
        turned = size * np.array([known[f"gravity_{axis}"] for axis in "xyz"])
    kinematics.gravity = pin.Motion(turned, np.zeros(3))
    return _on(arm, replace(robot, kinematics=kinematics))


def _encoder(arm: Arm, finding: Finding) -> Arm:
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
    return _springs_from(_on(arm, replace(robot, kinematics=kinematics)), joint, zero)


def _springs_from(arm: Arm, joint: int, zero: float) -> Arm:
    """With the springs of a joint where they are at the encoder's zero."""
    effects = tuple(_turned(effect, arm.model.robot.joints[joint], zero) for effect in arm.model.effects)
    arm = replace(arm, model=replace(arm.model, effects=effects))
    stiffness = arm.by_name.get(f"Ks{joint + 1}", 0.0)
    return _with_values(arm, {f"Ts{joint + 1}": stiffness * zero}) if stiffness else arm


def _turned(effect: Effect, joint: str, angle: float) -> Effect:
    """A balancer of a joint, turned about it; any other effect as it is."""
    if not isinstance(effect, SpringBalancer) or effect.joint != joint:
        return effect
    turned = effect.phi + angle
    return replace(effect, phi=float(np.arctan2(np.sin(turned), np.cos(turned))))


def _gain(arm: Arm, finding: Finding) -> Arm:
    share = np.zeros(len(arm.gain))
    share[list(finding.joints)] = finding.parameters["share"].value
    return replace(arm, gain=arm.gain * (1.0 + share))


def _elastic(arm: Arm, finding: Finding) -> Arm:
    """A gear that gives way; the more of the effect was found, the softer it is."""
    known = {name: quantity.value for name, quantity in finding.parameters.items()}
    stiffness = known["stiffness"] / max(known["share"], 0.1)
    damping = 2 * known["damping_ratio"] * stiffness / (2 * np.pi * known["resonance"])
    return _between(arm, finding.joints[0], stiffness, damping, 0.0)


def _loose(arm: Arm, finding: Finding) -> Arm:
    """A gear with play, and teeth that spring back."""
    joint, known = finding.joints[0], finding.parameters
    angular = 2 * np.pi * TEETH
    inertia = float(typical_size(arm.model)[0][joint])
    damping = 2 * known["damping_ratio"].value * inertia * angular
    return _between(arm, joint, inertia * angular**2, damping, known["gap"].value)


def _between(arm: Arm, joint: int, stiffness: float, damping: float, play: float) -> Arm:
    """With one gear that is not rigid; what two findings say of it adds: the softer spring, and the play."""
    arm, old = _with_rotor(arm, joint), arm.transmission
    place = np.arange(len(old.stiffness)) == joint
    return replace(
        arm,
        transmission=Transmission(
            np.where(place, np.minimum(old.stiffness, stiffness), old.stiffness),
            np.where(place, np.maximum(old.damping, damping), old.damping),
            np.where(place, np.maximum(old.backlash, play), old.backlash),
        ),
    )


def _with_rotor(arm: Arm, joint: int) -> Arm:
    """With a motor that can be moved apart from its link, be the model without rotor inertia."""
    name, effect = f"Ia{joint + 1}", RotorInertia((arm.model.robot.joints[joint],))
    if arm.by_name.get(name, 0.0) > 0.0:
        return arm
    model = arm.model if name in arm.by_name else arm.model + effect
    return _with_values(replace(arm, model=model), {name: LIGHT * float(typical_size(arm.model)[0][joint])})


def _on(arm: Arm, robot: Robot) -> Arm:
    return replace(arm, model=replace(arm.model, robot=robot))


HELD: dict[str, Callable[[Arm, Finding], Arm | None]] = {
    "payload": _payload,
    "link_inertia": _link,
    "base_tilt": _tilt,
    "encoder_offset": _encoder,
    "drive_gain": _gain,
    "joint_elasticity": _elastic,
    "backlash": _loose,
}
"""Findings that are no effect of a model's own kind, and how the arm holds them all the same."""
