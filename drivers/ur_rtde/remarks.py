"""Remarks: what is worth reporting of a cycle, in sentences."""

from collections import deque

import numpy as np

from .modes import FIELDS, STATE, word

REPORTED = ("robot_mode", "safety_mode", "program")
"""Parts of the state whose changes are events; the others change too often."""


class Remarks:
    """Remembers what was reported already."""

    def __init__(self) -> None:
        self._before: dict[str, int] = {}

    def on(self, record: np.void | None, texts: deque[str]) -> tuple[str, ...]:
        """What has changed since the last cycle, and messages of the controller, which are taken."""
        found = [f"the controller: {texts.popleft()}" for _ in range(len(texts))]
        if record is None:
            return tuple(found)
        for name in REPORTED:
            code = int(record[FIELDS[name]])
            if self._before.get(name, code) != code:
                found.append(f"{name.replace('_', ' ')} is {word(STATE[name], code)} ({code})")
            self._before[name] = code
        return tuple(found)
