"""What an RSI context does with answers: ETHERNET, AXISCORR, AXISCORRMON and STOP, as a KUKA controller has
them. No sockets and no clock, so that tests can go through it step by step."""

import xml.etree.ElementTree as ElementTree
from collections import Counter
from dataclasses import dataclass, field

import numpy as np


@dataclass
class Context:
    """Corrections of one session, in degrees.

    `limit` is AXISCORR's, which cuts off without a message; `overall` AXISCORRMON's, which stops; `timeout`
    ETHERNET's, in cycles without an answer; `speed` what the axes can do [deg/s]. `relative` is
    RSI_ON(#RELATIVE), which adds in every cycle what ETHERNET puts out; `outputs` are the places of the
    outputs of ETHERNET that AXISCORR's inputs are linked to, in order where it is empty; `linked` is 1 for an
    axis whose input of AXISCORR is linked, else 0.
    """

    sentype: str
    tags: tuple[str, ...]
    hold: bool
    stop_tag: str
    cycle: float
    limit: np.ndarray
    overall: np.ndarray
    timeout: int
    speed: np.ndarray
    only_send: bool = False
    relative: bool = False
    linked: np.ndarray | float = 1.0
    outputs: tuple[int, ...] = ()
    correction: np.ndarray = field(init=False)
    delay: int = 0
    worst: int = 0
    late: int = 0
    clamped: int = 0
    farthest: float = 0.0
    answered: int = 0
    stopped: str = ""
    rejected: Counter = field(default_factory=Counter)

    def __post_init__(self):
        self.correction = np.zeros(len(self.tags))
        self._output = np.zeros(len(self.tags))
        self._next = None
        self._stop = False

    def answer(self, data: bytes, expected: int) -> bool:
        """Take one answer in; whether it is the one that is waited for."""
        try:
            root = ElementTree.fromstring(data)
            stamp = int(root.findtext("IPOC", ""))
            values = [self._value(root, tag) for tag in self.tags]
            stop = bool(self.stop_tag) and bool(int(self._value(root, self.stop_tag)))
        except (ElementTree.ParseError, AttributeError, TypeError, ValueError):
            return self._reject("unreadable")
        if root.get("Type") != self.sentype:
            return self._reject("sentype")
        if stamp != expected:
            return self._reject("late" if stamp < expected else "ipoc")
        if self._next is not None:
            return self._reject("twice")
        self._next, self._stop = np.array(values), stop
        return True

    def _reject(self, why: str) -> bool:
        self.rejected[why] += 1
        return False

    def _value(self, root: ElementTree.Element, tag: str) -> float:
        element, _, attribute = tag.partition(".")
        found = root.find(element)
        return float(found.get(attribute) if attribute else found.text)

    def step(self) -> np.ndarray:
        """End a cycle: the correction that is in force in the next one."""
        if self.only_send:
            return self.correction
        if self._next is None:
            return self._apply(self._unanswered())
        self.answered += 1
        self.delay = 0
        raw, self._next = self._next, None
        if self._stop:
            self.stopped = "stopped by the Stop channel"
        return self._apply(raw)

    def _unanswered(self) -> np.ndarray:
        if self.answered:
            self.late += 1
            self.delay += 1
            self.worst = max(self.worst, self.delay)
            if self.delay > self.timeout:
                self.stopped = "KSS29002 ETHERNET1 RSITimeout"
        return self._output if self.hold else np.zeros(len(self.tags))

    def _apply(self, raw: np.ndarray) -> np.ndarray:
        self._output = raw
        raw = raw[list(self.outputs)] if self.outputs else raw
        raw = self.linked * raw + (self.correction if self.relative else 0.0)
        cut = np.clip(raw, -self.limit, self.limit)
        self.clamped += bool((cut != raw).any())
        if (np.abs(cut) > self.overall).any():
            self.stopped = "KSS29000 permissible overall correction exceeded"
        elif (np.abs(cut - self.correction) > self.speed * self.cycle).any():
            self.stopped = "KSS1102 command velocity"
        else:
            self.correction = cut
            self.farthest = max(self.farthest, float(np.abs(cut).max()))
        return self.correction
