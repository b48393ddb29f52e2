"""Samples of a controller whose clock is the only one: their times, and those of nothing."""

import numpy as np

from .driver import Sample
from .host_clock import host_time

DRIFT = 1e-4
"""By which two clocks may run apart at most [-]: ten times what quartz does."""


class ControllerSamples:
    """Base of what makes the samples of one session; their times never go back.

    Args:
        joints: Number n.
        state: Number k of parts of the controller's state.
    """

    def __init__(self, joints: int, state: int = 0) -> None:
        self.unknown, self.fresh = np.full(joints, np.nan), np.zeros(joints, bool)
        self._no_state = np.full(state, np.nan)
        self._gone = 0  # cycles reported since the last measurement
        self._time = self._host_time = 0
        self._ahead = np.inf

    def _skipped(self, time: int, arrival: int, cycles: int) -> int:
        """Cycles that nobody has reported, when a measurement comes so many cycles after the last one.

        Args:
            time: Of the controller [ns].
            arrival: Time of the host [ns].
            cycles: Since the last measurement; 1 where none is missing.
        """
        skipped = max(cycles - 1 - self._gone, 0)
        self._gone, self._time = 0, time
        self._host_time = max(self._host_time + 1, arrival)
        return skipped

    def _lateness(self, arrival: int, time: int) -> float:
        """By how much a measurement came later after its time stamp than the quickest one [s].

        Args:
            arrival: Time of the host [ns].
            time: Of the controller, before `_skipped` is told of it [ns].
        """
        ahead = 1e-9 * arrival - 1e-9 * time
        self._ahead = min(self._ahead + DRIFT * max(1e-9 * (time - self._time), 0.0), ahead)
        return ahead - self._ahead

    def of_silence(self, gone: int, events: tuple[str, ...], fault: str, sent: bool = False) -> Sample:
        """Of nothing, so many cycles after the last measurement; whether a command went out nevertheless."""
        skipped = max(gone - 1 - self._gone, 0)
        self._gone += 1 + skipped
        self._host_time = max(self._host_time + 1, host_time())
        return Sample(
            self._host_time,
            self._time,
            *(self.unknown,) * 5,
            skipped=skipped,
            stale=~self.fresh,
            events=events,
            fault=fault,
            sent=sent,
            state=self._no_state,
        )
