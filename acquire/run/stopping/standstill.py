"""Standstill: whether the arm stands when a run has ended, as a person has to be told."""

from collections.abc import Sequence
from dataclasses import dataclass

EMERGENCY = "PRESS THE EMERGENCY STOP"


@dataclass(frozen=True)
class Standstill:
    """Whether the arm stands.

    Attributes:
        moving: Whether it still moves; None where that is not known.
        text: In a sentence, with joint, speed and what to do.
        joint: Name of the fastest joint; empty where the arm stands or nothing is known.
        speed: Of that joint, in `unit`; NaN where unknown.
        unit: Of the speed.
    """

    moving: bool | None
    text: str
    joint: str = ""
    speed: float = float("nan")
    unit: str = ""

    @property
    def stands(self) -> bool:
        """Whether the arm is known to stand."""
        return self.moving is False

    def details(self) -> dict[str, object]:
        """For JSON and the recording."""
        speed = {"joint": self.joint, "speed": self.speed, "unit": self.unit} if self.joint else {}
        return {"moving": self.moving, "standstill": self.text, **speed}


def speed_at_end(joint: str, speed: float, unit: str, when: str) -> Standstill:
    """Of an arm that is seen to move."""
    text = f"{joint} STILL MOVES at {speed:.2g} {unit} {when}: {EMERGENCY}"
    return Standstill(True, text, joint, speed, unit)


def silent_at_end(joints: Sequence[str]) -> Standstill:
    """Of an arm of which some joints are not heard."""
    return unknown_at_end(f"nothing is received from {', '.join(joints)}")


def unknown_at_end(why: str) -> Standstill:
    """Of an arm that cannot be seen."""
    return Standstill(None, f"WHETHER THE ARM STANDS IS NOT KNOWN ({why}): {EMERGENCY}")
