"""What runs are called: by names that differ, since a tab has nothing else to be known by, and by role."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

from exidyn.identify.diagnosis.findings.finding import Trace
from exidyn.identify.diagnosis.runs.usable import HELD_OUT
from exidyn.identify.recordings.recording import Recording

Named = TypeVar("Named", Recording, Trace)


def distinct_names(names: Sequence[str]) -> list[str]:
    """The names, with a number behind each that was there before: run, run #2."""
    found: list[str] = []
    for name in names:
        number, free = 1, name
        while free in found:
            number += 1
            free = f"{name} #{number}"
        found.append(free)
    return found


def renamed(named: Iterable[Named]) -> list[Named]:
    """The same by names that differ."""
    every = list(named)
    names = distinct_names([one.name for one in every])
    return [replace(one, name=name) for one, name in zip(every, names, strict=True)]


def role_words(role: str) -> str:
    """What a run is for, as a person reads it."""
    return "held out" if role == HELD_OUT else role
