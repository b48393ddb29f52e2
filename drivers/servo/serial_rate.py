"""Whether a serial line can carry a cycle: bytes, answers and the adapter take their time."""

import math
from typing import NamedTuple

from ..errors import BadSettings

BITS_A_BYTE = 10
"""A start bit, eight bits, a stop bit."""

USABLE = 0.9
"""Share of the cycle that the line may take; the rest is the computer's."""


class Traffic(NamedTuple):
    """What goes over the line in a cycle.

    Attributes:
        sent: By the computer [bytes].
        received: From the servos [bytes].
        answers: Servos that wait their return delay before they send.
    """

    sent: int
    received: int
    answers: int

    def seconds(self, baudrate: int, return_delay: float = 0.0, latency: float = 0.0) -> float:
        """How long it takes [s].

        Args:
            baudrate: [bit/s].
            return_delay: Of each servo [s].
            latency: Of the adapter [s].
        """
        wire = BITS_A_BYTE * (self.sent + self.received) / baudrate
        return wire + self.answers * return_delay + latency


def shortest_cycle(traffic: Traffic, baudrate: int, return_delay: float = 0.0, latency: float = 0.0) -> float:
    """The shortest cycle that the line can carry, in tenths of a millisecond [s]."""
    needed = traffic.seconds(baudrate, return_delay, latency) / USABLE
    return math.ceil(round(needed * 1e4, 6)) * 1e-4


def require_rate(
    traffic: Traffic, cycle: float, baudrate: int, return_delay: float, latency: float, advice: str
) -> None:
    """Nothing, if the line can carry it.

    Args:
        traffic: Of a cycle.
        cycle: [s].
        baudrate: [bit/s].
        return_delay: Of each servo [s].
        latency: Of the adapter [s].
        advice: What else to try.

    Raises:
        BadSettings: It cannot.
    """
    shortest = shortest_cycle(traffic, baudrate, return_delay, latency)
    if shortest <= cycle * (1.0 + 1e-9):
        return
    total = traffic.seconds(baudrate, return_delay, latency)
    raise BadSettings(
        f"a cycle of {1e3 * cycle:g} ms is too short for this line: {traffic.sent} bytes out and "
        f"{traffic.received} back at {baudrate} bit/s, {traffic.answers} return delays of "
        f"{1e6 * return_delay:.0f} us and {1e3 * latency:g} ms of the adapter take {1e3 * total:.2f} ms, and "
        f"{USABLE:.0%} of the cycle can be used. Try a cycle of {shortest:.4g} s, {advice}"
    )
