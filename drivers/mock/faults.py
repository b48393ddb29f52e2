"""Faults that the mock can inject, one object each, written as texts such as "drop at 2 for 0.1".

A text is a name, and in any order a joint, an amount, "at" when it begins and "for" how long. Time is in
seconds from the first command; "at start" is before, from the first exchange. Semicolons separate several.
"""

import re
from collections.abc import Sequence

import numpy as np

from ..errors import BadSettings
from .drives import MockDrives
from .fault import START, Fault, Reply

UNITS = ("s", "A", "rad", "rad/s", "degC")
"""What may be written behind a number."""


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


class Scale(Fault):
    """An encoder counts an amount of times what it should from where the arm stood; negative: backwards."""

    usual, lasts = 2.0, float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        stood = drives.stood[self.where]
        reply.position[self.where] = stood + self.amount * (reply.position[self.where] - stood)
        reply.velocity[self.where] *= self.amount


class Exchange(Fault):
    """What a joint does is measured of the next one, and the other way round; where both stood is right."""

    lasts = float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        here, other = self.one, (self.one + 1) % len(reply.stale)
        reply.position -= drives.stood
        for values in (reply.position, reply.velocity, reply.current, reply.temperature):
            values[[here, other]] = values[[other, here]]
        reply.position += drives.stood


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


class Runaway(Fault):
    """A joint runs away with a speed [rad/s], whatever is commanded, until it is stopped."""

    usual, lasts = 2.0, float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        drives.runaway[self.one] = self.amount


class Additive(Fault):
    """Every cycle the controller adds what is commanded, from where this began on, up to a speed [rad/s]."""

    usual, lasts = 3.0, float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        drives.add(self.amount)


class Deaf(Fault):
    """Drives ignore a quick stop."""

    lasts = float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        drives.deaf = True


class StopFails(Fault):
    """The driver fails to tell the drives a stop, up to a level: 2 is the quick stop, 3 is off."""

    usual, lasts = 2.0, float("inf")

    def act(self, reply: Reply, drives: MockDrives) -> None:
        drives.refused = self.amount


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
    "scale": Scale,
    "exchange": Exchange,
    "stuck": Stuck,
    "hot": Hot,
    "silent": Silent,
    "runaway": Runaway,
    "additive": Additive,
    "deaf": Deaf,
    "stop fails": StopFails,
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
