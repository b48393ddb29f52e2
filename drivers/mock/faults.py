"""Faults that the mock can inject, one function each, written as texts such as "drop at 2 for 0.1".

A text is the name of a fault followed, in any order, by a joint, an amount, "at" a time and "for" a duration.
Times are in seconds from the first command; "at start" means from the first exchange. Semicolons separate
faults.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..errors import BadSettings
from .drives import MockDrives

START = -1.0
"""Time that faults assign to every exchange before the first command [s]."""
ROUNDING = 1e-9
"""Tolerance for rounding of times [s]."""


@dataclass
class Reply:
    """Reply of one cycle, on which faults act in place; arrays and units are those of `Sample`."""

    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    temperature: np.ndarray
    stale: np.ndarray
    late: float = 0.0  # delay of the reply [s]
    lost: str = ""  # why there is no reply at all; empty if there is one
    events: list[str] = field(default_factory=list)

    def silence(self, joint: int | slice) -> None:
        """Remove the values of one or several joints, as if they had sent nothing."""
        self.stale[joint] = True
        for values in (self.position, self.velocity, self.current, self.temperature):
            values[joint] = np.nan


class Fault(NamedTuple):
    """One fault to inject."""

    kind: "Kind"  # what the fault does
    joint: int | None  # index of the joint; None for all joints, or for a fault of no particular joint
    amount: float  # size of the fault in its own unit
    begin: float  # time at which it begins [s]; `START` for the first exchange
    length: float  # duration [s]; zero for one cycle

    def acts(self, before: float, now: float) -> bool:
        """Whether the fault acts in the cycle at time `now`; the previous cycle was at time `before` [s]."""
        since, then = now - self.begin + ROUNDING, before - self.begin + ROUNDING
        return since >= 0.0 and (then < 0.0 or since < self.length)

    @property
    def where(self) -> int | slice:
        return slice(None) if self.joint is None else self.joint

    @property
    def first_joint(self) -> int:
        return self.joint or 0


class Kind(NamedTuple):
    """What a fault does, its default amount and duration [s], and what it does before the first exchange."""

    act: Callable[[Fault, Reply, MockDrives], None] = lambda fault, reply, drives: None
    usual: float = 0.0
    lasts: float = 0.0
    prepare: Callable[[Fault, MockDrives], None] = lambda fault, drives: None


UNITS = ("s", "A", "rad", "rad/s", "degC")
"""Units that may follow a number."""


def _drop(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """Replies get lost."""
    reply.silence(fault.where)


def _duplicate(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """The last reply comes once more instead of the next one, and is recognized by its counter."""
    reply.silence(fault.where)
    reply.events.append("a reply came twice; the second was discarded")


def _reorder(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """A reply arrives after the next one, and is discarded."""
    reply.silence(fault.where)
    reply.events.append("a reply came after a later one; it was discarded")


def _delay(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """Replies come late by an amount [s]."""
    reply.late = fault.amount


def _trip(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """A drive stops itself."""
    drives.trip(f"joint {fault.first_joint + 1}: the drive has stopped itself (overcurrent)")


def _stand_away(fault: Fault, drives: MockDrives) -> None:
    """The arm starts away from its expected position by an amount [rad]."""
    away = np.zeros(len(drives.blocked))
    away[fault.where] = fault.amount
    drives.go(away, 1.0)


def _spike(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """The measured current is the amount [A]."""
    reply.current[fault.first_joint] = fault.amount


def _no_number(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """Measurements are NaN, without a report."""
    reply.position[fault.where] = reply.current[fault.where] = np.nan


def _jump(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """An encoder slips by an amount [rad]."""
    reply.position[fault.first_joint] += fault.amount


def _scale(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """An encoder's scale is wrong by a factor, from the initial position; negative: it counts backwards."""
    stood = drives.stood[fault.where]
    reply.position[fault.where] = stood + fault.amount * (reply.position[fault.where] - stood)
    reply.velocity[fault.where] *= fault.amount


def _exchange(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """The measurements of a joint and of the next one are swapped; the initial positions are right."""
    here, other = fault.first_joint, (fault.first_joint + 1) % len(reply.stale)
    reply.position -= drives.stood
    for values in (reply.position, reply.velocity, reply.current, reply.temperature):
        values[[here, other]] = values[[other, here]]
    reply.position += drives.stood


def _block(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """A joint no longer follows its commands."""
    drives.blocked[fault.first_joint] = True


def _heat(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """The measured temperature of a joint is the amount [degC]."""
    reply.temperature[fault.where] = fault.amount


def _lose(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """The controller no longer answers."""
    reply.lost = "the simulated controller does not answer, as this fault demands"


def _run_away(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """A joint runs away at a speed [rad/s], whatever is commanded, until it is stopped."""
    drives.runaway[fault.first_joint] = fault.amount


def _add(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """The controller adds each command as a correction in every cycle, at most at a speed [rad/s]."""
    drives.add(fault.amount)


def _deafen(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """Drives ignore a quick stop."""
    drives.deaf = True


def _refuse(fault: Fault, reply: Reply, drives: MockDrives) -> None:
    """The driver fails to send stops up to a level: 2 is the quick stop, 3 is power off."""
    drives.refused = fault.amount


FOREVER = float("inf")
FAULTS = {
    "drop": Kind(_drop),
    "duplicate": Kind(_duplicate),
    "reorder": Kind(_reorder),
    "delay": Kind(_delay, 0.001, FOREVER),
    "stall": Kind(_delay, 0.1),
    "stale": Kind(_drop, lasts=FOREVER),
    "fault": Kind(_trip),
    "far start": Kind(usual=0.1, prepare=_stand_away),
    "current spike": Kind(_spike, 1000.0),
    "nan": Kind(_no_number),
    "jump": Kind(_jump, 0.1, FOREVER),
    "scale": Kind(_scale, 2.0, FOREVER),
    "exchange": Kind(_exchange, lasts=FOREVER),
    "stuck": Kind(_block, lasts=FOREVER),
    "hot": Kind(_heat, 120.0, FOREVER),
    "silent": Kind(_lose, lasts=FOREVER),
    "runaway": Kind(_run_away, 2.0, FOREVER),
    "additive": Kind(_add, 3.0, FOREVER),
    "deaf": Kind(_deafen, lasts=FOREVER),
    "stop fails": Kind(_refuse, 2.0, FOREVER),
}
"""Name -> what the fault does, its default amount, and its default duration [s]."""


def read_faults(texts: str, joints: Sequence[str]) -> tuple[Fault, ...]:
    """Read the faults that a setting lists. Raises BadSettings for a text that is not a fault."""
    return tuple(_read(text.strip(), joints) for text in texts.split(";") if text.strip())


def _read(text: str, joints: Sequence[str]) -> Fault:
    name = next((name for name in FAULTS if re.match(rf"{name}(\s|$)", text)), None)
    if name is None:
        raise BadSettings(f"driver mock: no fault is called '{text}'. Valid: {', '.join(FAULTS)}")
    kind, words = FAULTS[name], text[len(name) :].split()
    numbers = {"begin": 1.0, "length": kind.lasts, "amount": kind.usual}
    joint, expected = None, "amount"
    for word in words:
        if word in ("at", "for"):
            expected = "begin" if word == "at" else "length"
        elif word in joints:
            joint = joints.index(word)
        elif word == "start" and expected == "begin":
            numbers["begin"] = START
        elif word not in UNITS:
            numbers[expected] = _number(word, text, joints)
            expected = "amount"
    return Fault(kind, joint, **numbers)


def _number(word: str, text: str, joints: Sequence[str]) -> float:
    number = re.fullmatch(rf"([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)({'|'.join(UNITS)})?", word)
    try:
        return float(number[1] if number else "")
    except ValueError:
        raise BadSettings(
            f"driver mock: '{word}' in fault '{text}' is neither a number nor a joint ({', '.join(joints)}). "
            "Write it as in 'stale joint3 at 2 for 0.1'"
        ) from None
