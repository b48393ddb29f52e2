"""Samples: a data package in the units of `Sample`, or that none came."""

import numpy as np

from ..driver import Sample
from ..host_clock import host_time
from .modes import STATE, state_of

DRIFT = 1e-4
"""By which two clocks may run apart at most [-]: ten times what quartz does."""


class Samples:
    """Makes the samples of one session; their times never go back.

    Args:
        joints: Number n.
        cycle: Time between packages [s].
    """

    def __init__(self, joints: int, cycle: float) -> None:
        self._cycle = cycle
        self._unknown, self._fresh = np.full(joints, np.nan), np.zeros(joints, bool)
        self._time = self._host_time = self._gone = 0
        self._ahead = np.inf
        self.restart()

    def restart(self) -> None:
        """No cycle is missed between the last package and the next: none was asked for."""
        self._continued = False

    def of(self, record: np.void, arrival: int, events: tuple[str, ...], fault: str, sent: bool) -> Sample:
        """Of a package that came at a time of the host [ns]."""
        time = round(1e9 * float(record["timestamp"]))
        cycles = round(1e-9 * (time - self._time) / self._cycle)
        skipped = max(cycles - 1 - self._gone, 0) if self._continued else 0
        lateness = self._lateness(1e-9 * arrival, 1e-9 * time, 1e-9 * (time - self._time))
        self._continued, self._gone, self._time = True, 0, time
        self._host_time = max(self._host_time + 1, arrival)
        return Sample(
            host_time=self._host_time,
            controller_time=time,
            position=record["actual_q"].astype(float),
            velocity=record["actual_qd"].astype(float),
            current=record["actual_current"].astype(float),
            torque=self._unknown,
            temperature=record["joint_temperatures"].astype(float),
            lateness=lateness,
            skipped=skipped,
            stale=self._fresh,
            events=events,
            fault=fault,
            sent=sent,
            state=state_of(record),
        )

    def _lateness(self, arrival: float, time: float, elapsed: float) -> float:
        """By how much a package came later after its time stamp than the quickest one [s]."""
        ahead = arrival - time
        self._ahead = min(self._ahead + DRIFT * max(elapsed, 0.0), ahead)
        return ahead - self._ahead

    def of_silence(self, quiet: float, events: tuple[str, ...], fault: str) -> Sample:
        """Of nothing, so long after the last package [s]."""
        gone = int(quiet / self._cycle)
        skipped = max(gone - 1 - self._gone, 0)
        self._gone += 1 + skipped
        self._host_time = max(self._host_time + 1, host_time())
        return Sample(
            self._host_time,
            self._time,
            *(self._unknown,) * 5,
            skipped=skipped,
            stale=~self._fresh,
            events=events,
            fault=fault,
            sent=False,
            state=np.full(len(STATE), np.nan),
        )
