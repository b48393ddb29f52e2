"""Residual of a live arm: a piece as long as its check runs, reduced as one of them and held against them."""

from collections.abc import Sequence
from concurrent.futures import Executor, Future

import numpy as np

from exidyn.drivers import Sample
from exidyn.identify.errors import ExidynError
from exidyn.identify.fleet.kind import measures_of
from exidyn.identify.fleet.runs import Run
from exidyn.identify.fleet.summary import Summary, summarised
from exidyn.identify.model import Model
from exidyn.identify.recordings.recording import Recording, Signal

from ..terminal.watch_text import Residual
from .analysis import expected_of
from .store import Store
from .work import known_kind

SIGNALS = ("position", "current", "torque", "temperature")
"""What of a sample a run is made of."""
DAY_NS = 86400e9


class ResidualAlarm:
    """Takes samples as they come.

    Args:
        store: Of the fleet.
        arm: Name in it.
        alarms_per_year: False alarms to accept, over all joints of an arm that always moves.
        executor: A process apart: a controller that must be answered is answered meanwhile.

    Raises:
        RecordingError: No such arm, or too few runs since its last change.
    """

    def __init__(self, store: Store, arm: str, alarms_per_year: float, executor: Executor) -> None:
        self.kind, self._expected = expected_of(store, arm)
        self._store, self._executor = store, executor
        self._limits = self._expected.limits(alarms_per_year)
        self._waiting: list[Sample] = []
        self._future: Future[Summary | str] | None = None
        self._day = 0.0
        nothing = np.full_like(self._limits.alarm, np.nan)
        self._latest = Residual(nothing, self._limits.alarm, self._expected.seconds, "not known yet")

    @property
    def model(self) -> Model:
        """The nominal arm."""
        return self._expected.runs.frame.kind.model

    def add(self, samples: Sequence[Sample]) -> Residual:
        """The residual of the last piece that is known by now."""
        self._waiting += samples
        if self._future is None and self._long_enough():
            self._day = self._waiting[-1].host_time / DAY_NS
            rows = {name: np.array([getattr(one, name) for one in self._waiting]) for name in SIGNALS}
            time = 1e-9 * np.array([one.controller_time for one in self._waiting], float)
            self._future = self._executor.submit(_reduced, self._store, self.kind, time - time[0], rows)
            self._waiting = []
        if self._future is not None and self._future.done():
            self._latest, self._future = self._judged(self._future.result()), None
        return self._latest

    def _long_enough(self) -> bool:
        first, last = (self._waiting[k].controller_time for k in (0, -1)) if self._waiting else (0, 0)
        return 1e-9 * (last - first) >= self._expected.seconds

    def _judged(self, found: Summary | str) -> Residual:
        if isinstance(found, str):
            return self._latest._replace(value=np.full_like(self._limits.alarm, np.nan), why=found)
        value = self._expected.residual(Run("live", self._day, found))
        why = "" if np.all(np.isfinite(value)) else "the arm's runs have temperatures, and this has none"
        return self._latest._replace(value=value, why=why)


def _reduced(store: Store, key: str, time: np.ndarray, rows: dict[str, np.ndarray]) -> Summary | str:
    """A piece as a run is, or why it cannot be one: an arm that stands, for instance."""
    kind = known_kind(store, key)
    signals = {name: Signal(time, values) for name, values in rows.items() if np.any(np.isfinite(values))}
    try:
        run = Recording("live", kind.model, signals, recorded=True)
        if measures_of(run) != kind.measures:
            return f"the arm's runs have a {kind.measures}, and the controller measures none"
        return summarised(run, kind)
    except ExidynError as error:
        return str(error)
