"""Separations: how far the torque of one answer is from what another one can make of it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from exidyn.identify.diagnosis.blocks.prediction import factored
from exidyn.identify.diagnosis.questions.candidate_fit import FORMULA
from exidyn.identify.positive_definite import solve


class Stance(NamedTuple):
    """All columns' coefficients if one answer is true.

    Attributes:
        held: Columns that are there, (s,).
        precision: Of their priors, shape (s,).
        mean: Of the priors of its own, beside the other unknowns, of all columns (c,).
        ways: Its own coefficients, in the first column, and how they may differ from these by one standard
            deviation, in each of the others, of all columns, shape (c, w).
    """

    held: np.ndarray
    precision: np.ndarray
    mean: np.ndarray
    ways: np.ndarray


def separations(stances: Sequence[Stance], gram: np.ndarray) -> np.ndarray:
    """How far each answer (row) is from being explained by each other one (column), shape (m, m).

    The chi-squared of its torque that the other leaves over runs of these products of columns (c, c), and
    that of what its coefficients and the other unknowns have to be for that, by their priors. The formula of
    an effect is wrong by `FORMULA` of its torque: all of that may look like what the other leaves, however
    long the runs are.
    """
    found = np.zeros((len(stances), len(stances)))
    for rival, other in enumerate(stances):
        columns = gram[:, other.held]
        factor = factored(np.diag(other.precision) + columns[other.held])
        for true, one in enumerate(stances):
            if true == rival or not one.ways.size:
                continue
            ways = one.ways.copy()
            power = float(np.sum(ways * (gram @ ways)))
            ways[:, 0] -= other.mean
            whole = gram @ ways
            taken = solve(factor, whole[other.held])
            strained = float(np.sum(other.precision[:, None] * taken**2))
            left = float(np.sum(ways * whole) - np.sum(taken * whole[other.held])) - strained
            found[true, rival] = strained + max(left, 0.0) / (1.0 + FORMULA**2 * power)
    return found
