"""Numbers in texts of controllers."""

from collections.abc import Iterable

DECIMALS = 6
"""Decimals of SI values: micrograms, micrometers and 1 g m^2 / 1000 are below what any run determines."""


def number(value: float, decimals: int = DECIMALS) -> str:
    """A number without exponent, which no controller's language misreads; zero has no sign."""
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def numbers(values: Iterable[float], decimals: int = DECIMALS) -> str:
    """Numbers separated by commas."""
    return ", ".join(number(value, decimals) for value in values)
