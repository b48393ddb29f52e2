"""What drivers share whose controller has the only clock: times of samples, and reports of its state."""

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np

from .host_clock import host_time
from .values import Sample

DRIFT = 1e-4
"""By which two clocks may run apart at most [-]: ten times what quartz does."""


class ControllerSamples:
    """Base of what makes the samples of n joints and k parts of a state; their times never go back."""

    def __init__(self, joints: int, state: int = 0) -> None:
        self.unknown, self.fresh = np.full(joints, np.nan), np.zeros(joints, bool)
        self._no_state = np.full(state, np.nan)
        self._gone = 0  # cycles reported since the last measurement
        self._time = self._host_time = 0
        self._ahead = np.inf

    def _skipped(self, time: int, arrival: int, cycles: int) -> int:
        """Cycles not reported yet, when a measurement comes so many after the last one; times in [ns]."""
        skipped = max(cycles - 1 - self._gone, 0)
        self._gone, self._time = 0, time
        self._host_time = max(self._host_time + 1, arrival)
        return skipped

    def _lateness(self, arrival: int, time: int) -> float:
        """By how much a measurement came later after its time stamp than the quickest one [s].

        Times of host and controller are in [ns]; `_skipped` is told of the latter afterwards.
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


class Remarks:
    """Reports changes of parts of a controller's state, as in `Info`; all but `reported` change too often."""

    def __init__(self, state: Mapping[str, Mapping[int, str]], reported: Sequence[str]) -> None:
        self._rows = [(list(state).index(name), name, state[name]) for name in reported]
        self._before: dict[str, int] = {}

    def on(self, state: np.ndarray | None, texts: deque[str] | None = None) -> tuple[str, ...]:
        """What has changed since the last cycle (k,), and messages of the controller, which are taken."""
        found = []
        while texts:
            found.append(f"the controller: {texts.popleft()}")
        if state is None:
            return tuple(found)
        for row, name, words in self._rows:
            code = int(state[row])
            if self._before.get(name, code) != code:
                found.append(f"{name.replace('_', ' ')} is {words.get(code, f'code {code}')} ({code})")
            self._before[name] = code
        return tuple(found)
