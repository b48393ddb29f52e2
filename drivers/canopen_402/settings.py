"""What a user sets of CiA 402 drives, whether it fits together, and what their counts mean."""

import math
from dataclasses import dataclass

import numpy as np

from ..can.can_bus import CanSettings, bus_load
from ..driver import Arm
from ..errors import BadSettings
from ..settings import setting
from . import cia402 as c
from .drive import EffortSettings, read_object
from .frames import COMMANDED, measured_sizes

BEATS = 8
"""Heartbeats that the host sends within the time after which drives miss them."""
RANGE = 2**31
"""Counts that a position can have at most, either way."""


@dataclass(frozen=True)
class CanopenSettings(CanSettings):
    """How the drives are reached, and what their units mean."""

    nodes: tuple[int, ...] = setting(..., "node number", low=1, high=126)
    counts: tuple[float, ...] = setting(
        ..., "counts of 0x6064 per revolution of the motor", low=1, high=RANGE
    )
    gear: tuple[float, ...] = setting(
        1.0, "revolutions of the motor per revolution of the joint", low=1e-3, high=1e5
    )
    sign: tuple[int, ...] = setting(1, "-1 where the drive counts against the joint", choices=(1, -1))
    zero: tuple[float, ...] = setting(0.0, "position of the joint at count zero", unit="rad")
    effort: str = setting(
        "auto",
        "what is measured besides position; auto is current, or torque 0x6077 where a drive has no current",
        choices=("auto", "current", "torque"),
    )
    current_object: tuple[str, ...] = setting("0x6078:0 int16", "object of the current, as 'index:sub type'")
    current_scale: tuple[float, ...] = setting(
        0.0,
        "what a count of that object means; 0 for a thousandth of rated current",
        unit="A per count",
        low=0.0,
        high=1e3,
    )
    rated_current: tuple[float, ...] = setting(
        0.0, "rated current of the motor; 0 for what 0x6075 has", unit="A", low=0.0, high=1e4
    )
    rated_torque: tuple[float, ...] = setting(
        0.0, "rated torque of the motor; 0 for what 0x6076 has", unit="N m", low=0.0, high=1e5
    )
    ampere: str = setting("rms", "what the drive's maker means by amperes", choices=("rms", "peak", "dc"))
    host_node: int = setting(127, "node number of the host's heartbeat", low=1, high=127)
    dead_man: float = setting(
        0.2, "silence of the host after which drives stop by themselves", unit="s", low=0.01, high=2.0
    )
    require_dead_man: bool = setting(
        True, "refuse drives that would not stop by themselves when this computer dies"
    )
    heartbeat: float = setting(0.1, "time between the drives' heartbeats", unit="s", low=0.01, high=2.0)
    quick_stop: int = setting(
        6, "0x605A: 5 and 6 slow down and hold, 1 and 2 slow down and switch off", low=0, high=8
    )
    fault_reaction: int = setting(
        2, "0x605E: 2 quick stop ramp, 1 slow-down ramp, 0 switch off", low=0, high=4
    )
    abort_connection: int = setting(
        3, "0x6007, when the host is silent: 3 quick stop, 2 switch off, 1 fault", low=1, high=3
    )
    following_error: tuple[float, ...] = setting(
        0.0, "window 0x6065; 0 leaves the drive's", unit="rad", low=0.0, high=10.0
    )
    following_time: float = setting(0.02, "how long it may be exceeded", unit="s", low=0.0, high=10.0)
    write_limits: bool = setting(False, "write the arm's position limits to 0x607D")

    @property
    def per_radian(self) -> np.ndarray:
        """Counts per radian of the joint, with sign, shape (n,) [1/rad]."""
        return np.array(self.sign) * np.array(self.counts) * np.array(self.gear) / (2.0 * math.pi)

    def to_counts(self, position: np.ndarray) -> np.ndarray:
        """Counts of a joint position (..., n) [rad]."""
        return (position - np.array(self.zero)) * self.per_radian

    def from_counts(self, counts: np.ndarray) -> np.ndarray:
        """Joint position [rad] of counts (..., n)."""
        return counts / self.per_radian + np.array(self.zero)

    @property
    def frames(self) -> list[int]:
        """Targets, SYNC, measurements."""
        objects = [c.TORQUE if self.effort == "torque" else wanted.current for wanted in self.efforts]
        measured = [size for entry in objects for size in measured_sizes(entry)]
        return [COMMANDED.size] * len(self.nodes) + [0] + measured

    @property
    def efforts(self) -> list[EffortSettings]:
        """What is set of each drive's current and torque."""
        objects = [read_object(text, "current") for text in self.current_object]
        return list(map(EffortSettings, objects, self.current_scale, self.rated_current, self.rated_torque))

    @property
    def beats(self) -> float:
        """Heartbeats on the bus, the drives' and the host's [1/s]."""
        return len(self.nodes) / self.heartbeat + BEATS / self.dead_man

    @property
    def behind(self) -> float:
        """Time until a SYNC that is handed over behind the targets is through a wire, at most [s]."""
        return bus_load(self.frames[: len(self.nodes) + 1], 1.0, self.bitrate)


def require_sound(s: CanopenSettings, arm: Arm) -> None:
    """Raise BadSettings where the settings fit neither each other, nor the arm, nor the bus."""
    numbers = [*s.nodes, s.host_node]
    twice = {number for number in numbers if numbers.count(number) > 1}
    if twice:
        raise BadSettings(f"node number {min(twice)} is used twice, among nodes and host_node")
    for name, wanted in zip(arm.joints, s.efforts, strict=True):
        if wanted.scale and wanted.rated_current:
            raise BadSettings(
                f"{name}: current_scale and rated_current are both set; either of them gives what a count of "
                "current is. Leave one at 0"
            )
    if c.period_of(s.cycle) is None:
        raise BadSettings(
            f"cycle is {s.cycle:g} s; drives take 1 to 255 steps of 1 ms, 0.1 ms or 0.01 ms (0x60C2)"
        )
    for limit in (arm.position_lower, arm.position_upper):
        for name, counts in zip(arm.joints, s.to_counts(limit), strict=True):
            if math.isfinite(counts) and abs(counts) >= RANGE:
                raise BadSettings(
                    f"{name}: its position limit is {counts:.4g} counts, a drive has {RANGE} either way. "
                    "Check counts, gear and zero"
                )
    s.require_bus()
