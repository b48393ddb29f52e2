r"""DC motors of an MJCF (`dcmotor`): their mechanics as effects, and words for what depends on voltage.

A motor behind a gear of ratio :math:`N` adds to its joint the torque of its current and, after the limit of
its force, cogging and LuGre friction (MuJoCo, doc/dcmotor/dcmotor.tex, section 2.6; engine_forward.c):

.. math:: N \left(K i + A \sin(p N q + \varphi) - \sigma_0 z - \sigma_1 \dot z\right)

At constant speed the friction is :math:`F_c + (F_s - F_c) e^{-(N \dot q / \omega_s)^2}`: Coulomb friction
:math:`|N| F_c` and Stribeck friction :math:`|N| (F_s - F_c)` that fades over :math:`\omega_s / |N|`. The
effects of a model have the opposite sign, because the current has to overcome them.

A model has the torque of the current. Voltage, back-EMF, inductance and temperature determine which current
flows, not which torque it exerts. Only a motor without input, whose terminals are shorted, brakes by its
back-EMF: viscous friction of :math:`N^2 K^2 / R`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..notebook import optional
from .mjcf_elements import (
    MOTOR_NUMBERS,
    attribute_numbers,
    disabled,
    drives_joint,
    input_of,
    joint_actuators,
    joint_name,
    name_of,
)

SHORTED, VOLTAGE = 16, 8
"""Bits of `actuator_ctrlspec` (mjtCtrlInput): no input at all, and voltage as input."""
Row = Mapping[str, Any]


@dataclass(frozen=True)
class DcMotor:
    """A DC motor that drives one joint; its numbers are those of the shaft, before the gear."""

    index: int  # index of the actuator in the compiled model
    joint: int  # index of the joint in the compiled model
    gear: float  # turns of the motor per turn of the joint, signed [-]
    constant: float  # motor constant K [N m/A]
    resistance: float  # resistance R at the reference temperature [ohm]
    input: int  # bits of its inputs
    armature: float  # inertia of the rotor [kg m^2]
    damping: float  # viscous friction of the rotor [N m s/rad]
    stiffness: float  # stiffness of the LuGre bristles [N m/rad]; 0 without LuGre friction
    bristle_damping: float  # damping of the bristles while they deflect [N m s/rad]
    coulomb: float  # LuGre friction at high speed [N m]
    static: float  # LuGre friction at the lowest speed [N m]
    stribeck: float  # velocity of the motor over which the friction falls [rad/s]
    amplitude: float  # amplitude of the cogging torque [N m]
    poles: float  # waves of the cogging torque per turn of the motor [-]
    phase: float  # phase of the cogging torque [rad]

    @classmethod
    def of(cls, model: Any, index: int) -> "DcMotor":
        """Motor of an actuator."""
        numbers = {name: number.read(model, index) for name, number in MOTOR_NUMBERS.items()}
        if numbers["stiffness"] <= 0.0:  # without bristles there is no LuGre friction
            numbers |= dict.fromkeys(attribute_numbers("lugre"), 0.0)
        return cls(
            index=index,
            joint=int(model.actuator_trnid[index][0]),
            gear=float(model.actuator_gear[index][0]),
            input=int(model.actuator_ctrlspec[index]),
            **numbers,
        )

    @property
    def back_emf(self) -> float:
        """Torque against the joint's velocity at constant voltage [N m s/rad]."""
        return (self.gear * self.constant) ** 2 / self.resistance if self.resistance else 0.0

    @property
    def fades(self) -> bool:
        """Whether the LuGre friction depends on speed."""
        return self.static != self.coulomb and self.stribeck > 0.0 and self.stiffness > 0.0

    @property
    def wave(self) -> np.ndarray:
        """Torque against the cogging: factors of the cosine and sine of |poles gear| q, shape (2,) [N m]."""
        sign = np.sign(self.poles * self.gear)
        return -self.gear * self.amplitude * np.array([np.sin(self.phase), sign * np.cos(self.phase)])


def is_dc_motor(model: Any, actuator: int) -> bool:
    """Whether an actuator is a `dcmotor`, which MuJoCo has since 3.7."""
    kind = getattr(optional("mujoco", "an MJCF", "mujoco").mjtGain, "mjGAIN_DCMOTOR", None)
    return kind is not None and bool(model.actuator_gaintype[actuator] == int(kind))


def dc_motors(model: Any, joints: Sequence[int]) -> list[DcMotor]:
    """Motors of the given joints of a compiled model that are not disabled."""
    if disabled(model, "ACTUATION"):
        return []
    motors = []
    for index, joint in joint_actuators(model):
        group = int(model.actuator_group[index])
        off = 0 <= group <= 30 and model.opt.disableactuator >> group & 1
        if joint in joints and is_dc_motor(model, index) and not off:
            motors.append(DcMotor.of(model, index))
    return motors


def require_readable(model: Any, actuator: int, name: str) -> Iterator[str]:
    """Reasons why a model cannot represent a `dcmotor` that acts on moving joints."""
    if not hasattr(model, "actuator_ctrlspec"):
        yield f"{name} is a dcmotor, whose inputs differ before MuJoCo 3.12: pip install -U mujoco"
    elif not drives_joint(model, actuator):
        yield f"{name} is a dcmotor of a tendon, whose friction acts on several joints. Make it a motor"
    else:
        joint = int(model.actuator_trnid[actuator][0])
        rough = [motor.index for motor in dc_motors(model, [joint]) if motor.stiffness > 0.0]
        if len(rough) > 1 and actuator == rough[-1]:
            yield f"{name} is the second dcmotor with lugre at joint '{joint_name(model, joint)}'. Use one"


def stall_torque(model: Any, actuator: int) -> float:
    """Torque of a motor at standstill and at the limit of its voltage, before the gear [N m]."""
    motor, place = DcMotor.of(model, actuator), input_of(model, actuator)
    if motor.input == SHORTED:
        return 0.0
    voltage = float(model.actuator_gainprm[actuator][7]) or np.inf
    if motor.input == VOLTAGE:
        limited = model.actuator_ctrllimited[place]
        voltage = float(np.min(np.abs(model.actuator_ctrlrange[place]))) if limited else np.inf
    return motor.constant / motor.resistance * voltage


def gear_ratios(motors: Sequence[DcMotor], joints: Sequence[int]) -> np.ndarray:
    """Turns of each joint's motor per turn of the joint, shape (n,) [-]; 1 without a DC motor."""
    ratios = {motor.joint: motor.gear for motor in motors if motor.input == SHORTED and motor.gear}
    ratios |= {motor.joint: motor.gear for motor in motors if motor.input != SHORTED and motor.gear}
    return np.array([ratios.get(joint, 1.0) for joint in joints])


def friction_of_motors(motors: Sequence[DcMotor], joints: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Viscous friction [N m s/rad] and Coulomb friction [N m] of the motors at each joint, each (n,)."""
    viscous, dry = np.zeros((2, len(joints)))
    for motor in motors:
        place = list(joints).index(motor.joint)
        viscous[place] += motor.back_emf if motor.input == SHORTED else 0.0
        dry[place] += abs(motor.gear) * motor.coulomb
    return viscous, dry


def stribeck_friction(
    motors: Sequence[DcMotor], joints: Sequence[int], names: Sequence[str]
) -> Iterator[Row]:
    """Row of each joint whose LuGre friction falls with speed."""
    for motor in motors:
        if motor.fades and motor.gear:
            gear = abs(motor.gear)
            yield {
                "name": "stribeck_friction",
                "joints": [names[list(joints).index(motor.joint)]],
                "fade": motor.stribeck / gear,
                "values": [gear * (motor.static - motor.coulomb)],
            }


def ripples(motors: Sequence[DcMotor], joints: Sequence[int], names: Sequence[str]) -> Iterator[Row]:
    """Row of each joint's cogging of one number of waves per turn of the motor of `gear_ratios`."""
    ratios, sums = gear_ratios(motors, joints), dict[tuple[int, float], np.ndarray]()
    for motor in motors:
        place = list(joints).index(motor.joint)
        waves = abs(motor.poles * motor.gear / ratios[place])
        if np.any(motor.wave) and waves:
            # the angle of the robot's motor has the sign of its gear ratio
            wave = motor.wave * [1.0, np.sign(ratios[place])]
            sums[place, waves] = sums.get((place, waves), np.zeros(2)) + wave
    for (place, waves), wave in sums.items():
        values = wave.tolist()
        yield {"name": "torque_ripple", "joints": [names[place]], "harmonic": waves, "values": values}


def motor_doubts(model: Any, joints: Sequence[int], where: str) -> Iterator[str]:
    """Warnings about what the models of these motors leave out."""
    for motor in dc_motors(model, joints):
        missing = list(_missing(model, motor))
        if missing:
            name = name_of(model, "actuator", motor.index)
            yield (
                f"{where}: dcmotor '{name}': the model has the torque of the motor's current, "
                f"{abs(motor.gear) * motor.constant:.4g} N m/A at the joint, without {'; '.join(missing)}"
            )


def _missing(model: Any, motor: DcMotor) -> Iterator[str]:
    dynamics, gain = model.actuator_dynprm[motor.index], model.actuator_gainprm[motor.index]
    if motor.input & VOLTAGE and motor.back_emf:
        viscous = f"viscous friction of {motor.back_emf:.3g} N m s/rad"
        yield f"back-EMF (in a log of voltage or duty cycle, {viscous})"
    if dynamics[2] > 0.0 and gain[2]:
        yield f"the rise of the resistance with temperature ({100 * gain[2]:.2g} % per kelvin)"
    if dynamics[0] > 0.0:
        yield f"the delay of the current by its inductance ({1e3 * dynamics[0]:.3g} ms)"
    if motor.stiffness and motor.gear:
        rad = max(motor.coulomb, motor.static) / motor.stiffness / abs(motor.gear)
        yield f"the bristles of LuGre friction (it reverses at once, not over {rad:.2g} rad)"
    if motor.amplitude and not motor.poles:
        yield "cogging of 0 poles, a constant torque"
