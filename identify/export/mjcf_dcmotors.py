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
from ..robot_files.mjcf_elements import JOINT_TERMS, MOTOR_NUMBERS, attribute_numbers, name_of
from .changes import DIGITS, SAME, Change, Spread, nearly_equal
from .mjcf_changes import File
from .portable import Portable
from .xml_text import Edits

EXPONENT = 2.0
"""Exponent with which Stribeck friction of MuJoCo's LuGre model fades [-]."""


def write_motors(
    file: File, portable: Portable, spread: Spread, edits: Edits
) -> tuple[list[Change], list[DcMotor], Portable]:
    """Write all DC motors; returns changes, new motors, and the model without what they represent."""
    changes, motors, unwritten = list[Change](), list[DcMotor](), portable
    for motor in dc_motors(file.compiled, file.joints):
        plan = _Plan(file, spread, file.joints.index(motor.joint), motor, motor, unwritten)
        plan.take_rotor()
        plan.take_friction()
        plan.take_ripple()
        changes += plan.write(edits)
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


@dataclass
class _Plan:
    """A motor of the file, its new numbers, and the part of the model that others have to represent."""

    file: File  # the file
    spread: Spread  # intervals of the model
    place: int  # index of the joint in the robot
    old: DcMotor  # motor in the file
    new: DcMotor  # motor with the identified numbers
    unwritten: Portable  # model without what motors represent: such joint terms are those of the file
    halves: dict[str, float] = field(default_factory=dict)  # field of the motor -> half of its 95 % interval

    def _original(self, term: str) -> float:
        """Value of a joint term in the file, joint and actuators together."""
        return float(getattr(Portable.of(self.file.nominal).joints, term)[self.place])

    def _leave(self, term: str) -> None:
        """Keep the file's value of a joint term, so that it is not written at the joint."""
        joints = self.unwritten.joints
        values = getattr(joints, term).copy()
        values[self.place] = self._original(term)
        self.unwritten = replace(self.unwritten, joints=replace(joints, **{term: values}))

    def take_rotor(self) -> None:
        """Take armature and damping, if the motor alone has them."""
        square, dof = self.old.gear**2, self.file.compiled.jnt_dofadr[self.old.joint]
        shorted = self.old.back_emf if self.old.input == SHORTED else 0.0
        for term, other in (("armature", 0.0), ("damping", shorted)):
            total, now = self._original(term), float(getattr(self.unwritten.joints, term)[self.place])
            share = square * getattr(self.old, term)
            of_joint = JOINT_TERMS[term].read(self.file.compiled, dof)
            alone = share and not of_joint and nearly_equal(share + other, total)
            if alone and now >= other and not nearly_equal(total, now):
                new: dict[str, Any] = {term: (now - other) / square}
                self.new = replace(self.new, **new)
                self.halves[term] = self.spread.half(self.place, term) / square
                self._leave(term)

    def take_friction(self) -> None:
        """Take Coulomb and Stribeck friction as LuGre friction, if the motor has it.

        The joint keeps its own `frictionloss`. Raises `RobotError` if that has more than was identified.
        """
        old, place, gear = self.old, self.place, abs(self.old.gear)
        if not (old.stiffness and gear):
            return
        of_joint = self._original("dry") - gear * old.coulomb
        identified = float(self.unwritten.joints.dry[place])
        if identified < (1.0 - SAME) * of_joint:
            raise RobotError(
                f"{self.file.where}: joint '{self.unwritten.robot.joints[place]}' has more frictionloss than "
                f"the identified {identified:.4g} of joint and dcmotor. Remove it from the joint"
            )
        self._leave("dry")
        coulomb = max(identified - of_joint, 0.0) / gear
        static = coulomb if old.fades else coulomb + old.static - old.coulomb
        self.new = replace(self.new, coulomb=coulomb, static=static)
        self.halves["coulomb"] = self.halves["static"] = self.spread.half(place, "dry") / gear
        for effect, values in self.unwritten.joint_effects(StribeckFriction, place):
            assert isinstance(effect, StribeckFriction)
            if not (values.any() or old.fades):
                continue
            static = max(coulomb + float(values[0]) / gear, 0.0)
            self.new = replace(self.new, static=static, stribeck=effect.fade * gear)
            if effect.exponent != EXPONENT:
                remark = (
                    f"exponent {effect.exponent:g} of stribeck_friction: that of a dcmotor is {EXPONENT:g}"
                )
                self.unwritten = replace(self.unwritten, remarks=(*self.unwritten.remarks, remark))
            names = (f"Fc{place + 1}", f"Fg{place + 1}", f"Fs{place + 1}")
            self.halves["static"] = self.spread.half_of(dict.fromkeys(names, 1.0 / gear))
            self.unwritten = self.unwritten.without_effect(effect, 0.0 * values)

    def take_ripple(self) -> None:
        """Take the wave that the file's motor has, or else the largest, as cogging."""
        old, robot = self.old, self.unwritten.robot

        def preference(wave: Wave) -> tuple[bool, float]:
            return bool(old.amplitude) and _equal(wave.poles, abs(old.poles)), wave.amplitude

        wave = max(self._waves(), key=preference, default=None)
        if wave is None or not any(preference(wave)):
            return
        names = [parameter.name for parameter in wave.effect.parameters(robot)][wave.columns]
        pair, zeroed = wave.values[wave.columns], wave.values.copy()
        zeroed[wave.columns] = 0.0
        self.halves |= _wave_halves(names, pair, old.gear, self.spread)
        sign = np.sign(robot.gear_ratio[self.place])  # the ripple counts turns of the robot's motor
        self.new = _cogged(self.new, wave.poles, pair * [1.0, sign])
        self.unwritten = self.unwritten.without_effect(wave.effect, zeroed)

    def _waves(self) -> list[Wave]:
        """Waves of the joint; none if other joints turn its motor too."""
        robot, gear = self.unwritten.robot, self.old.gear
        if not gear or np.any(robot.coupling[self.place] != np.eye(robot.dof)[self.place]):
            return []
        ratio = abs(robot.gear_ratio[self.place] / gear)
        return [
            Wave(effect, values, slice(2 * k - 2, 2 * k), float(k * effect.harmonic * ratio))
            for effect, values in self.unwritten.joint_effects(TorqueRipple, self.place)
            if isinstance(effect, TorqueRipple)
            for k in range(1, effect.count + 1)
        ]

    def write(self, edits: Edits) -> Iterator[Change]:
        """Write the attributes whose numbers differ, and yield the changes."""
        old, new, robot = self.old, self.new, self.unwritten.robot
        where = f"actuator '{name_of(self.file.compiled, 'actuator', old.index)}'"
        for attribute in dict.fromkeys(number.attribute for number in MOTOR_NUMBERS.values()):
            names = attribute_numbers(attribute)
            before, now = ([getattr(motor, name) for name in names] for motor in (old, new))
            if all(map(nearly_equal, before, now)):
                continue
            tag = self.file.elements.tag("actuator", old.index)
            edits.set(tag, **{attribute: " ".join(f"{value:.{DIGITS}g}" for value in now)})
            if attribute == "damping" and "nominal" in tag.attributes:
                # MuJoCo derives the motor constant from the no-load speed, which damping changes
                constant = f"{old.constant:.{DIGITS}g}"
                edits.set(tag, motorconst=f"{constant} {constant}", resistance=f"{old.resistance:.{DIGITS}g}")
            for name, first, second in zip(names, before, now, strict=True):
                if not nearly_equal(first, second):
                    title = attribute if attribute == name else f"{attribute} {name}"
                    unit = robot.unit(self.place, MOTOR_NUMBERS[name].unit)
                    yield Change(where, title, unit, first, second, self.halves.get(name, np.inf))


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
