"""Left out: what of a model a format cannot represent, and how much torque that is."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from ..arm.motion import Motion
from ..effects import name_of
from ..fit.base_parameters import rich_motion
from .portable import Portable

EARTH = np.array([0.0, 0.0, -9.81])
"""Gravity that is taken where a format does not give it [m/s^2]."""

ROUNDING = 1e-12
"""Share of the largest value that is zero but for rounding."""


def left_out(portable: Portable, features: Collection[str]) -> list[str]:
    """A sentence for each thing that a format with these features leaves out."""
    found = (one for name, describe in FEATURES.items() if name not in features for one in describe(portable))
    return [*portable.remarks, *found]


def _amounts(portable: Portable, values: np.ndarray, unit: str) -> str:
    """Values (n,) that are not zero, joint by joint; one number where all joints have the same.

    `unit` is that of revolute joints; where there are both kinds, each number has its own.
    """
    units = portable.robot.units(unit)
    alike = len(set(units)) == 1
    if len(values) > 1 and alike and np.all(values == values[0]):
        return f"{values[0]:.4g} {units[0]}"
    rounding = ROUNDING * np.max(np.abs(values))
    rows = zip(portable.robot.joints, values, units, strict=True)
    words = [f"{j} {v:.4g}" + ("" if alike else f" {u}") for j, v, u in rows if abs(v) > rounding]
    return ", ".join(words) + (f" {units[0]}" if alike else "")


def _of_joints(name: str, what: str, unit: str) -> Callable[[Portable], Sequence[str]]:
    def describe(portable: Portable) -> list[str]:
        values = getattr(portable.joints, name)
        return [f"{what}: {_amounts(portable, values, unit)}"] if np.any(values) else []

    return describe


def _gravity(portable: Portable) -> list[str]:
    gravity = portable.robot.gravity
    if np.allclose(gravity, EARTH):
        return []
    return [f"gravity: {', '.join(f'{g:g}' for g in gravity)} m/s^2 in the base frame"]


def _balancers(portable: Portable) -> list[str]:
    return [
        f"spring_balancer of {spring.joint}: {spring.stiffness:.4g} N/m, preload {spring.preload:.4g} N, "
        f"d21 {spring.d21:g} m, d22 {spring.d22:g} m, phi {spring.phi:g} rad"
        for spring in portable.balancers
    ]


def _others(portable: Portable) -> list[str]:
    """Effects of our own, with the most torque that each makes anywhere within the limits."""
    motion, robot = _anywhere(portable), portable.robot
    found = []
    for effect, own in portable.left:
        torque = effect.regressor(robot, motion) @ own + effect.known_torque(robot, motion)
        most = np.max(np.abs(torque), axis=0)
        found.append(f"{name_of(effect)}: up to {_amounts(portable, most, 'N m')}")
    return found


def _anywhere(portable: Portable) -> Motion:
    """Random motion within the limits of velocity, as warm and as loaded as it may be."""
    motion = rich_motion(portable.model)
    limit = portable.robot.limits.velocity
    fastest = np.where(np.isfinite(limit), limit, np.abs(motion.velocity).max(axis=0))
    velocity = np.clip(motion.velocity, -fastest, fastest)
    return portable.model.loaded(replace(motion, velocity=velocity))


def _reversal(portable: Portable) -> list[str]:
    joints = portable.joints
    if not np.any(joints.dry):
        return []
    turning = _amounts(portable, np.where(joints.dry, joints.reversal, 0.0), "rad/s")
    return [f"the velocity over which coulomb_friction reverses, by tanh: {turning}"]


def _gains(portable: Portable) -> list[str]:
    gain = portable.robot.drive_gain
    return [] if np.all(gain == 1.0) else [f"drive gains: {_amounts(portable, gain, 'N m/A')}"]


def _coupling(portable: Portable) -> list[str]:
    coupling = portable.robot.coupling
    if np.allclose(coupling, np.eye(len(coupling))):
        return []
    return ["coupling of motors and joints: torques are those of the joints, not of the motors"]


def _uncertainty(portable: Portable) -> list[str]:
    return ["standard deviations of the parameters, and the jerk limits"]


FEATURES: dict[str, Callable[[Portable], Sequence[str]]] = {
    "gravity": _gravity,
    "armature": _of_joints("armature", "rotor_inertia", "kg m^2"),
    "damping": _of_joints("damping", "viscous_friction", "N m s/rad"),
    "dry": _of_joints("dry", "coulomb_friction", "N m"),
    "reversal": _reversal,
    "stiffness": _of_joints("stiffness", "stiffness of joint_spring", "N m/rad"),
    "constant": _of_joints("constant", "constant torque of current_offset and joint_spring", "N m"),
    "balancers": _balancers,
    "effects": _others,
    "gains": _gains,
    "coupling": _coupling,
    "uncertainty": _uncertainty,
}
"""What a format may be able to represent -> what to report where it is not."""
