"""Faults that the mock can inject, one object each, written as texts such as "drop at 2 for 0.1".

A text is a name, and in any order a joint, an amount, "at" when it begins and "for" how long. Time is in
seconds from the first command; "at start" is before, from the first exchange. Semicolons separate several.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from .errors import BadSettings
from .mock_drives import MockDrives

START = -1.0
"""Time of every exchange before the first command, as faults count it [s]."""
ROUNDING = 1e-9
"""Of times [s]."""
UNITS = ("s", "A", "rad", "degC")
"""What may be written behind a number."""


@dataclass
class Reply:
    """What comes back in one cycle, before faults have acted on it and after.

    Attributes:
        position: Shape (n,) [rad].
        velocity: Shape (n,) [rad/s].
        current: Shape (n,) [A].
        temperature: Shape (n,) [degC].
        stale: Joints of which nothing fresh came, shape (n,).
        late: Time that it takes longer [s].
        lost: Why nothing comes back at all; empty where something does.
        events: Sentences.
    """

    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    temperature: np.ndarray
    stale: np.ndarray
    late: float = 0.0
    lost: str = ""
    events: list[str] = field(default_factory=list)

    def copy(self) -> "Reply":
        """The same, to be spoiled."""
        arrays = (self.position, self.velocity, self.current, self.temperature, self.stale)
        position, velocity, current, temperature, stale = (array.copy() for array in arrays)
        return Reply(position, velocity, current, temperature, stale)

    def silence(self, joint: int | slice) -> None:
        """Nothing came from a joint, or from several."""
        self.stale[joint] = True
        for values in (self.position, self.velocity, self.current, self.temperature):
            values[joint] = np.nan


@dataclass(frozen=True)
class Fault(ABC):
    """One fault.

    Attributes:
        joint: Index of the joint it befalls; None for all, or for none in particular.
        amount: How much of it, in the fault's own unit.
        begin: From when on [s]; `START` for the first exchange.
        length: For how long [s]; zero for one cycle.
        usual: Amount where none is said.
        lasts: Length where none is said [s].
    """

    joint: int | None
    amount: float
    begin: float
    length: float

    usual: ClassVar[float] = 0.0
    lasts: ClassVar[float] = 0.0

    def acts(self, before: float, now: float) -> bool:
        """Whether it acts in the cycle at a time [s], the one before having been at another."""
        since, then = now - self.begin + ROUNDING, before - self.begin + ROUNDING
        return since >= 0.0 and (then < 0.0 or since < self.length)

    def prepare(self, drives: MockDrives) -> None:  # noqa: B027 - most have nothing to prepare
        """What it does before the first exchange."""

    @abstractmethod
    def act(self, reply: Reply, drives: MockDrives) -> None:
        """Spoil a reply, or the drives."""

    @property
    def where(self) -> int | slice:
        """The joint, or all of them."""
        return slice(None) if self.joint is None else self.joint

    @property
    def one(self) -> int:
        """The joint, or the first."""
        return self.joint or 0


class Drop(Fault):
    """Replies get lost."""

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.silence(self.where)


class Duplicate(Fault):
    """The last reply comes once more instead of the next one, and is recognised by its counter."""

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.silence(self.where)
        reply.events.append("a reply came twice; the second was discarded")


class Reorder(Fault):
    """A reply is overtaken by the next one, and discarded when it comes."""

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.silence(self.where)
        reply.events.append("a reply came after a later one; it was discarded")


class Delay(Fault):
    """Replies come late by an amount [s]."""

    usual, lasts = 0.001, float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.late = self.amount


class Stall(Delay):
    """One reply comes late by an amount [s]."""

    usual, lasts = 0.1, 0.0


class Stale(Fault):
    """A joint says nothing."""

    lasts = float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.silence(self.where)


class Trip(Fault):
    """A drive stops itself."""

    def act(self, reply: Reply, drives: MockDrives) -> None:
        drives.trip(f"joint {self.one + 1}: the drive has stopped itself (overcurrent)")


class FarStart(Fault):
    """The arm stands away by an amount [rad] from where it is thought to be."""

    usual = 0.1

    def prepare(self, drives: MockDrives) -> None:
        away = np.zeros(len(drives.blocked))
        away[self.where] = self.amount
        drives.go(away, 1.0)

    def act(self, reply: Reply, drives: MockDrives) -> None:
        """Nothing: it has been there from the start."""


class CurrentSpike(Fault):
    """A current of some amount is measured [A]."""

    usual = 1000.0

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.current[self.one] = self.amount


class NotANumber(Fault):
    """What is measured cannot be, and nobody says so."""

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.position[self.where] = reply.current[self.where] = np.nan


class Jump(Fault):
    """An encoder slips by an amount [rad]."""

    usual, lasts = 0.1, float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.position[self.one] += self.amount


class Stuck(Fault):
    """A joint no longer follows its commands."""

    lasts = float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        drives.blocked[self.one] = True


class Hot(Fault):
    """A joint is as warm as the amount [degC]."""

    usual, lasts = 120.0, float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.temperature[self.where] = self.amount


class Silent(Fault):
    """Nobody answers any more."""

    lasts = float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        reply.lost = "the simulated controller does not answer, as it was told not to"


FAULTS: dict[str, type[Fault]] = {
    "drop": Drop,
    "duplicate": Duplicate,
    "reorder": Reorder,
    "delay": Delay,
    "stall": Stall,
    "stale": Stale,
    "fault": Trip,
    "far start": FarStart,
    "current spike": CurrentSpike,
    "nan": NotANumber,
    "jump": Jump,
    "stuck": Stuck,
    "hot": Hot,
    "silent": Silent,
}


def read_faults(texts: str, joints: Sequence[str]) -> tuple[Fault, ...]:
    """The faults that a setting asks for.

    Raises:
        BadSettings: A text that is none.
    """
    return tuple(_read(text.strip(), joints) for text in texts.split(";") if text.strip())


def _read(text: str, joints: Sequence[str]) -> Fault:
    name = next((name for name in FAULTS if re.match(rf"{name}(\s|$)", text)), None)
    if name is None:
        raise BadSettings(f"driver mock: no fault is called '{text}'. Valid: {', '.join(FAULTS)}")
    kind, rest = FAULTS[name], text[len(name) :].split()
    found = {"begin": 1.0, "length": kind.lasts, "amount": kind.usual}
    joint, expected = None, "amount"
    for word in rest:
        if word in ("at", "for"):
            expected = "begin" if word == "at" else "length"
        elif word in joints:
            joint = joints.index(word)
        elif word == "start" and expected == "begin":
            found["begin"] = START
        elif word not in UNITS:
            found[expected] = _number(word, text, joints)
            expected = "amount"
    return kind(joint, **found)


def _number(word: str, text: str, joints: Sequence[str]) -> float:
    number = re.fullmatch(rf"([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)({'|'.join(UNITS)})?", word)
    try:
        return float(number[1] if number else "")
    except ValueError:
        raise BadSettings(
            f"driver mock: '{word}' in fault '{text}' is neither a number nor a joint ({', '.join(joints)}). "
            "Write it as in 'stale joint3 at 2 for 0.1'"
        ) from None
