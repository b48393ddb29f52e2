"""Live contact: external torque of an arm that is watched, from the samples of each reading."""

from collections.abc import Sequence

import numpy as np

from exidyn.drivers import Sample
from exidyn.identification.contact.contact import free_threshold, torque_unit, wrenches
from exidyn.identification.contact.observer import Estimates, Observer
from exidyn.identification.contact.threshold import Alarms
from exidyn.identification.fit.fit import Fit
from exidyn.identification.recordings.mcap.mcap_writer import ticks
from exidyn.identification.recordings.recording import Recording
from exidyn.identification.text_table import digits

from ..run.frames import ContactHead, ContactRows, Event, event_frame
from ..run.pipe import Sink
from .watch_text import External


class LiveContact:
    """Estimates external torques from samples as they come; there is no threshold without `free` runs.

    Raises:
        RecordingError: The runs without contact are too short, or were used for the fit.
    """

    def __init__(self, fit: Fit, free: Sequence[Recording], payload: str, alarms_per_hour: float) -> None:
        self.fit, self._observer = fit, Observer(fit, payload)
        threshold = free_threshold(fit, free, alarms_per_hour)
        self._alarms = None if threshold is None else Alarms(threshold)
        self._start: int | None = None
        self._views: Sequence[Sink] = ()
        self._tick = -np.inf
        self._begun = self._ended = 0

    def show(self, views: Sequence[Sink]) -> None:
        """Show further external torques in live views too."""
        self._views = views
        self._put(ContactHead(self.fit.model, torque_unit(self.fit), not self.fit.unscaled).frame())

    def add(self, samples: Sequence[Sample]) -> External:
        """Take further samples, and return the external torques in them."""
        unknown = np.full(self.fit.model.robot.dof, np.nan)
        estimates = self._estimates(samples)
        if self._alarms is not None:
            self._alarms.add(estimates)
        if self._views:
            self._draw(estimates)
        nothing = External(unknown, unknown, np.full(3, np.nan), (), self._count())
        known = np.flatnonzero(np.isfinite(estimates.torque).all(axis=1))
        if self._alarms is None or not len(known):
            return nothing if not len(known) else self._at(estimates, int(known[-1]))
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
        limit, force = self._limit_and_force(sample)
        over = tuple(int(joint) for joint in np.flatnonzero(np.abs(sample.torque[0]) > limit[0]))
        return External(sample.torque[0], limit[0], force[0], over, self._count())

    def _limit_and_force(self, estimates: Estimates) -> tuple[np.ndarray, np.ndarray]:
        """Torques from which joints make an alarm (t, n), NaN without a threshold, and forces (t, 3)."""
        threshold = None if self._alarms is None else self._alarms.threshold
        limit = np.full_like(estimates.torque, np.nan)
        if threshold is not None:
            limit = threshold.torque(estimates)
        return limit, wrenches(self.fit, estimates, threshold)[:, :3]

    def _draw(self, estimates: Estimates) -> None:
        """Hand over to the views what the eye can see, and contacts that began or ended."""
        tick = ticks(estimates.time)
        rows = np.flatnonzero(np.diff(tick, prepend=self._tick))
        self._tick = tick[-1] if len(tick) else self._tick
        drawn = Estimates(*(part[rows] for part in vars(estimates).values()))
        limit, force = self._limit_and_force(drawn)
        self._put(*ContactRows(drawn.time, drawn.torque, limit, drawn.position, force).frames())
        if self._alarms is not None:
            self._put_events(self._alarms)

    def _put_events(self, alarms: Alarms) -> None:
        joints, unit = self.fit.model.robot.joints, torque_unit(self.fit)
        for alarm in alarms.all[self._begun :]:
            self._put_event(alarm.start, "contact", joints[alarm.joint])
        for alarm in alarms.ended[self._ended :]:
            peak = f"{digits(alarm.torque[alarm.joint], 3)} {unit}, {digits(alarm.score, 2)} times threshold"
            self._put_event(alarm.end, "end of contact", f"{joints[alarm.joint]}, peak {peak}")
        self._begun, self._ended = len(alarms.all), len(alarms.ended)

    def _put_event(self, time: float, kind: str, text: str) -> None:
        self._put(event_frame(Event(0, round(1e9 * time), kind, text, {})))

    def _put(self, *frames: bytes) -> None:
        for view in self._views:
            for frame in frames:
                view.put(frame)
