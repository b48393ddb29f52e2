"""Numbers of the DC motors of an MJCF: each is written once, at the `dcmotor` or at its joint.

LuGre friction takes the Coulomb and Stribeck friction of its joint, except what `frictionloss` already has.
Armature and damping are written at the motor if the joint has none of its own. One wave of torque ripple per
joint becomes the motor's cogging.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ..effects import StribeckFriction, TorqueRipple
from ..errors import RobotError
from ..robot_files.mjcf_dcmotors import SHORTED, DcMotor, dc_motors
from ..robot_files.mjcf_names import name_of
from ..robot_files.mjcf_table import MOTOR_NUMBERS, attribute_numbers
from .changes import DIGITS, SAME, Change, Spread, nearly_equal
from .mjcf_changes import File
from .portable import Portable
from .xml_text import Edits

EXPONENT = 2.0
"""Exponent with which Stribeck friction of MuJoCo's LuGre model fades [-]."""


@dataclass
class Plan:
    """A motor of the file, its new numbers, and the part of the model that others have to represent."""

    place: int  # index of the joint in the robot
    old: DcMotor  # motor in the file
    new: DcMotor  # motor with the identified numbers
    unwritten: Portable  # model without what motors represent: such joint terms are those of the file
    halves: dict[str, float] = field(default_factory=dict)  # field of the motor -> half of its 95 % interval


def write_motors(
    file: File, portable: Portable, spread: Spread, edits: Edits
) -> tuple[list[Change], list[DcMotor], Portable]:
    """Write all DC motors; returns changes, new motors, and the model without what they represent."""
    changes, motors, unwritten = list[Change](), list[DcMotor](), portable
    for motor in dc_motors(file.compiled, file.joints):
        plan = Plan(file.joints.index(motor.joint), motor, motor, unwritten)
        _plan_rotor(file, plan, spread)
        _plan_friction(file, plan, spread)
        plan.new, plan.unwritten = _with_cogging(plan.new, plan.unwritten, plan.place, plan.halves, spread)
        changes += _write(file, plan, edits)
        motors.append(plan.new)
        unwritten = plan.unwritten
    return changes, motors, unwritten


def kept_cogging(file: File, portable: Portable) -> list[str]:
    """Sentences about cogging in the file that the model does not have, and which stays there."""
    return [
        f"cogging of dcmotor '{name_of(file.compiled, 'actuator', motor.index)}' stays in the file, although "
        "the model has no torque_ripple of its joint"
        for motor in dc_motors(file.compiled, file.joints)
        if motor.amplitude and not portable.joint_effects(TorqueRipple, file.joints.index(motor.joint))
    ]


def require_motors(compiled: Any, motors: list[DcMotor], where: str) -> None:
    """Raise `RobotError` unless the motors compiled from the new text have the intended numbers."""
    for wanted in motors:
        made = DcMotor.of(compiled, wanted.index)
        for name, value in vars(wanted).items():
            actual = getattr(made, name)
            if not nearly_equal(actual, value):
                raise RobotError(
                    f"{where}: {name} of dcmotor '{name_of(compiled, 'actuator', wanted.index)}' is "
                    f"{actual:.4g} in MuJoCo, not {value:.4g} as in its element"
                )


def _plan_rotor(file: File, plan: Plan, spread: Spread) -> None:
    """Armature and damping, if the motor alone has them."""
    square, place = plan.old.gear**2, plan.place
    dof = file.compiled.jnt_dofadr[plan.old.joint]
    shorted = plan.old.back_emf if plan.old.input == SHORTED else 0.0
    for term, other in (("armature", 0.0), ("damping", shorted)):
        total = getattr(Portable.of(file.nominal).joints, term)[place]
        now = getattr(plan.unwritten.joints, term)[place]
        share = square * getattr(plan.old, term)
        of_joint = getattr(file.compiled, f"dof_{term}")[dof]
        alone = share and not of_joint and nearly_equal(share + other, total)
        if alone and now >= other and not nearly_equal(total, now):
            new: dict[str, Any] = {term: float(now - other) / square}
            plan.new = replace(plan.new, **new)
            plan.halves[term] = spread.half(place, term) / square
            plan.unwritten = _without_term(plan.unwritten, term, place, total)


def _without_term(portable: Portable, term: str, place: int, value: float) -> Portable:
    """The model with the file's value of a joint term, so that it is not written at the joint."""
    values = getattr(portable.joints, term).copy()
    values[place] = value
    return replace(portable, joints=replace(portable.joints, **{term: values}))


def _plan_friction(file: File, plan: Plan, spread: Spread) -> None:
    """Coulomb and Stribeck friction as LuGre friction, if the motor has it."""
    if not (plan.old.stiffness and plan.old.gear):
        return
    place, gear = plan.place, abs(plan.old.gear)
    coulomb = _coulomb(file, plan) / gear
    plan.new = replace(plan.new, coulomb=coulomb, static=coulomb + plan.old.static - plan.old.coulomb)
    plan.halves["coulomb"] = plan.halves["static"] = spread.half(place, "dry") / gear
    if plan.old.fades:
        plan.new = replace(plan.new, static=coulomb)
    for effect, values in plan.unwritten.joint_effects(StribeckFriction, place):
        assert isinstance(effect, StribeckFriction)
        if not (values.any() or plan.old.fades):
            continue
        static = max(coulomb + float(values[0]) / gear, 0.0)
        plan.new = replace(plan.new, static=static, stribeck=effect.fade * gear)
        if effect.exponent != EXPONENT:
            remark = f"exponent {effect.exponent:g} of stribeck_friction: that of a dcmotor is {EXPONENT:g}"
            plan.unwritten = replace(plan.unwritten, remarks=(*plan.unwritten.remarks, remark))
        plan.halves["static"] = spread.half_of(
            dict.fromkeys((f"Fc{place + 1}", f"Fg{place + 1}", f"Fs{place + 1}"), 1.0 / gear)
        )
        plan.unwritten = plan.unwritten.without_effect(effect, 0.0 * values)


def _coulomb(file: File, plan: Plan) -> float:
    """Coulomb friction beyond the joint's `frictionloss` [N m]; raises `RobotError` if that has more."""
    place, total = plan.place, Portable.of(file.nominal).joints.dry[plan.place]
    of_joint = total - abs(plan.old.gear) * plan.old.coulomb
    identified = plan.unwritten.joints.dry[place]
    if identified < (1.0 - SAME) * of_joint:
        raise RobotError(
            f"{file.where}: joint '{plan.unwritten.robot.joints[place]}' has more frictionloss than the "
            f"identified {identified:.4g} of joint and dcmotor. Remove it from the joint"
        )
    plan.unwritten = _without_term(plan.unwritten, "dry", place, total)
    return max(float(identified - of_joint), 0.0)


def _write(file: File, plan: Plan, edits: Edits) -> Iterator[Change]:
    """Write the attributes of a motor whose numbers differ, and yield the changes."""
    old, new, robot = plan.old, plan.new, plan.unwritten.robot
    where = f"actuator '{name_of(file.compiled, 'actuator', old.index)}'"
    for attribute in dict.fromkeys(number.attribute for number in MOTOR_NUMBERS.values()):
        names = attribute_numbers(attribute)
        before, now = ([getattr(motor, name) for name in names] for motor in (old, new))
        if all(map(nearly_equal, before, now)):
            continue
        tag = file.elements.actuator(old.index)
        edits.set(tag, **{attribute: " ".join(f"{value:.{DIGITS}g}" for value in now)})
        if attribute == "damping" and "nominal" in tag.attributes:
            # MuJoCo derives the motor constant from the no-load speed, which damping changes
            constant = f"{old.constant:.{DIGITS}g}"
            edits.set(tag, motorconst=f"{constant} {constant}", resistance=f"{old.resistance:.{DIGITS}g}")
        for name, first, second in zip(names, before, now, strict=True):
            if not nearly_equal(first, second):
                title = attribute if attribute == name else f"{attribute} {name}"
                unit = robot.unit(plan.place, MOTOR_NUMBERS[name].unit)
                yield Change(where, title, unit, first, second, plan.halves.get(name, np.inf))


class Wave(NamedTuple):
    """One wave of the torque ripple of a joint."""

    effect: TorqueRipple  # ripple of this joint alone
    values: np.ndarray  # its parameters, shape (p,) [N m]
    columns: slice  # parameters of the wave: those of cosine and sine
    poles: float  # number of waves per turn of the file's motor [-]

    @property
    def amplitude(self) -> float:
        """Amplitude at the joint [N m]."""
        return float(np.hypot(*self.values[self.columns]))


def _with_cogging(
    motor: DcMotor, portable: Portable, place: int, halves: dict[str, float], spread: Spread
) -> tuple[DcMotor, Portable]:
    """The motor with the wave that the file's motor has, or else with the largest, and the model without it.

    The halves of the 95 % intervals of amplitude and phase are added to `halves`, by field of the motor.
    """

    def preference(wave: Wave) -> tuple[bool, float]:
        return bool(motor.amplitude) and _equal(wave.poles, abs(motor.poles)), wave.amplitude

    wave = max(_waves(motor, portable, place), key=preference, default=None)
    if wave is None or not any(preference(wave)):
        return motor, portable
    names = [parameter.name for parameter in wave.effect.parameters(portable.robot)][wave.columns]
    pair, zeroed = wave.values[wave.columns], wave.values.copy()
    zeroed[wave.columns] = 0.0
    halves |= _wave_halves(names, pair, motor.gear, spread)
    sign = np.sign(portable.robot.gear_ratio[place])  # the ripple counts turns of the robot's motor
    return _cogged(motor, wave.poles, pair * [1.0, sign]), portable.without_effect(wave.effect, zeroed)


def _waves(motor: DcMotor, portable: Portable, place: int) -> list[Wave]:
    """Waves of the joint; none if other joints turn its motor too."""
    robot = portable.robot
    if not motor.gear or np.any(robot.coupling[place] != np.eye(robot.dof)[place]):
        return []
    ratio = abs(robot.gear_ratio[place] / motor.gear)
    return [
        Wave(effect, values, slice(2 * k - 2, 2 * k), float(k * effect.harmonic * ratio))
        for effect, values in portable.joint_effects(TorqueRipple, place)
        if isinstance(effect, TorqueRipple)
        for k in range(1, effect.count + 1)
    ]


def _equal(poles: float, other: float) -> bool:
    return abs(poles - other) <= SAME * poles


def _cogged(motor: DcMotor, poles: float, wave: np.ndarray) -> DcMotor:
    """The motor with a cogging of this `wave` (2,) [N m]; unchanged if it is that of the file."""
    cosine, sine = wave.tolist()
    size = float(np.hypot(cosine, sine))
    if _equal(poles, abs(motor.poles)) and np.allclose(motor.wave, wave, rtol=0.0, atol=SAME * size):
        return motor
    if not size:
        return replace(motor, amplitude=0.0)
    phase = float(np.arctan2(-cosine / motor.gear, -sine / abs(motor.gear))) + 0.0
    return replace(motor, poles=poles, amplitude=size / abs(motor.gear), phase=phase)


def _wave_halves(names: list[str], wave: np.ndarray, gear: float, spread: Spread) -> dict[str, float]:
    """Halves of the 95 % intervals of amplitude [N m] and phase [rad]; the number of poles is a choice."""
    size = float(np.hypot(*wave))
    if not size:
        return {}
    rows = {"amplitude": wave / size / abs(gear), "phase": np.array([-wave[1], wave[0]]) / size**2}
    return {"poles": 0.0} | {
        field: spread.half_of(dict(zip(names, row.tolist(), strict=True))) for field, row in rows.items()
    }
