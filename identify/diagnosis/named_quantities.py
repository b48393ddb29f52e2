"""Named quantities: coefficients and shape of a finding, by name, with deviations and units."""

from collections.abc import Mapping

import numpy as np

from .candidate import UNNAMED, Candidate
from .finding import Quantity


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
    numbers = {
        name: Quantity(float(value), float(deviation), unit)
        for name, value, deviation, unit in zip(
            candidate.names, *candidate.told_as(values, std), candidate.units, strict=True
        )
        if not name.startswith(UNNAMED)
    }
    shape = {**candidate.known, **shape}
    units = {name: bounds.unit for name, bounds in candidate.bounds.items()}
    return (
        numbers
        | {
            name: Quantity(value, shape.get(name, float("nan")), units.get(name, "1"))
            for name, value in candidate.shape.items()
            if name != "reversal"
        }
        | {
            name: Quantity(value, shape.get(name, float("nan")), unit)
            for name, (value, unit) in candidate.told.items()
        }
    )
