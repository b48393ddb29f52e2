"""Estimators: equations in, estimate out, all with one signature."""

from .compressed import Estimate, Estimator
from .consistent import consistent
from .drive_gains import literal, maximum_likelihood
from .least_squares import weighted

ESTIMATORS: dict[str, Estimator] = {
    "weighted": weighted,
    "ml": maximum_likelihood,
    "consistent": consistent,
    "literal": literal,
}

__all__ = ["ESTIMATORS", "Estimate", "Estimator", *sorted(f.__name__ for f in ESTIMATORS.values())]
