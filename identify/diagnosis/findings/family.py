"""Families: effects whose torque has similar shapes over the quantity on which it depends.

If data show that friction grows less than linearly with velocity, several formulas often fit about equally
well. Then the family is certain and its member is not.
"""

from collections.abc import Callable
from typing import NamedTuple

from ..questions.candidate import Candidate


class Family(NamedTuple):
    """Effects that differ only in their formulas."""

    dependence: str  # quantity on which their torque depends; several families may share it
    words: str  # description that completes "joint 3 has ..."


DEPENDENCES: dict[str, str] = {
    "velocity": "friction that depends on velocity otherwise than in the model",
    "direction": "friction that differs between the two directions",
    "load": "friction that depends on the load",
    "position": "a torque that depends on the joint's position",
    "position and direction": "friction that depends on the joint's position",
    "waves": "a torque in waves along a turn",
    "other joints": "a torque that depends on another joint",
    "history": "friction that builds up after each reversal",
    "temperature": "friction that changes with temperature",
    "delay": "a current that is not recorded at the time of the position",
    "elasticity": "a gear that gives way",
    "gravity": "gravity in another direction than in the model",
    "mass": "another mass or inertia than in the model",
    "drive": "another torque per current than in the model",
    "kinematics": "an angle or an axis that is elsewhere",
    "event": "a force that acts once",
    "time": "a torque that depends on time, whatever the arm does",
}
"""Description that completes "joint 3 has ...", by the quantity on which a torque may depend."""

FAMILIES: dict[str, Family] = {name: Family(name, words) for name, words in DEPENDENCES.items()} | {
    "friction level": Family("velocity", "friction of another size than in the model"),
    "sublinear": Family("velocity", "friction that grows less than linearly with velocity"),
    "superlinear": Family("velocity", "friction that grows more than linearly with velocity"),
    "low speed": Family("velocity", "friction that rises towards standstill"),
}
"""Families by name. A dependence is also the family of all effects with that dependence."""

FamilyOf = Callable[[Candidate], str]
"""Function that gives the family of a candidate whose effect belongs to different families by its shape."""
