"""Simulators that wait for an answer to each telegram, and stamp telegrams with how many they were given.

ROS-Industrial's kuka_rsi_simulator and kroshu's rsi_simulator do so. A controller neither waits nor repeats
itself: it sends every 4 or 12 ms, stamped in milliseconds. A simulator's time is that of this computer, and
its cycle the time until it sends again.
"""

from collections.abc import Sequence

import numpy as np

from ...errors import NotReady
from ..telegrams.session import Fresh

COUNT = 50
"""Telegrams that the cycle is the median of."""
SHORTEST, LONGEST = 0.0005, 0.1
"""Cycles that are taken for a simulator's [s]: faster ones cannot be answered in time, slower ones are no
motion."""


def cycle_of(telegrams: Sequence[Fresh]) -> float:
    """Time between telegrams, each of which was answered [s].

    Raises:
        NotReady: Nothing can be moved like that.
    """
    arrivals = np.array([fresh.datagram.arrival for fresh in telegrams])
    cycle = float(np.median(np.diff(arrivals))) * 1e-9
    if not SHORTEST <= cycle <= LONGEST:
        raise NotReady(
            f"a simulator that waits for answers sends every {1e3 * cycle:.3g} ms; valid are "
            f"{1e3 * SHORTEST:g} to {1e3 * LONGEST:g} ms"
        )
    return round(cycle, 4)


def warning(cycle: float) -> str:
    """What a person should know of a run against one."""
    return (
        "this is a simulator that waits for each answer and counts answers instead of milliseconds, not a "
        f"controller: times are this computer's, the cycle of {1e3 * cycle:g} ms is measured, and there are "
        "no dynamics to identify"
    )
