"""Listener: reads a controller whose drives are not powered, in a thread of its own, and commands nothing."""

import time
from collections import deque
from dataclasses import dataclass
from threading import Event, Lock, Thread

import numpy as np

from exidyn.drivers import Driver, Sample
from exidyn.drivers.values import SIGNALS, checked

ASK_STATES = 1.0
"""Time between questions for the drives' states [s]: on a serial line one costs a few cycles."""
KEPT = 5000
"""Samples, and events, kept for the display: ten seconds at 500 Hz; a terminal may stop for longer."""


@dataclass(frozen=True)
class Reading:
    """What was received since the last look.

    Attributes:
        host_time: Host's clock at the last sample [ns since 1970].
        position: Last fresh one of each joint, shape (n,) [rad] or [m]; NaN where none came.
        velocity: Last fresh one, shape (n,) [rad/s] or [m/s].
        current: Mean of the fresh ones, shape (n,) [A].
        torque: Mean of the fresh ones, shape (n,) [N m].
        temperature: Last fresh one, shape (n,) [degC].
        states: What each drive reports about itself; empty where it does not.
        cycles: Exchanges since the last look.
        silent: In how many of them each joint was silent, shape (n,).
        events: Messages of the controller since the last look.
        fault: Why the arm could not be commanded; empty if it could.
        samples: All of them.
    """

    host_time: int
    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    torque: np.ndarray
    temperature: np.ndarray
    states: tuple[str, ...]
    cycles: int
    silent: np.ndarray
    events: tuple[str, ...]
    fault: str
    samples: tuple[Sample, ...] = ()


class Listener:
    """A context manager that exchanges nothing but samples, so that printing them may take its time.

    A controller that gives up when it is not answered is answered all the while.

    Args:
        driver: Open and in real time. Nothing else calls it until the end.
    """

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self._enough, self._lock = Event(), Lock()
        self._failure: Exception | None = None
        self._states, self._asked = ("",) * driver.arm.dof, -np.inf
        self._samples: deque[Sample] = deque(maxlen=KEPT)
        self._events: deque[str] = deque(maxlen=KEPT)
        self._thread = Thread(target=self._listen, name="listener", daemon=True)

    def look(self) -> Reading | None:
        """What was received since the last look; None if nothing was.

        Raises:
            DriverError: No answers any more; or whatever else went wrong while exchanging.
        """
        with self._lock:
            samples, events = list(self._samples), tuple(self._events)
            self._samples.clear()
            self._events.clear()
        if not samples and self._failure is not None:
            raise self._failure
        return _reading(samples, self._states, events) if samples else None

    def __enter__(self) -> "Listener":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._enough.set()
        self._thread.join()

    def _listen(self) -> None:
        try:
            while not self._enough.is_set():
                sample = checked(self._driver.exchange(None))
                if time.monotonic() - self._asked >= ASK_STATES:
                    self._asked, self._states = time.monotonic(), self._driver.states()
                with self._lock:
                    self._samples.append(sample)
                    self._events.extend(sample.events)
        except Exception as error:  # raised in `look`, in the thread that waits for readings
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
    """Last number of each column, shape (n,); NaN where there is none."""
    known = np.isfinite(rows)
    last = len(rows) - 1 - np.argmax(known[::-1], axis=0)
    return rows[last, np.arange(rows.shape[1])]


def _mean(rows: np.ndarray) -> np.ndarray:
    """Mean of the numbers of each column, shape (n,); NaN where there is none."""
    known = np.isfinite(rows)
    with np.errstate(invalid="ignore"):
        mean: np.ndarray = np.where(known, rows, 0.0).sum(axis=0) / known.sum(axis=0)
    return mean
