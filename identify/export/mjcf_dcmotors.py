"""Numbers of the DC motors of an MJCF: each is written once, at the `dcmotor` or at its joint.

LuGre friction takes the Coulomb and Stribeck friction of its joint, except what `frictionloss` already has.
Armature and damping are written at the motor if the joint has none of its own. One wave of torque ripple per
joint becomes the motor's cogging.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..effects import Effect, StribeckFriction, TorqueRipple
from ..effects.effect import JointEffect
from ..errors import RobotError
from ..robot_files.mjcf_dcmotors import SHORTED, DcMotor, dc_motors
from ..robot_files.mjcf_names import name_of
from .mjcf_changes import DIGITS, SAME, Change, File, nearly_equal
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
Pair = tuple[Effect, np.ndarray]


@dataclass
class Plan:
    """A motor of the file, its new numbers, and the part of the model that others have to represent.

    Attributes:
        place: Index of the joint in the robot.
        old: Motor in the file.
        new: Motor with the identified numbers.
        rest: Model without what the motor represents: such joint terms are those of the file.
        halves: Field of the motor -> half of its 95 % interval.
    """

    place: int
    old: DcMotor
    new: DcMotor
    rest: Portable
    halves: dict[str, float] = field(default_factory=dict)


def write_motors(
    file: File, portable: Portable, spread: Spread, edits: Edits
) -> tuple[list[Change], list[DcMotor], Portable]:
    """Write the numbers of all DC motors.

    Returns:
        Changes, motors with the new numbers, and the model without what the motors represent.

    Raises:
        RobotError: The file cannot represent the friction of a joint with LuGre friction.
    """
    changes, motors, rest = list[Change](), list[DcMotor](), portable
    for motor in dc_motors(file.compiled, file.joints):
        plan = Plan(file.joints.index(motor.joint), motor, motor, rest)
        _plan_rotor(file, plan, spread)
        _plan_friction(file, plan, spread)
        _plan_cogging(plan, spread)
        changes += _write(file, plan, edits)
        motors.append(plan.new)
        rest = plan.rest
    return changes, motors, rest


def kept_cogging(file: File, portable: Portable) -> list[str]:
    """Sentences about cogging in the file that the model does not have, and which stays there."""
    return [
        f"cogging of dcmotor '{name_of(file.compiled, 'actuator', motor.index)}' stays in the file, although "
        "the model has no torque_ripple of its joint"
        for motor in dc_motors(file.compiled, file.joints)
        if motor.amplitude and not _of_joint(portable, TorqueRipple, file.joints.index(motor.joint))
    ]


def require_motors(compiled: Any, motors: list[DcMotor], where: str) -> None:
    """Check that the motors compiled from the new text have the intended numbers.

    Raises:
        RobotError: They have other numbers.
    """
    for wanted in motors:
        made = DcMotor.of(compiled, wanted.index)
        for name, value in vars(wanted).items():
            actual = getattr(made, name)
            if abs(actual - value) > SAME * max(abs(actual), abs(value)):
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
        now = getattr(plan.rest.joints, term)[place]
        share = square * getattr(plan.old, term)
        alone = (
            share and not getattr(file.compiled, f"dof_{term}")[dof] and nearly_equal(share + other, total)
        )
        if alone and now >= other and not nearly_equal(total, now):
            new: dict[str, Any] = {term: float(now - other) / square}
            plan.new = replace(plan.new, **new)
            plan.halves[term] = spread.half(place, term) / square
            plan.rest = _without_term(plan.rest, term, place, total)


def _without_term(portable: Portable, term: str, place: int, value: float) -> Portable:
    """The model with the file's value of a joint term, so that it is not written at the joint."""
    values = getattr(portable.joints, term).copy()
    values[place] = value
    return replace(portable, joints=replace(portable.joints, **{term: values}))


def _plan_friction(file: File, plan: Plan, spread: Spread) -> None:
    """Coulomb and Stribeck friction as LuGre friction, if the motor has it."""
    old, place, gear = plan.old, plan.place, abs(plan.old.gear)
    if not (old.stiffness and gear):
        return
    name, total = plan.rest.robot.joints[place], Portable.of(file.nominal).joints.dry[place]
    others = total - gear * old.coulomb
    now, fading = plan.rest.joints.dry[place] - others, _of_joint(plan.rest, StribeckFriction, place)
    if now < -SAME * others:
        raise RobotError(
            f"{file.where}: joint '{name}' has more frictionloss than the identified {now + others:.4g} of "
            "joint and dcmotor. Remove it from the joint"
        )
    coulomb, extra, stribeck = max(now, 0.0) / gear, 0.0, old.stribeck
    plan.halves["coulomb"] = plan.halves["static"] = spread.half(place, "dry") / gear
    for effect, [value] in fading:
        assert isinstance(effect, StribeckFriction)
        extra, stribeck = float(value) / gear, effect.fade * gear
        weights = dict.fromkeys((f"Fc{place + 1}", f"Fg{place + 1}", f"Fs{place + 1}"), 1.0 / gear)
        plan.halves["static"] = spread.half_of(weights)
    static = max(coulomb + extra, 0.0) if extra or old.fades else coulomb + old.static - old.coulomb
    plan.new = replace(plan.new, coulomb=float(coulomb), static=float(static), stribeck=float(stribeck))
    plan.rest = _without_term(plan.rest, "dry", place, total)
    for effect, values in fading:
        plan.rest = _without_effect(plan.rest, effect, 0.0 * values)


def _plan_cogging(plan: Plan, spread: Spread) -> None:
    """The wave of torque ripple that the file's motor has, or else the largest, as cogging."""
    robot, old, place = plan.rest.robot, plan.old, plan.place
    if not old.gear or np.any(robot.coupling[place] != np.eye(robot.dof)[place]):
        return
    candidates = [
        (effect, values, k, abs(k * effect.harmonic * robot.gear_ratio[place] / old.gear))
        for effect, values in _of_joint(plan.rest, TorqueRipple, place)
        if isinstance(effect, TorqueRipple)
        for k in range(1, effect.count + 1)
    ]
    if not candidates:
        return

    def preference(candidate: tuple[TorqueRipple, np.ndarray, int, float]) -> tuple[bool, float]:
        _, values, k, poles = candidate
        same = bool(old.amplitude) and abs(poles - abs(old.poles)) <= SAME * poles
        return same, float(np.hypot(*values[2 * k - 2 : 2 * k]))

    effect, values, k, poles = max(candidates, key=preference)
    columns = slice(2 * k - 2, 2 * k)
    if not (np.any(values[columns]) or preference((effect, values, k, poles))[0]):
        return
    plan.new = _with_wave(plan.new, poles, values[columns] * [1.0, np.sign(robot.gear_ratio[place])])
    names = [parameter.name for parameter in effect.parameters(robot)][columns]
    plan.halves["amplitude"], plan.halves["phase"] = _halves(names, values[columns], old.gear, spread)
    plan.halves["poles"] = 0.0
    remaining = values.copy()
    remaining[columns] = 0.0
    plan.rest = _without_effect(plan.rest, effect, remaining)


def _with_wave(motor: DcMotor, poles: float, wave: np.ndarray) -> DcMotor:
    """The motor with a cogging of this `wave` (2,) [N m]; unchanged if it is that of the file."""
    if abs(poles - abs(motor.poles)) <= SAME * poles and np.allclose(
        motor.wave, wave, rtol=0.0, atol=SAME * float(np.hypot(*wave))
    ):
        return motor
    if not np.any(wave):
        return replace(motor, amplitude=0.0)
    cosine, sine = wave.tolist()
    phase = np.arctan2(-cosine / motor.gear, -sine / abs(motor.gear))
    amplitude = float(np.hypot(cosine, sine)) / abs(motor.gear)
    return replace(motor, poles=poles, amplitude=amplitude, phase=float(phase) + 0.0)


def _halves(names: list[str], wave: np.ndarray, gear: float, spread: Spread) -> tuple[float, float]:
    """Halves of the 95 % intervals of amplitude [N m] and phase [rad]."""
    size = float(np.hypot(*wave))
    if not size:
        return np.inf, np.inf
    along, across = wave / size / abs(gear), np.array([-wave[1], wave[0]]) / size**2
    amplitude, phase = (
        spread.half_of(dict(zip(names, row.tolist(), strict=True))) for row in (along, across)
    )
    return amplitude, phase


def _of_joint(portable: Portable, kind: type[JointEffect], place: int) -> list[Pair]:
    """Effects of a kind on one joint, each split off from those on other joints."""
    return [
        pair
        for effect, values in portable.others
        if isinstance(effect, kind)
        for pair in _apart(portable, effect, values)
        if pair[0].parameter_joints(portable.robot)[0] == place
    ]


def _apart(portable: Portable, effect: Effect, values: np.ndarray) -> list[Pair]:
    parts = effect.apart(portable.robot)
    return list(zip(parts, np.split(values, len(parts)), strict=True))


def _without_effect(portable: Portable, part: Effect, remaining: np.ndarray) -> Portable:
    """The model in which a part of an effect has only the remaining values (p,)."""
    others: list[Pair] = []
    for effect, values in portable.others:
        pieces = _apart(portable, effect, values) if type(effect) is type(part) else []
        if part not in [piece for piece, _ in pieces]:
            others.append((effect, values))
            continue
        pieces = [(piece, remaining if piece == part else share) for piece, share in pieces]
        others += [(piece, share) for piece, share in pieces if np.any(share)]
    return replace(portable, others=tuple(others))


def _write(file: File, plan: Plan, edits: Edits) -> Iterator[Change]:
    """Write the attributes of a motor whose numbers differ, and yield the changes."""
    old, new, robot = plan.old, plan.new, plan.rest.robot
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
