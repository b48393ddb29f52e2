"""Numbers on the page of a gap: drive gains of the recordings, and what changes in the file."""

import numpy as np

from ..document.document import Block, Cell, Number, Paragraph, Table
from ..in_mujoco.gap import Gap
from ..in_mujoco.joint_numbers import UNITS
from ..in_mujoco.replay import TORQUE

STATED = (
    "All torques, and so masses, friction and kp, are proportional to these gains. A run with a known "
    "payload determines them: --payload RUN --mass KG."
)
UNDETERMINED = (
    "kp of {} cannot be determined from these runs to 10 %: friction exceeds the torque of the bodies there, "
    "or the validation runs follow no other kp better. Its friction and damping hold for this kp only"
)
IDENTIFIED = "All identified numbers belong to the identified gains."
SIMULATED = " Only the original file is simulated with the stated gains."
TOGETHER = (
    "Numbers whose 95 % interval contains that of the file are not listed ({} here). They are written all "
    "the same, since the mass, center and inertia of bodies give the recorded torque only together."
)


def drive_gains(gap: Gap) -> list[Block]:
    """Gains that turn recorded currents into torque; empty if no currents were recorded."""
    gains = gap.drive_gains
    if gains is None:
        return []
    columns = [("stated [N m/A]", gains.stated, 4)]
    words = STATED
    if gains.identified is not None and gains.half is not None:
        columns += [("identified [N m/A]", gains.identified, 4), ("± 95 %", gains.half, 2)]
        words = IDENTIFIED + SIMULATED * (gap.commands == TORQUE)
    rows: list[list[Cell]] = [
        [name, *(Number(float(values[joint]), digits) for _, values, digits in columns)]
        for joint, name in enumerate(gap.diagnosis.joints)
    ]
    return [Table(["joint", *(title for title, _, _ in columns)], rows), Paragraph(words)]


def servos(gap: Gap) -> list[Block]:
    """Changed numbers of the servos, at the joints."""
    rows: list[list[Cell]] = [
        [gap.diagnosis.joints[change.joint], change.quantity, UNITS[change.quantity],
         Number(change.old, 4), Number(change.new, 4), Number(change.half, 2)]
        for change in gap.servos
    ]  # fmt: skip
    head = ["joint", "servo", "unit", "file", "identified", "± 95 %"]
    return [Table(head, rows, words=(1, 2))] if rows else []


def changed_numbers(gap: Gap) -> list[Block]:
    """Changed numbers of the file by itself; those that may be unchanged are only counted."""
    # An unknown interval is no sign that a number is unchanged: the file got an element that it did not have.
    changed = [change for change in gap.file.changes if change.told_apart or not np.isfinite(change.half)]
    blocks: list[Block] = []
    if changed:
        rows: list[list[Cell]] = []
        for where in dict.fromkeys(change.where for change in changed):
            rows.append([where])  # the name of the element, above its numbers
            for change in (change for change in changed if change.where == where):
                numbers = Number(change.old), Number(change.new), Number(change.half, 2)
                rows.append([change.attribute, change.unit, *numbers])
        blocks.append(Table(["changed", "unit", "file", "identified", "± 95 %"], rows, words=(1,)))
    if unlisted := len(gap.file.changes) - len(changed):
        blocks.append(Paragraph(TOGETHER.format(unlisted)))
    return blocks
