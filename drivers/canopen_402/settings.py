"""Settings of CiA 402 drives: their consistency, and the conversion of counts."""

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
"""Number of heartbeats that the host sends within the dead-man time of the drives."""
RANGE = 2**31
"""Limit of the magnitude of a position [counts]."""


@dataclass(frozen=True)
class CanopenSettings(CanSettings):
    """Addresses, units and safety functions of the drives."""

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
        "signal measured besides position; auto is current, or torque 0x6077 if a drive has no current",
        choices=("auto", "current", "torque"),
    )
    current_object: tuple[str, ...] = setting("0x6078:0 int16", "object of the current, as 'index:sub type'")
    current_scale: tuple[float, ...] = setting(
        0.0,
        "current per count of that object; 0 for a thousandth of rated current",
        unit="A per count",
        low=0.0,
        high=1e3,
    )
    rated_current: tuple[float, ...] = setting(
        0.0, "rated current of the motor; 0 for the value in 0x6075", unit="A", low=0.0, high=1e4
    )
    rated_torque: tuple[float, ...] = setting(
        0.0, "rated torque of the motor; 0 for the value in 0x6076", unit="N m", low=0.0, high=1e5
    )
    ampere: str = setting("rms", "definition of amperes by the drive's maker", choices=("rms", "peak", "dc"))
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
        0.0, "following error window 0x6065; 0 keeps the drive's", unit="rad", low=0.0, high=10.0
    )
    following_time: float = setting(
        0.02, "time for which the following error may exceed it", unit="s", low=0.0, high=10.0
    )
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
        """Number of data bytes of each frame in a cycle: targets, SYNC, measurements."""
        objects = [c.TORQUE if self.effort == "torque" else wanted.current for wanted in self.efforts]
        measured = [size for entry in objects for size in measured_sizes(entry)]
        return [COMMANDED.size] * len(self.nodes) + [0] + measured

    @property
    def efforts(self) -> list[EffortSettings]:
        """Settings of each drive's current and torque."""
        objects = [read_object(text, "current") for text in self.current_object]
        return list(map(EffortSettings, objects, self.current_scale, self.rated_current, self.rated_torque))

    @property
    def beats(self) -> float:
        """Rate of heartbeats of drives and host on the bus [1/s]."""
        return len(self.nodes) / self.heartbeat + BEATS / self.dead_man

    @property
    def behind(self) -> float:
        """Maximum time until a SYNC that is sent after the targets has passed the wire [s]."""
        return bus_load(self.frames[: len(self.nodes) + 1], 1.0, self.bitrate)


def require_sound(s: CanopenSettings, arm: Arm) -> None:
    """Raise BadSettings if the settings do not fit each other, the arm or the bus."""
    numbers = [*s.nodes, s.host_node]
    twice = {number for number in numbers if numbers.count(number) > 1}
    if twice:
        raise BadSettings(f"node number {min(twice)} is used twice, among nodes and host_node")
    for name, wanted in zip(arm.joints, s.efforts, strict=True):
        if wanted.scale and wanted.rated_current:
            raise BadSettings(
                f"{name}: current_scale and rated_current are both set, but each of them defines a count of "
                "current. Leave one at 0"
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
