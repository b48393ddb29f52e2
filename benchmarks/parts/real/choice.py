"""Choice of friction law, standstill and prior by predicting each training run from the others."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from common import show

from exidyn.identification.effects import EFFECTS
from exidyn.identification.fit.equations import Equations, assemble
from exidyn.identification.fit.estimators import Estimate, Estimator, weighted
from exidyn.identification.fit.estimators.least_squares import given_nominal, prior
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.positive_definite import factored, solve
from exidyn.identification.preparation.filters import low_pass
from exidyn.identification.preparation.prepare import filtered, prepare
from exidyn.identification.recordings.recording import Recording

from .data import DataSet, thirds

LAWS = ("coulomb_friction", "hysteresis")
"""Dry friction that reverses over a velocity, or over a displacement: one size and one shape a joint each."""


class Recipe(NamedTuple):
    """What is chosen by cross-validation."""

    laws: tuple[str, ...]  # Key of `EFFECTS` of each joint's dry friction
    standstill: float | None  # Speed from which on a joint slides [rad/s]; None for `prepare`'s
    tolerance: float | None  # Relative standard deviation of the inertias before the data; None for no prior

    @property
    def words(self) -> list[str]:
        """The three choices for a table."""
        speed = "from data" if self.standstill is None else f"{self.standstill:g} rad/s"
        return [in_words(self.laws), speed, "none" if self.tolerance is None else f"{self.tolerance:g}"]


def in_words(laws: Sequence[str]) -> str:
    """Name of the one law, or the first letter of each joint's."""
    return laws[0] if len(set(laws)) == 1 else " ".join(law[0] for law in laws)


def with_laws(model: Model, laws: Sequence[str]) -> Model:
    """The model with a law of dry friction a joint in the place of Coulomb's."""
    joints = {
        law: tuple(j for j, own in zip(model.robot.joints, laws, strict=True) if own == law) for law in laws
    }
    rest = tuple(e for e in model.effects if not isinstance(e, EFFECTS["coulomb_friction"]))
    return replace(model, effects=(*rest, *(EFFECTS[law](joints=joints[law]) for law in joints)))


def shaped(data: DataSet, model: Model, runs: Sequence[Recording], recipe: Recipe) -> Fit:
    """Weighted least squares with the shapes of dry friction fitted too."""
    return identify(
        runs,
        model=with_laws(model, recipe.laws),
        filtering=replace(data.filtering, standstill=recipe.standstill),
        fitted_shapes=sorted(set(recipe.laws)),
        drop=False,
    )


def refined(fit: Fit, runs: Sequence[Recording], recipe: Recipe) -> Fit:
    """The fit again with the recipe's prior."""
    model = with_tolerance(fit.model, recipe.tolerance)
    return identify(runs, model=model, filtering=fit.filtering, estimator=estimator_of(recipe), drop=False)


def with_tolerance(model: Model, tolerance: float | None) -> Model:
    """The model with its inertias known to another tolerance."""
    if tolerance is None:
        return model
    return replace(model, robot=replace(model.robot, inertial_tolerance=tolerance))


def estimator_of(recipe: Recipe) -> Estimator:
    """Least squares weighted by each joint's residual, with the prior if there is one."""
    return weighted if recipe.tolerance is None else with_prior


def with_prior(equations: Equations) -> Estimate:
    """Weighted least squares at the most probable values given the prior; the covariance is without it."""
    data, (mean, spread) = weighted(equations), prior(equations)
    covariance = given_nominal(data)
    share = solve(factored(covariance + spread), covariance).T  # Kalman's gain
    return replace(data, values=data.values + share @ (mean - data.values))


class Compared(NamedTuple):
    """One run in the README's manner; what any estimate leaves of it is then one product."""

    columns: np.ndarray  # Base regressor behind the low-pass, thinned out, shape (r, n, b) [N m / unit]
    known: np.ndarray  # Known torque, alike, shape (r, n) [N m]
    torque: np.ndarray  # Measured torque, alike, shape (r, n) [N m]
    counts: np.ndarray  # Whether the joint moves, shape (r, n)

    @classmethod
    def of(cls, fit: Fit, recording: Recording, data: DataSet) -> "Compared":
        """Prepare a run for the model of a fit."""
        motion, current = filtered(recording, fit.filtering)
        motion = fit.model.loaded(motion)
        thin = slice(None, None, max(1, int(data.rate / (3 * data.cutoff))))  # closer ones repeat the same

        def behind(values: np.ndarray) -> np.ndarray:
            return low_pass(values, data.rate, data.cutoff)[thin]

        gain = fit.estimate.gain if "current" in recording.signals else 1.0
        return cls(
            behind(fit.model.regressor(motion)[:, :, fit.base.kept]),
            behind(fit.model.known_torque(motion)),
            behind(gain * current),
            np.abs(behind(motion.velocity)) > data.moving,
        )

    def relative(self, values: np.ndarray) -> np.ndarray:
        """Norm of the residual over norm of the torque where a joint moves, shape (n,) [-]."""
        residual = self.torque - self.known - self.columns @ values
        norms = [np.linalg.norm(torque * self.counts, axis=0) for torque in (residual, self.torque)]
        return np.asarray(norms[0] / norms[1])


class Candidates:
    """Fits to the training runs, and how well each recipe predicts one run from the others."""

    def __init__(self, data: DataSet, model: Model, runs: Sequence[Recording]) -> None:
        self.data, self.model, self.runs = data, model, runs
        self.parts = thirds(runs[0]) if len(runs) == 1 else runs
        self.fits: dict[tuple[tuple[str, ...], float | None], Fit] = {}
        self.scores: dict[Recipe, np.ndarray] = {}

    def try_out(self, laws: tuple[str, ...], standstill: float | None, tolerances: Sequence[Any]) -> None:
        """Score recipes that differ in the prior: mean logarithm of relative residuals, shape (n,).

        Shapes are fitted to all training runs: a number a joint, whichever the law.
        """
        data, parts = self.data, self.parts
        fit = shaped(data, self.model, parts, Recipe(laws, standstill, None))
        prepared = [prepare(replace(run, model=fit.model), fit.filtering) for run in parts]
        equations = assemble(fit.model, fit.base, prepared)
        compared = [Compared.of(fit, run, data) for run in parts]
        for tolerance in tolerances:
            recipe = Recipe(laws, standstill, tolerance)
            priors = with_tolerance(fit.model, tolerance).priors
            prior = replace(equations, tolerance=np.array([prior.std for prior in priors]))
            estimates = [estimator_of(recipe)(without_run(prior, k)) for k in range(len(parts))]
            left = [run.relative(e.values) for run, e in zip(compared, estimates, strict=True)]
            self.scores[recipe] = np.mean(np.log(left), axis=0)
        self.fits[laws, standstill] = fit

    @property
    def best(self) -> Recipe:
        """The recipe with the smallest residual on average over joints."""
        return min(self.scores, key=lambda recipe: float(np.mean(self.scores[recipe])))

    def final(self, recipe: Recipe) -> Fit:
        """Fit of a recipe to the training runs."""
        fit = self.fits.get((recipe.laws, recipe.standstill))
        if fit is None or self.parts is not self.runs:
            fit = shaped(self.data, self.model, self.runs, recipe)
        return refined(fit, self.runs, recipe)


def choose(
    data: DataSet, model: Model, runs: Sequence[Recording], tolerances: Sequence[float | None]
) -> tuple[Recipe, Candidates]:
    """The recipe that best predicts each training run from the others.

    One law for all joints first; then each joint the law that predicted it better, if that helps on average.
    """
    found, n = Candidates(data, model, runs), model.robot.dof
    for law, standstill in product(LAWS, (data.moving, None)):
        found.try_out((law,) * n, standstill, tolerances)
    best = found.best
    by_law = np.array([found.scores[best._replace(laws=(law,) * n)] for law in LAWS])
    found.try_out(tuple(LAWS[k] for k in by_law.argmin(axis=0)), best.standstill, [best.tolerance])
    best = found.best
    rows = [
        [*recipe.words, np.exp(np.mean(score)), "<- chosen" if recipe == best else ""]
        for recipe, score in found.scores.items()
    ]
    header = ["dry friction", "slides above", "prior of inertias", "relative residual", ""]
    show(f"{data.key}: choice by predicting each training run from the others", header, rows)
    return best, found


def without_run(equations: Equations, run: int) -> Equations:
    """The equations of all runs but one."""
    left = [rows for k, rows in enumerate(equations.runs) if k != run]
    picked = np.concatenate([np.arange(rows.start, rows.stop) for rows in left])
    stops = np.cumsum([0, *(rows.stop - rows.start for rows in left)])
    return replace(
        equations,
        regressor=equations.regressor[picked],
        current=equations.current[picked],
        known=equations.known[picked],
        weight=equations.weight[picked],
        runs=tuple(slice(a, b) for a, b in zip(stops[:-1], stops[1:], strict=True)),
    )
