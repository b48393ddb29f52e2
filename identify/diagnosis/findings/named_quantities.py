"""Named quantities: coefficients and shape of a finding, by name, with deviations and units."""

from collections.abc import Mapping

import numpy as np

from ..questions.candidate import UNNAMED, Candidate
from .finding import Quantity

ROUNDING = 1e-6
"""Of a solution, over its standard deviation [-]."""


def quantities(
    candidate: Candidate, values: np.ndarray, std: np.ndarray, shape: Mapping[str, float]
) -> dict[str, Quantity]:
    """What people are given of a finding.

    Args:
        candidate: In the shape that was found.
        values: Its coefficients, shape (p,).
        std: Their standard deviations, shape (p,).
        shape: Those of the numbers of its shape, and of what follows from it, by name.
    """
    # What is held at a limit is there to the rounding of the solution.
    within = np.where(
        np.abs(values - candidate.lower) < ROUNDING * std.max(initial=0.0), candidate.lower, values
    )
    numbers = {
        name: Quantity(float(value), float(deviation), unit)
        for name, value, deviation, unit in zip(
            candidate.names, *candidate.reported_as(within, std), candidate.units, strict=True
        )
        if not name.startswith(UNNAMED)
    }
    shape = {**shape, **candidate.known}
    units = {name: bounds.unit for name, bounds in candidate.bounds.items()}
    return (
        numbers
        | {
            name: Quantity(value, shape.get(name, float("nan")), units.get(name, "1"))
            for name, value in candidate.shape.items()
        }
        | {
            name: Quantity(value, shape.get(name, float("nan")), unit)
            for name, (value, unit) in candidate.reported.items()
        }
    )
