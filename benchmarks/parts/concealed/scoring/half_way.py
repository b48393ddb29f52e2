"""The strength that is found half of the time, out of cases that were found and cases that were missed."""

from collections.abc import Sequence

import numpy as np

WIDTH = 0.35
"""Over how many natural logarithms of strength the chance to be found rises from a half to three quarters."""
BOUNDS = (0.05, 20.0)
"""Strengths that are thought possible, effect over noise."""


def half_way(tried: Sequence[tuple[float, bool]]) -> tuple[float, float, float]:
    """Strength found half of the time and its 90 % interval, by the likelihood of every strength."""
    middle = np.log(np.geomspace(*BOUNDS, 400))
    chance = np.zeros(len(middle))
    for value, found in tried:
        away = (np.log(max(value, 1e-3)) - middle) / WIDTH * np.log(3.0)
        chance -= np.logaddexp(0.0, -away if found else away)
    likely = np.exp(chance - np.max(chance))
    below = np.cumsum(likely) / np.sum(likely)
    half, low, high = (float(np.exp(middle[np.searchsorted(below, level)])) for level in (0.5, 0.05, 0.95))
    return half, low, high
