"""Live contact: external torque of an arm that is watched, from the samples of each reading."""

from collections.abc import Sequence

import numpy as np

from exidyn.drivers import Sample
from exidyn.identification.contact.alarms import Alarms
from exidyn.identification.contact.contact import free_threshold, wrenches
from exidyn.identification.contact.observer import Estimates, Observer
from exidyn.identification.fit.fit import Fit
from exidyn.identification.recordings.recording import Recording

from .watch_text import External


class LiveContact:
    """Estimates external torques from samples as they come.

    Args:
        fit: The fit.
        free: Runs without contact that the fit has not used; without them there is no threshold.
        payload: Name of the payload on the flange; empty for none.
        alarms_per_hour: Accepted false alarms [1/h].
        bandwidth: Bandwidth of the observer [Hz].

    Raises:
        RecordingError: The runs without contact are too short, or were used for the fit.
    """

    def __init__(
        self, fit: Fit, free: Sequence[Recording], payload: str, alarms_per_hour: float, bandwidth: float
    ) -> None:
        self.fit, self._observer = fit, Observer(fit, payload, bandwidth)
        threshold = free_threshold(fit, free, alarms_per_hour, bandwidth)
        self._alarms = None if threshold is None else Alarms(threshold)
        self._start: int | None = None

    def add(self, samples: Sequence[Sample]) -> External:
        """Take further samples, and return the external torques in them."""
        unknown = np.full(self.fit.model.robot.dof, np.nan)
        nothing = External(unknown, unknown, np.full(3, np.nan), (), self._count())
        estimates = self._estimates(samples)
        known = np.flatnonzero(np.isfinite(estimates.torque).all(axis=1))
        if self._alarms is None or not len(known):
            return nothing if not len(known) else self._at(estimates, int(known[-1]))
        self._alarms.add(estimates)
        score = self._alarms.threshold.score(estimates)
        return self._at(estimates, int(known[np.argmax(score[known])]))

    def _count(self) -> int:
        return 0 if self._alarms is None else len(self._alarms.all)

    def _estimates(self, samples: Sequence[Sample]) -> Estimates:
        if self._start is None and samples:
            self._start = samples[0].controller_time
        time = 1e-9 * np.array([sample.controller_time - (self._start or 0) for sample in samples], float)
        n = self.fit.model.robot.dof
        position, effort, temperature = (
            np.array([getattr(sample, name) for sample in samples], float).reshape(len(samples), n)
            for name in ("position", self.fit.measures, "temperature")
        )
        return self._observer.add(time, position, effort, temperature)

    def _at(self, estimates: Estimates, row: int) -> External:
        """External torques of one row."""
        sample = Estimates(*(part[row : row + 1] for part in vars(estimates).values()))
        threshold = None if self._alarms is None else self._alarms.threshold
        limit = np.full_like(sample.torque, np.nan) if threshold is None else threshold.torque(sample)
        over = tuple(int(joint) for joint in np.flatnonzero(np.abs(sample.torque[0]) > limit[0]))
        force = wrenches(self.fit, sample, threshold)[0, :3]
        return External(sample.torque[0], limit[0], force, over, self._count())
