"""Estimators: equations in, estimate out, all with one signature."""

from .bayesian import bayesian, posterior
from .compressed import Estimate, Estimator
from .consistent import consistent
from .least_squares import instrumental, ordinary, reweighted, weighted
from .maximum_likelihood import maximum_likelihood
from .total_least_squares import literal, mixed, total

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
