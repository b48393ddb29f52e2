"""Estimators: equations in, estimate out, all with one signature."""

from .bayesian import bayesian, posterior
from .compressed import Estimate, Estimator
from .consistent import consistent
from .drive_gains import literal, maximum_likelihood, mixed, total
from .least_squares import instrumental, ordinary, reweighted, weighted

ESTIMATORS: dict[str, Estimator] = {
    "ordinary": ordinary,
    "weighted": weighted,
    "reweighted": reweighted,
    "instrumental": instrumental,
    "bayesian": bayesian,
    "consistent": consistent,
    "posterior": posterior,
    "literal": literal,
    "total": total,
    "mixed": mixed,
    "ml": maximum_likelihood,
}

__all__ = ["ESTIMATORS", "Estimate", "Estimator", *sorted(f.__name__ for f in ESTIMATORS.values())]
