"""Creates samples, timed by the host's or the controller's clock, and reports the controller's state."""

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .host_clock import HOST, Clock, Tick
from .values import SIGNALS, Sample

DRIFT = 1e-4
"""Largest relative drift between two clocks [-]: ten times that of quartz."""


def word(names: Mapping[int, str], code: int) -> str:
    """Name of a code, or the code itself if it has none."""
    return names.get(code, f"code {code}")


class HostSamples:
    """Creates the samples of n joints that answer in the cycles of the host's clock."""

    def __init__(self, joints: int) -> None:
        self.unknown, self._none_stale = np.full(joints, np.nan), np.zeros(joints, bool)
        for shared in (self.unknown, self._none_stale):  # samples share these arrays
            shared.setflags(write=False)

    def of(self, now: int, tick: Tick, answered: Sequence[bool], **fields: Any) -> Sample:
        """Sample of a cycle that began at `now` [ns]; NaN for joints without an answer.

        `fields` are further fields of `Sample`.
        """
        stale, known = self._none_stale, {name: fields.pop(name, self.unknown) for name in SIGNALS}
        if not all(answered):
            stale = ~np.array(answered)
            known = {name: np.where(stale, np.nan, value) for name, value in known.items()}
        fields |= known | {"lateness": tick.lateness, "skipped": tick.skipped}
        return Sample(now, now, stale=stale, **fields)


class ControllerSamples:
    """Creates samples of n joints and k parts of a state, with a cycle [s]; their times never go back."""

    def __init__(self, joints: int, state: int, cycle: float, clock: Clock = HOST) -> None:
        self.unknown, self.fresh = np.full(joints, np.nan), np.zeros(joints, bool)
        self._no_state, self._cycle, self._clock = np.full(state, np.nan), cycle, clock
        self._gone = 0  # cycles reported since the last measurement
        self._time = self._host_time = 0
        self._ahead = np.inf
        self._continued = False

    def restart(self) -> None:
        """Count no cycles as missed before the next measurement, because none was requested."""
        self._continued = False

    def cycles(self, time: int) -> int:
        """Number of cycles since the last measurement, at a controller time [ns]; 1 for the first."""
        return round(1e-9 * (time - self._time) / self._cycle) if self._continued else 1

    def lateness(self, arrival: int, time: int) -> float:
        """Delay of a measurement from its time stamp to its arrival, minus the shortest such delay [s].

        `arrival` is a time of the host and `time` one of the controller [ns]; pass the latter to `of` next.
        """
        ahead = 1e-9 * arrival - 1e-9 * time
        self._ahead = min(self._ahead + DRIFT * max(1e-9 * (time - self._time), 0.0), ahead)
        return ahead - self._ahead

    def of(self, time: int, arrival: int, cycles: int, lateness: float, **fields: Any) -> Sample:
        """Sample of a measurement that came `cycles` cycles after the last one; times in [ns].

        `fields` are further fields of `Sample`.
        """
        known = {name: fields.pop(name, self.unknown) for name in SIGNALS}
        skipped = max(cycles - 1 - self._gone, 0)
        self._gone, self._time, self._continued = 0, time, True
        self._host_time = max(self._host_time + 1, arrival)
        fields |= known | {"lateness": lateness, "skipped": skipped}
        return Sample(self._host_time, time, stale=self.fresh, **fields)

    def of_silence(self, gone: int, **fields: Any) -> Sample:
        """Sample without a measurement, `gone` cycles after the last measurement."""
        skipped = max(gone - 1 - self._gone, 0)
        self._gone += 1 + skipped
        self._host_time = max(self._host_time + 1, self._clock.host_time())
        nothing: dict[str, Any] = dict.fromkeys(SIGNALS, self.unknown)
        nothing |= {"skipped": skipped, "stale": ~self.fresh, "state": self._no_state}
        return Sample(self._host_time, self._time, **nothing, **fields)


class Remarks:
    """Reports changes of the controller's state, as in `Info`; parts not in `reported` change too often."""

    def __init__(self, state: Mapping[str, Mapping[int, str]], reported: Sequence[str]) -> None:
        self._rows = [(list(state).index(name), name, state[name]) for name in reported]
        self._before: dict[str, int] = {}

    def on(self, state: np.ndarray | None, texts: deque[str] | None = None) -> tuple[str, ...]:
        """Events: changes of the state (k,) since the last cycle, and `texts` of the controller, removed."""
        events = []
        while texts:
            events.append(f"the controller: {texts.popleft()}")
        if state is None:
            return tuple(events)
        for row, name, words in self._rows:
            code = int(state[row])
            if self._before.get(name, code) != code:
                events.append(f"{name.replace('_', ' ')} is {word(words, code)} ({code})")
            self._before[name] = code
        return tuple(events)
