"""Kept: what is made of a run once, for as long as the run itself is there."""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

from .driven import Driven

Made = TypeVar("Made")


def kept(make: Callable[[Driven], Made]) -> Callable[[Driven], Made]:
    """The same function, which makes it once a run; a run that nobody has any more leaves nothing behind."""
    found: WeakKeyDictionary[Driven, Made] = WeakKeyDictionary()

    @wraps(make)
    def once(run: Driven) -> Made:
        if run not in found:
            found[run] = make(run)
        return found[run]

    return once
