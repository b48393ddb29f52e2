"""Numbers of joints and of their position servos: where a simulation has them, and how they are written."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arm.robot import Robot, ServoLaw
from ..export.mjcf_changes import DIGITS, TERMS, Change
from ..export.mjcf_controller import with_servo_law
from ..export.xml_text import Edits, Elements, read_tags
from ..robot_files.mjcf import compile_mjcf
from ..robot_files.mjcf_drives import servo_law, servos
from .replay import POSITION
from .servo_changes import QUANTITIES, ServoChange, changed_law
from .trial import Source

KP, DAMPING, DRY, ARMATURE, LIMIT, DELAY = range(6)
"""Rows of joint numbers: stiffness of the servo [N m/rad]; damping of joint and servo together, which move
the arm alike [N m s/rad]; dry friction [N m]; armature [kg m^2]; torque limit of the servo, infinite for none
[N m]; delay of its commands [s]."""
TERM_OF = {DRY: "dry", ARMATURE: "armature"}
"""Row -> term of the joint in the file."""
FIELDS = {"dry": "dof_frictionloss", "armature": "dof_armature", "damping": "dof_damping"}
"""Term of a joint -> field of the compiled model."""


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
        terms = {name: np.array(getattr(self.compiled, field)[self._dofs]) for name, field in FIELDS.items()}
        self._damping = terms["damping"]
        self.values = np.array(
            [law.stiffness, law.damping + terms["damping"], terms["dry"], terms["armature"], law.limit,
             law.delay]
        )  # fmt: skip

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
            getattr(model, FIELDS[term])[self._dofs] = values[row]
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
        for joint, term, old, new, half in self._terms(values, halves):
            attribute, unit = TERMS[term]
            name = self.robot.joints[joint]
            present = getattr(compiled, FIELDS[term])[self._dofs[joint]]
            if new != present:
                tag = elements.joint(int(compiled.joint(name).id))
                edits.set(tag, **{attribute: f"{new:.{DIGITS}g}"})
            if new != old:
                unit = self.robot.unit(joint, unit)
                changes.append(Change(f"joint '{name}'", attribute, unit, old, new, half))
        return edits.text(), tuple(changes)

    def _terms(
        self, values: np.ndarray, halves: np.ndarray
    ) -> Iterator[tuple[int, str, float, float, float]]:
        """Joint, term, number of the file, new number and half of its 95 % interval."""
        _, damping = self.split_damping(values)
        for joint in range(self.robot.dof):
            half = halves[:, joint].tolist()
            for row, term in TERM_OF.items():
                yield joint, term, float(self.values[row, joint]), float(values[row, joint]), half[row]
            yield joint, "damping", float(self._damping[joint]), float(damping[joint]), half[DAMPING]
