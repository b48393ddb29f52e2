"""Numbers of the DC motors of an MJCF: each is written once, at the `dcmotor` or at its joint.

LuGre friction takes the Coulomb and Stribeck friction of its joint, except what `frictionloss` already has.
Armature and damping are written at the motor if the joint has none of its own. One wave of torque ripple per
joint becomes the motor's cogging.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..effects import StribeckFriction, TorqueRipple
from ..errors import RobotError
from ..robot_files.mjcf_dcmotors import SHORTED, DcMotor, dc_motors
from ..robot_files.mjcf_names import name_of
from .mjcf_changes import DIGITS, SAME, Change, File, nearly_equal
from .mjcf_cogging import with_cogging
from .portable import Portable
from .spread import Spread
from .xml_text import Edits

UNITS = {"armature": "kg m^2", "damping": "N m s/rad"}
"""Attribute that holds one number, and its unit."""
LISTS: Mapping[str, Mapping[str, str]] = {
    "lugre": {
        "stiffness": "N m/rad", "bristle_damping": "N m s/rad", "coulomb": "N m", "static": "N m",
        "stribeck": "rad/s",
    },
    "cogging": {"amplitude": "N m", "poles": "1", "phase": "rad"},
}  # fmt: skip
"""Attribute that holds several numbers -> their fields of `DcMotor` and units, in order."""


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
    """Write the numbers of all DC motors.

    Returns:
        Changes, motors with the new numbers, and the model without what the motors represent.

    Raises:
        RobotError: The file cannot represent the friction of a joint with LuGre friction.
    """
    changes, motors, unwritten = list[Change](), list[DcMotor](), portable
    for motor in dc_motors(file.compiled, file.joints):
        plan = Plan(file.joints.index(motor.joint), motor, motor, unwritten)
        _plan_rotor(file, plan, spread)
        _plan_friction(file, plan, spread)
        plan.new, plan.unwritten = with_cogging(plan.new, plan.unwritten, plan.place, plan.halves, spread)
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
        alone = (
            share and not getattr(file.compiled, f"dof_{term}")[dof] and nearly_equal(share + other, total)
        )
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
    for attribute, units in {**{name: {name: unit} for name, unit in UNITS.items()}, **LISTS}.items():
        before, now = ([getattr(motor, name) for name in units] for motor in (old, new))
        if all(map(nearly_equal, before, now)):
            continue
        tag = file.elements.actuator(old.index)
        edits.set(tag, **{attribute: " ".join(f"{value:.{DIGITS}g}" for value in now)})
        if attribute == "damping" and "nominal" in tag.attributes:
            # MuJoCo derives the motor constant from the no-load speed, which damping changes
            constant = f"{old.constant:.{DIGITS}g}"
            resistance = f"{old.resistance:.{DIGITS}g}"
            edits.set(tag, motorconst=f"{constant} {constant}", resistance=resistance)
        for (name, unit), first, second in zip(units.items(), before, now, strict=True):
            if not nearly_equal(first, second):
                title = attribute if attribute == name else f"{attribute} {name}"
                half = plan.halves.get(name, np.inf)
                yield Change(where, title, robot.unit(plan.place, unit), first, second, half)
