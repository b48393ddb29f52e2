"""Remarks: what is worth reporting of a controller's state, in sentences."""

from collections import deque
from collections.abc import Mapping, Sequence

import numpy as np


class Remarks:
    """Remembers what was reported already.

    Args:
        state: Parts of the controller's state and what their codes mean, as in `Info`.
        reported: Those whose changes are events; others change too often.
    """

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
