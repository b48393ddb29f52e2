"""Kept: what is made of a run once, for as long as the run itself is there."""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

from .driven import Driven

Made = TypeVar("Made")
Key = Callable[[Driven], object]


def itself(run: Driven) -> object:
    """What is made of a run at its load is kept by the run."""
    return run


def at_any_load(run: Driven) -> object:
    """What does not depend on the load is kept by what the run has at any."""
    return run.unloaded


def kept(make: Callable[[Driven], Made], by: Key = itself) -> Callable[[Driven], Made]:
    """The same function, which makes it once a run; a run that nobody has any more leaves nothing behind."""
    found: WeakKeyDictionary[object, Made] = WeakKeyDictionary()

    @wraps(make)
    def once(run: Driven) -> Made:
        key = by(run)
        if key not in found:
            found[key] = make(run)
        return found[key]

    return once
