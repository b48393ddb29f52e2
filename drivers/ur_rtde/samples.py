"""Samples: a data package in the units of `Sample`."""

import numpy as np

from ..driver import Sample
from ..samples import ControllerSamples
from ..values import nanoseconds
from .modes import STATE


class Samples(ControllerSamples):
    """Makes the samples of one session.

    Args:
        joints: Number n.
        cycle: Time between packages [s].
    """

    def __init__(self, joints: int, cycle: float) -> None:
        super().__init__(joints, len(STATE))
        self._cycle = cycle
        self.restart()

    def restart(self) -> None:
        """No cycle is missed between the last package and the next: none was asked for."""
        self._continued = False

    def of(
        self,
        record: np.void,
        state: np.ndarray,
        arrival: int,
        events: tuple[str, ...],
        fault: str,
        sent: bool,
    ) -> Sample:
        """Of a package with the controller's state (k,), which came at a time of the host [ns].

        Raises:
            Unreadable: Its time is none.
        """
        time = nanoseconds("timestamp", float(record["timestamp"]))
        lateness = self._lateness(arrival, time)
        cycles = round(1e-9 * (time - self._time) / self._cycle) if self._continued else 1
        skipped = self._skipped(time, arrival, cycles)
        self._continued = True
        return Sample(
            host_time=self._host_time,
            controller_time=time,
            position=record["actual_q"].astype(float),
            velocity=record["actual_qd"].astype(float),
            current=record["actual_current"].astype(float),
            torque=self.unknown,
            temperature=record["joint_temperatures"].astype(float),
            lateness=lateness,
            skipped=skipped,
            stale=self.fresh,
            events=events,
            fault=fault,
            sent=sent,
            state=state,
        )
