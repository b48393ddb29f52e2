"""Numbers in files: what JSON has no number for, not a number and infinity, is null."""

from collections.abc import Iterable, Sequence

import numpy as np


def number(value: float) -> float | None:
    """A number that JSON has; NaN and infinity are none."""
    return float(value) if np.isfinite(value) else None


def numbers(values: Iterable[float]) -> list[float | None]:
    """Each of them."""
    return [number(value) for value in values]


def value_of(number: float | None) -> float:
    """A number out of a file; null is NaN."""
    return float("nan") if number is None else float(number)


def array_of(numbers: Sequence[float | None]) -> np.ndarray:
    """Each of them."""
    return np.array([value_of(one) for one in numbers], float)
