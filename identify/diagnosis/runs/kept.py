"""Cache of values computed from a run, which lives as long as the run itself."""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

from .driven import Driven

Made = TypeVar("Made")
Key = Callable[[Driven], object]


def at_its_load(run: Driven) -> object:
    """Cache key for a value that depends on the load: the run itself."""
    return run


def at_any_load(run: Driven) -> object:
    """Cache key for a value that does not depend on the load."""
    return run.unloaded


def cached(make: Callable[[Driven], Made], by: Key = at_its_load) -> Callable[[Driven], Made]:
    """The same function, computed once per run; a value is freed together with its run."""
    cache: WeakKeyDictionary[object, Made] = WeakKeyDictionary()

    @wraps(make)
    def compute_once(run: Driven) -> Made:
        key = by(run)
        if key not in cache:
            cache[key] = make(run)
        return cache[key]

    return compute_once
