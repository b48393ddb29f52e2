"""The parts of a model that an export format leaves out, with their sizes."""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import fields, replace

import numpy as np

from ..arm.robot import Robot
from ..effects import Effect, name_of
from ..fit.base_parameters import rich_motion
from ..measurements import measurement_name
from ..model import Model
from .portable import Portable

EARTH = np.array([0.0, 0.0, -9.81])
"""Gravity that simulators assume for formats without gravity [m/s^2]."""

ROUNDING = 1e-12
"""Share of the largest value below which a value counts as rounding."""


def left_out(portable: Portable, features: Collection[str]) -> list[str]:
    """One sentence for each part of the model that a format with these features leaves out.

    Formats with springs represent a constant torque by the rest position of the joint's spring.
    """
    if "stiffness" in features:
        alone = np.where(portable.joints.stiffness != 0.0, 0.0, portable.joints.constant)
        portable = replace(portable, joints=replace(portable.joints, constant=alone))
    missing = (describe for name, describe in FEATURES.items() if name not in features)
    return [*portable.remarks, *(sentence for describe in missing for sentence in describe(portable))]


def _amounts(robot: Robot, values: np.ndarray, unit: str) -> str:
    """Words for the nonzero values (n,) of all joints, or for one number if all joints have the same.

    `unit` is that of revolute joints; if there are both kinds of joints, each number has its own unit.
    """
    units = robot.units(unit)
    alike = len(set(units)) == 1
    if len(values) > 1 and alike and np.all(values == values[0]):
        return f"{values[0]:.4g} {units[0]}"
    rounding = ROUNDING * np.max(np.abs(values))
    rows = zip(robot.joints, values, units, strict=True)
    words = [f"{j} {v:.4g}" + ("" if alike else f" {u}") for j, v, u in rows if abs(v) > rounding]
    return ", ".join(words) + (f" {units[0]}" if alike else "")


def _of_each(part: str, name: str, title: str, unit: str) -> Callable[[Portable], Iterator[str]]:
    """Function that describes a value of each joint, by the names of an attribute and of its field."""

    def describe(portable: Portable) -> Iterator[str]:
        values = getattr(getattr(portable, part), name)
        if np.any(values):
            yield f"{title}: {_amounts(portable.robot, values, unit)}"

    return describe


def effect_sentences(model: Model, effects: Sequence[tuple[Effect, np.ndarray]]) -> Iterator[str]:
    """One sentence for each effect with its parameters (p,): the largest torque within the limits.

    It is that of a random motion within the velocity limits, with random temperatures and the nominal load.
    """
    robot, motion = model.robot, rich_motion(model)
    limit = robot.limits.velocity
    fastest = np.where(np.isfinite(limit), limit, np.abs(motion.velocity).max(axis=0))
    motion = model.loaded(replace(motion, velocity=np.clip(motion.velocity, -fastest, fastest)))
    for effect, values in effects:
        torque = effect.regressor(robot, motion) @ values + effect.known_torque(robot, motion)
        most = np.max(np.abs(torque), axis=0)
        words = f"{name_of(effect)}: up to {_amounts(robot, most, 'N m')}"
        yield f"{words} ({', '.join(_numbers(effect, robot, values))})"


def _numbers(effect: Effect, robot: Robot, values: np.ndarray) -> Iterator[str]:
    """Parameters and shapes of an effect, each with its unit."""
    for parameter, value in zip(effect.parameters(robot), values, strict=True):
        yield f"{parameter.name} {value:.4g} {parameter.unit}".removesuffix(" 1")
    for name, shape in effect.shapes().items():
        yield f"{name} {getattr(effect, name):.4g} {shape.unit}".removesuffix(" 1")


def _bodies(portable: Portable) -> Iterator[str]:
    bodies = zip(portable.robot.joints, list(portable.robot.kinematics.inertias)[1:], strict=True)
    masses = ", ".join(f"{joint} {body.mass:.4g}" for joint, body in bodies)
    yield f"kinematics and bodies; mass behind each joint: {masses} kg"


def _gravity(portable: Portable) -> Iterator[str]:
    gravity = portable.robot.gravity
    if not np.allclose(gravity, EARTH):
        yield f"gravity: {', '.join(f'{g:g}' for g in gravity)} m/s^2 in the base frame"


def _reversal(portable: Portable) -> Iterator[str]:
    joints = portable.joints
    if np.any(joints.dry):
        turning = _amounts(portable.robot, np.where(joints.dry, joints.reversal, 0.0), "rad/s")
        yield f"the velocity over which coulomb_friction reverses, by tanh: {turning}"


def _balancers(portable: Portable) -> Iterator[str]:
    for spring in portable.balancers:
        yield (
            f"spring_balancer of {spring.joint}: {spring.stiffness:.4g} N/m, preload {spring.preload:.4g} N, "
            f"d21 {spring.d21:g} m, d22 {spring.d22:g} m, phi {spring.phi:g} rad"
        )


def _measurements(portable: Portable) -> Iterator[str]:
    """Effects between the arm and its recordings, with their numbers."""
    for measurement in portable.model.measurements:
        numbers = (f"{f.name} {_plain(getattr(measurement, f.name))}" for f in fields(measurement))
        yield f"{measurement_name(measurement)}: {', '.join(numbers)}"


def _plain(value: object) -> str:
    """Words for the value of a field."""
    if isinstance(value, tuple):
        return " ".join(map(str, value))
    return "of all" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def _gains(portable: Portable) -> Iterator[str]:
    gain = portable.robot.drive_gain
    if np.any(gain != 1.0) and not portable.robot.servo:
        yield f"drive gains: {_amounts(portable.robot, gain, 'N m/A')}"


def _law(portable: Portable) -> Iterator[str]:
    robot, law = portable.robot, portable.servos
    if law is None:
        return
    sentence = f"position servos, torque over their error: {_amounts(robot, law.stiffness, 'N m/rad')}"
    if np.any(law.damping):
        sentence += f"; damping: {_amounts(robot, law.damping, 'N m s/rad')}"
    if np.any(np.isfinite(law.limit)):
        limit = np.where(np.isfinite(law.limit), law.limit, 0.0)
        sentence += f"; saturation at {_amounts(robot, limit, 'N m')}"
    yield sentence


def _coupling(portable: Portable) -> Iterator[str]:
    coupling = portable.robot.coupling
    if not np.allclose(coupling, np.eye(len(coupling))):
        yield "coupling of motors and joints: torques are those of the joints, not of the motors"


FEATURES: dict[str, Callable[[Portable], Iterable[str]]] = {
    "bodies": _bodies,
    "gravity": _gravity,
    "armature": _of_each("joints", "armature", "rotor_inertia", "kg m^2"),
    "damping": _of_each("joints", "damping", "viscous_friction", "N m s/rad"),
    "dry": _of_each("joints", "dry", "coulomb_friction", "N m"),
    "reversal": _reversal,
    "stiffness": _of_each("joints", "stiffness", "stiffness of joint_spring", "N m/rad"),
    "constant": _of_each("joints", "constant", "constant torque of current_offset and joint_spring", "N m"),
    "balancers": _balancers,
    "effects": lambda portable: effect_sentences(portable.model, portable.others),
    "measurements": _measurements,
    "gains": _gains,
    # Servos of the robot file, and of another source.
    "servos": lambda portable: _law(portable) if portable.robot.servo is not None else [],
    "law": lambda portable: _law(portable) if portable.robot.servo is None else [],
    "delay": _of_each("law", "delay", "delay of the servos", "s"),
    "feed_forward": _of_each(
        "law", "feed_forward", "feed-forward of the servos, torque over commanded velocity", "N m s/rad"
    ),
    "integral": _of_each("law", "integral", "integral part of the servos", "N m/(rad s)"),
    "coupling": _coupling,
    "uncertainty": lambda portable: ["standard deviations of the parameters, and the jerk limits"],
}
"""Part of a model -> function that describes it if a format cannot represent it."""
