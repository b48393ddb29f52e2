"""Numbers of joints and of their position servos: where a simulation has them, and how they are written."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import norm

from ..arm.robot import Robot, ServoLaw
from ..export.changes import DIGITS, Change
from ..export.mjcf_servos import with_servo_law
from ..export.xml_text import Edits, Elements, read_tags
from ..fit.servo_fit import LONGEST, ServoFit
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import servo_law, servos
from ..robot_files.mjcf_elements import JOINT_TERMS
from ..text_table import NORMAL_95
from .replay import POSITION
from .trial import Source

KP, DAMPING, DRY, ARMATURE, LIMIT, DELAY = range(6)
"""Rows of joint numbers: stiffness of the servo [N m/rad]; damping of joint and servo together, which move
the arm alike [N m s/rad]; dry friction [N m]; armature [kg m^2]; torque limit of the servo, infinite for none
[N m]; delay of its commands [s]."""
TERM_OF = {DRY: "dry", ARMATURE: "armature"}
"""Row -> term of the joint in the file."""
TERMS = ("dry", "armature", "damping")
"""Terms of a joint that are written."""
QUANTITIES = {"kp": "stiffness", "kv": "damping", "forcerange": "limit", "delay": "delay"}
"""Attribute of a servo -> field of `ServoLaw`."""
UNITS = {"kp": "N m/rad", "kv": "N m s/rad", "forcerange": "N m", "delay": "s"}
DETERMINED = 0.1
"""Largest relative standard deviation of a stiffness that counts as determined."""
ACCURACY = 5.0
"""Relative accuracy of all numbers but delays per sampling period [1/s], 2 % at 4 ms: signals are sampled
somewhere within a cycle, and commands may jump between, so gains are off by some percent whatever their
intervals are."""
CYCLE = 1.0 / np.sqrt(12.0)
"""Standard deviation of a moment within a sampling period, over the period."""


@dataclass(frozen=True)
class ServoChange:
    """A number of a servo that differs from the file's."""

    joint: int  # index of the joint, from 0
    quantity: str  # "kp", "kv", "forcerange" or "delay"
    old: float  # number of the file, at the joint; infinite for a servo without a limit
    new: float  # identified number
    half: float  # half of its 95 % interval


class JointNumbers:
    """The numbers of all joints of a robot in a file, and versions of them.

    Numbers of servos are left out if torque is commanded. With `fixed`, the damping of servos is known, so
    that only that of joints changes.
    """

    def __init__(self, source: Source, robot: Robot, commands: str = POSITION, fixed: bool = False) -> None:
        self.source, self.robot, self._fixed = source, robot, fixed
        self.compiled = compile_mjcf(source.text.decode(), source.folder)
        law, nothing = servo_law(self.compiled, robot.joints), np.zeros(robot.dof)
        if law is None or commands != POSITION:
            law = ServoLaw.of(nothing, nothing, np.full(robot.dof, np.inf), nothing)
        self.law = law
        self._servos = servos(self.compiled, robot.joints) if np.any(law.stiffness) else []
        self._dofs = [int(self.compiled.joint(name).dofadr[0]) for name in robot.joints]
        dry, armature, self._damping = (
            np.array(getattr(self.compiled, JOINT_TERMS[term].table)[self._dofs]) for term in TERMS
        )
        damping = law.damping + self._damping
        self.values = np.array([law.stiffness, damping, dry, armature, law.limit, law.delay])

    def split_damping(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Damping of servos and of joints, shape (n,) each, as near to the file as possible."""
        least = np.zeros(self.robot.dof) if self._fixed else self._damping
        of_servo = np.clip(values[DAMPING] - least, 0.0, self.law.damping)
        inside = (of_servo > 0.0) & (of_servo < self.law.damping)
        of_joint = np.where(inside, least, values[DAMPING] - of_servo)
        unchanged = values[DAMPING] == self.values[DAMPING]
        return np.where(unchanged, self.law.damping, of_servo), np.where(unchanged, self._damping, of_joint)

    def set(self, model: Any, values: np.ndarray) -> None:
        """Set the numbers, shape (6, n), except delays, in a compiled model."""
        of_servo, damping = self.split_damping(values)
        model.dof_damping[self._dofs] = damping
        for row, term in TERM_OF.items():
            getattr(model, JOINT_TERMS[term].table)[self._dofs] = values[row]
        for joint, servo in enumerate(self._servos):
            gear = model.actuator_gear[servo, 0]
            model.actuator_gainprm[servo, 0] = values[KP, joint] / gear**2
            model.actuator_biasprm[servo, 1:3] = -np.array([values[KP, joint], of_servo[joint]]) / gear**2
            if values[LIMIT, joint] != self.values[LIMIT, joint]:
                model.actuator_forcelimited[servo] = True
                model.actuator_forcerange[servo] = values[LIMIT, joint] / abs(gear) * np.array([-1.0, 1.0])

    def servo_changes(self, values: np.ndarray, halves: np.ndarray) -> tuple[ServoChange, ...]:
        """Numbers of servos that differ from the file's; `halves` (6, n) are halves of 95 % intervals."""
        of_servo, _ = self.split_damping(values)
        rows = {
            "kp": (self.law.stiffness, values[KP], halves[KP]),
            "kv": (self.law.damping, of_servo, halves[DAMPING]),
            "forcerange": (self.law.limit, values[LIMIT], halves[LIMIT]),
            "delay": (self.law.delay, values[DELAY], halves[DELAY]),
        }
        return tuple(
            ServoChange(joint, name, *(float(column[joint]) for column in columns))
            for joint in range(self.robot.dof)
            for name, columns in rows.items()
            if columns[0][joint] != columns[1][joint]
        )

    def with_servos(self, changes: tuple[ServoChange, ...]) -> Source:
        """The file with these numbers of its servos."""
        if not changes:
            return self.source
        fields = {QUANTITIES[change.quantity] for change in changes}
        law, (text, folder, where) = changed_law(self.law, changes), self.source
        text = with_servo_law(text, folder, where, self.robot.joints, law, fields)
        return self.source._replace(text=text)

    def with_joints(
        self, text: bytes, values: np.ndarray, halves: np.ndarray
    ) -> tuple[bytes, tuple[Change, ...]]:
        """A text with friction, damping and armature of joints, and how it differs from the file."""
        edits, where = Edits(text), self.source.where
        compiled = compile_mjcf(text.decode(), self.source.folder)
        elements, changes = Elements(read_tags(text, where), compiled, where), []
        _, damping = self.split_damping(values)
        for joint, name in enumerate(self.robot.joints):
            numbers = {
                "dry": (self.values[DRY, joint], values[DRY, joint], halves[DRY, joint]),
                "armature": (self.values[ARMATURE, joint], values[ARMATURE, joint], halves[ARMATURE, joint]),
                "damping": (self._damping[joint], damping[joint], halves[DAMPING, joint]),
            }
            for term, row in numbers.items():
                number, (old, new, half) = JOINT_TERMS[term], map(float, row)
                if new != number.read(compiled, self._dofs[joint]):
                    tag = elements.tag("joint", int(compiled.joint(name).id))
                    edits.set(tag, **{number.attribute: f"{new:.{DIGITS}g}"})
                if new != old:
                    unit = self.robot.unit(joint, number.unit)
                    changes.append(Change(f"joint '{name}'", number.attribute, unit, old, new, half))
        return edits.text(), tuple(changes)


def servo_changes(fit: ServoFit, file: ServoLaw) -> tuple[ServoChange, ...]:
    """Numbers of the file's servos that servos identified by measured torque exclude.

    Only joints change whose gains the runs determine. Delays are those of simulations, since torque is
    sampled within a cycle.
    """
    law, std, accuracy = fit.law, fit.std, 0.5 * ACCURACY * fit.period
    known = np.isfinite(law.stiffness) & (law.stiffness > 0.0) & (law.damping > -3.0 * std.damping)
    known &= law.delay < LONGEST  # what fits best beyond that is no delay
    known &= std.stiffness < DETERMINED * np.abs(law.stiffness)
    of_damping = accuracy * law.damping + CYCLE * fit.period * law.stiffness / 4.0
    stds = {
        "kp": np.hypot(std.stiffness, accuracy * law.stiffness),
        "kv": np.hypot(std.damping, of_damping),
        "forcerange": std.limit,
    }
    # Standard deviations that no number of all servos exceeds by chance, with 95 % confidence.
    sure = float(norm.ppf(1.0 - 0.025 / (len(known) * len(stds))))
    changes = []
    for joint in np.flatnonzero(known).tolist():
        for quantity, spread in stds.items():
            new, old = (float(getattr(of, QUANTITIES[quantity])[joint]) for of in (law, file))
            if np.isfinite(new) and abs(new - old) > sure * spread[joint]:
                half = NORMAL_95 * float(spread[joint])
                changes.append(ServoChange(joint, quantity, old, max(new, 0.0), half))
    return tuple(changes)


def changed_law(file: ServoLaw, changes: tuple[ServoChange, ...]) -> ServoLaw:
    """The law of the file with the changes."""
    values = {name: np.array(getattr(file, name)) for name in QUANTITIES.values()}
    for change in changes:
        values[QUANTITIES[change.quantity]][change.joint] = change.new
    return replace(file, **values)
