"""Standstill: whether the arm stands at the end of a run."""

from dataclasses import dataclass

RESTING = 0.01
"""Speed below which a joint is at rest [rad/s]: half a degree per second, or seven standard deviations of the
speed that a coarse encoder (1.5 mrad) at 125 Hz shows over half a second at rest."""
EMERGENCY = "PRESS THE EMERGENCY STOP"


@dataclass(frozen=True)
class Standstill:
    """Whether the arm stands."""

    moving: bool | None  # whether the arm still moves; None if unknown
    text: str  # sentence with joint, speed and what to do
    # Name of the fastest joint, or of the joint furthest from its last command; empty for none.
    joint: str = ""
    speed: float = float("nan")  # speed of the fastest joint, in `unit`; NaN where unknown
    unit: str = ""  # "rad/s" or "m/s"
    # Distance of that joint from its last command [rad] or [m], if it exceeds the limit; else NaN.
    away: float = float("nan")

    @property
    def stands(self) -> bool:
        """Whether the arm is known to stand."""
        return self.moving is False

    @property
    def expected(self) -> bool:
        """Whether the arm stands where it was commanded."""
        return self.stands and not self.away > 0.0

    def details(self) -> dict[str, object]:
        """Known fields for JSON and the recording, by name."""
        known = {"joint": self.joint, "speed": self.speed, "unit": self.unit, "away": self.away}
        known = {name: value for name, value in known.items() if value != "" and value == value}
        return {"moving": self.moving, "standstill": self.text, **known}


def unknown_at_end(reason: str) -> Standstill:
    """Standstill of an arm that cannot be observed for some reason."""
    return Standstill(None, f"WHETHER THE ARM STANDS IS NOT KNOWN ({reason}): {EMERGENCY}")
