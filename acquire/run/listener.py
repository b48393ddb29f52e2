"""Listener: reads from a controller with unpowered drives, in its own thread, and commands nothing."""

from collections import deque
from dataclasses import dataclass
from threading import Event, Lock, Thread

import numpy as np

from exidyn.drivers import Driver, Sample
from exidyn.drivers.values import SIGNALS, checked

QUERY_PERIOD = 1.0
"""Time between queries of the drives' states [s]: on a serial line, a query costs a few cycles."""
BUFFERED = 5000
"""Maximum number of samples and events that wait for the display: ten seconds at 500 Hz. A stopped terminal
loses the oldest."""


@dataclass(frozen=True)
class Reading:
    """Data received since the last reading."""

    host_time: int  # host's clock at the last sample [ns since 1970]
    position: np.ndarray  # last fresh position of each joint, shape (n,) [rad] or [m]; NaN if there is none
    velocity: np.ndarray  # last fresh velocity, shape (n,) [rad/s] or [m/s]
    current: np.ndarray  # mean of the fresh currents, shape (n,) [A]
    torque: np.ndarray  # mean of the fresh torques, shape (n,) [N m]
    temperature: np.ndarray  # last fresh temperature, shape (n,) [degC]
    states: tuple[str, ...]  # state reported by each drive; empty if it reports none
    cycles: int  # number of exchanges
    silent: np.ndarray  # number of exchanges in which each joint was silent, shape (n,)
    events: tuple[str, ...]  # messages of the controller
    fault: str  # why the arm could not be commanded; empty if it could
    samples: tuple[Sample, ...] = ()  # all samples


class Listener:
    """A context manager that receives samples in the background, so that printing them may take time.

    It keeps answering controllers that end the session without an answer. Nothing else may call the driver,
    which is open and in real time, until the listener exits.
    """

    def __init__(self, driver: Driver) -> None:
        self._driver, self.clock = driver, driver.clock
        self._stopped, self._lock = Event(), Lock()
        self._failure: Exception | None = None
        self._states, self._last_query = ("",) * driver.arm.dof, -np.inf
        self._samples: deque[Sample] = deque(maxlen=BUFFERED)
        self._events: deque[str] = deque(maxlen=BUFFERED)
        self._thread = Thread(target=self._listen, name="listener", daemon=True)

    def look(self) -> Reading | None:
        """Data received since the last call; None if there is none.

        Raises:
            DriverError: If the controller no longer answers; any other error of an exchange is raised too.
        """
        with self._lock:
            samples, events = list(self._samples), tuple(self._events)
            self._samples.clear()
            self._events.clear()
        if not samples and self._failure is not None:
            raise self._failure
        return _reading(samples, self._states, events) if samples else None

    def __enter__(self) -> "Listener":
        self.clock.start(self._thread)
        return self

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        self.clock.join(self._thread)

    def _listen(self) -> None:
        try:
            while not self._stopped.is_set():
                sample = checked(self._driver.exchange(None))
                if self.clock.monotonic() - self._last_query >= QUERY_PERIOD:
                    self._last_query, self._states = self.clock.monotonic(), self._driver.states()
                with self._lock:
                    self._samples.append(sample)
                    self._events.extend(sample.events)
        except Exception as error:  # raised by `look`, in the thread that waits for readings
            self._failure = error


def _reading(samples: list[Sample], states: tuple[str, ...], events: tuple[str, ...]) -> Reading:
    rows = {name: np.array([getattr(sample, name) for sample in samples]) for name in SIGNALS}
    stale = np.array([sample.stale for sample in samples])
    return Reading(
        host_time=samples[-1].host_time,
        position=_last(rows["position"]),
        velocity=_last(rows["velocity"]),
        current=_mean(rows["current"]),
        torque=_mean(rows["torque"]),
        temperature=_last(rows["temperature"]),
        states=states,
        cycles=len(samples),
        silent=stale.sum(axis=0) if stale.size else np.zeros(rows["position"].shape[1], int),
        events=events,
        fault=samples[-1].fault,
        samples=tuple(samples),
    )


def _last(rows: np.ndarray) -> np.ndarray:
    """Last number of each column, shape (n,); NaN if there is none."""
    known = np.isfinite(rows)
    last = len(rows) - 1 - np.argmax(known[::-1], axis=0)
    return rows[last, np.arange(rows.shape[1])]


def _mean(rows: np.ndarray) -> np.ndarray:
    """Mean of the numbers of each column, shape (n,); NaN if there is none."""
    known = np.isfinite(rows)
    with np.errstate(invalid="ignore"):
        mean: np.ndarray = np.where(known, rows, 0.0).sum(axis=0) / known.sum(axis=0)
    return mean
