"""Samples: of drivers by a host's clock or by a controller's, and reports of a controller's state."""

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .host_clock import Tick, host_time
from .values import SIGNALS, Sample

DRIFT = 1e-4
"""By which two clocks may run apart at most [-]: ten times what quartz does."""


def word(names: Mapping[int, str], code: int) -> str:
    """Of a code, or the code."""
    return names.get(code, f"code {code}")


class HostSamples:
    """Makes the samples of n joints that answer in the cycles of a host's clock."""

    def __init__(self, joints: int) -> None:
        self.unknown, self._none_stale = np.full(joints, np.nan), np.zeros(joints, bool)
        for shared in (self.unknown, self._none_stale):  # by samples
            shared.setflags(write=False)

    def of(self, now: int, tick: Tick, answered: Sequence[bool], **fields: Any) -> Sample:
        """Of a cycle at a time [ns], with further fields of `Sample`; NaN for joints without an answer."""
        stale, known = self._none_stale, {name: fields.pop(name, self.unknown) for name in SIGNALS}
        if not all(answered):
            stale = ~np.array(answered)
            known = {name: np.where(stale, np.nan, value) for name, value in known.items()}
        fields |= known | {"lateness": tick.lateness, "skipped": tick.skipped}
        return Sample(now, now, stale=stale, **fields)


class ControllerSamples:
    """Makes the samples of n joints and k parts of a state, of a cycle [s]; their times never go back."""

    def __init__(self, joints: int, state: int, cycle: float) -> None:
        self.unknown, self.fresh = np.full(joints, np.nan), np.zeros(joints, bool)
        self._no_state, self._cycle = np.full(state, np.nan), cycle
        self._gone = 0  # cycles reported since the last measurement
        self._time = self._host_time = 0
        self._ahead = np.inf
        self._continued = False

    def restart(self) -> None:
        """No cycle is missed before the next measurement: none was asked for."""
        self._continued = False

    def cycles(self, time: int) -> int:
        """Cycles from the last measurement to one at a time of the controller [ns]; 1 for the first."""
        return round(1e-9 * (time - self._time) / self._cycle) if self._continued else 1

    def lateness(self, arrival: int, time: int) -> float:
        """By how much a measurement came later after its time stamp than the quickest one [s].

        Times of host and controller are in [ns]; `of` is told of the latter afterwards.
        """
        ahead = 1e-9 * arrival - 1e-9 * time
        self._ahead = min(self._ahead + DRIFT * max(1e-9 * (time - self._time), 0.0), ahead)
        return ahead - self._ahead

    def of(self, time: int, arrival: int, cycles: int, lateness: float, **fields: Any) -> Sample:
        """Of a measurement so many cycles after the last one, with fields of `Sample`; times in [ns]."""
        known = {name: fields.pop(name, self.unknown) for name in SIGNALS}
        skipped = max(cycles - 1 - self._gone, 0)
        self._gone, self._time, self._continued = 0, time, True
        self._host_time = max(self._host_time + 1, arrival)
        fields |= known | {"lateness": lateness, "skipped": skipped}
        return Sample(self._host_time, time, stale=self.fresh, **fields)

    def of_silence(self, gone: int, **fields: Any) -> Sample:
        """Of nothing, so many cycles after the last measurement."""
        skipped = max(gone - 1 - self._gone, 0)
        self._gone += 1 + skipped
        self._host_time = max(self._host_time + 1, host_time())
        nothing: dict[str, Any] = dict.fromkeys(SIGNALS, self.unknown)
        nothing |= {"skipped": skipped, "stale": ~self.fresh, "state": self._no_state}
        return Sample(self._host_time, self._time, **nothing, **fields)


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
                found.append(f"{name.replace('_', ' ')} is {word(words, code)} ({code})")
            self._before[name] = code
        return tuple(found)
