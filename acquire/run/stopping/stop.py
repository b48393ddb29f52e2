"""Stop: why a run ends before its time, and how hard."""

from collections.abc import Callable
from dataclasses import dataclass

from exidyn.drivers import StopLevel

FAULT, SILENT = "drive fault", "silence"
"""Kinds of stops: a drive has stopped itself and says why, a joint is not heard."""


@dataclass(frozen=True)
class Stop:
    """One reason to stop.

    Attributes:
        level: How hard.
        kind: A word: what was watched, or who asked.
        text: In a sentence, with joint, value and limit.
        joint: Name of the joint; empty for all or none.
        value: What was measured or asked for, in `unit`; NaN where there is none.
        limit: What it was held against.
        unit: Of value and limit.
    """

    level: StopLevel
    kind: str
    text: str
    joint: str = ""
    value: float = float("nan")
    limit: float = float("nan")
    unit: str = ""

    def details(self) -> dict[str, object]:
        """For the recording: what is known of it, by name."""
        known = {"joint": self.joint, "value": self.value, "limit": self.limit, "unit": self.unit}
        return {
            "stop": self.kind,
            "level": self.level.name,
            **{n: v for n, v in known.items() if v != "" and v == v},
        }


def harder(one: Stop | None, other: Stop | None) -> Stop | None:
    """The reason that counts: the first one, unless the second asks for more."""
    if one is None or other is None:
        return one or other
    return other if other.level > one.level else one


UnitOf = Callable[[int, str], str]
"""The unit of one joint, by its column, given that of revolute joints; `Robot.unit`."""


def turning(joint: int, unit: str) -> str:
    """The unit of a joint of an arm that has only revolute ones."""
    return unit
