"""Samples: a state of the controller in the units of `Sample`."""

import numpy as np

from ..driver import Sample
from ..host_clock import WALL, host_time
from ..samples import ControllerSamples
from .fci_limits import CYCLE, JOINTS
from .modes import STATE


class Samples(ControllerSamples):
    """Makes the samples of one session."""

    def __init__(self) -> None:
        super().__init__(JOINTS, len(STATE))
        self._continued = False

    def holes(self, record: np.void) -> int:
        """States that were lost between the last one and this; none before the first."""
        return max(self._cycles(record) - 1, 0)

    def _cycles(self, record: np.void) -> int:
        return round((int(record["time"]) - self._time) * 1e-9 / CYCLE) if self._continued else 1

    def of(self, record: np.void, events: tuple[str, ...], fault: str, sent: bool) -> Sample:
        """Of a state; its lateness is until now."""
        time = int(record["time"])
        lateness = self._lateness(host_time(), time)
        skipped = self._skipped(time, int(record["arrival"]) + WALL, self._cycles(record))
        self._continued = True
        return Sample(
            host_time=self._host_time,
            controller_time=self._time,
            position=record["q"].copy(),
            velocity=record["dq"].copy(),
            current=self.unknown,
            torque=record["tau_J"].copy(),
            temperature=self.unknown,
            lateness=lateness,
            skipped=skipped,
            stale=self.fresh,
            events=events,
            fault=fault,
            sent=sent,
            state=record["state"].copy(),
        )
