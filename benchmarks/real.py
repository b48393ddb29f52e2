"""Real arms: drive gains and an unknown mass of a UR10e, and held-out residuals of three arms.

The model is the README's (rigid body, rotors, viscous and dry friction, offset). How dry friction reverses,
from which speed on a joint counts as sliding, and how far the drawn inertias are believed is chosen by
predicting each training run from the others; held-out runs are looked at once, with the choice made. They
are compared in the README's own manner: everything through one zero-phase Butterworth over the whole file,
samples above its threshold of speed, norm of the residual over norm of the torque.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from common import options, save, show
from exidyn.identify.effects import EFFECTS
from exidyn.identify.equations import Equations, assemble
from exidyn.identify.estimators import Estimator, bayesian, weighted
from exidyn.identify.filters import low_pass
from exidyn.identify.fit import Fit
from exidyn.identify.identification import identify
from exidyn.identify.model import Model
from exidyn.identify.prepare import filtered, prepare
from exidyn.identify.recording import Recording
from real_data import FOLDER, KR300, PANDA, UR10E, DataSet, thirds
from real_payload import payloads

LAWS = ("coulomb_friction", "hysteresis")
"""Dry friction that turns over a velocity, or over a displacement: one size and one shape a joint each."""
TOLERANCES = (None, 3.0, 1.0, 0.3, 0.1)
"""Relative standard deviations of the drawn inertias as prior; None for no prior."""
QUICK_TOLERANCES = (None, 1.0, 0.1)


class Recipe(NamedTuple):
    """What is chosen by cross-validation.

    Attributes:
        law: Key of `EFFECTS` that takes the place of dry friction.
        standstill: Speed from which on a joint slides, in the fit [rad/s]; None for `prepare`'s own.
        tolerance: Relative standard deviation of the inertias before the data; None for no prior.
    """

    law: str
    standstill: float | None
    tolerance: float | None

    @property
    def words(self) -> list[str]:
        """The three choices for a table."""
        speed = "from data" if self.standstill is None else f"{self.standstill:g} rad/s"
        return [self.law, speed, "none" if self.tolerance is None else f"{self.tolerance:g}"]


def shaped(data: DataSet, model: Model, runs: Sequence[Recording], recipe: Recipe) -> Fit:
    """Weighted least squares with the law's shapes fitted too."""
    filtering = replace(data.filtering, standstill=recipe.standstill)
    model, shapes = with_law(model, recipe.law), [recipe.law]
    return identify(runs, model=model, filtering=filtering, fitted_shapes=shapes, drop=False)


def refined(fit: Fit, runs: Sequence[Recording], recipe: Recipe) -> Fit:
    """The fit again with the recipe's prior."""
    model = with_tolerance(fit.model, recipe.tolerance)
    return identify(runs, model=model, filtering=fit.filtering, estimator=estimator_of(recipe), drop=False)


def with_law(model: Model, law: str) -> Model:
    """The model with another law of dry friction in the place of Coulomb's."""
    dry = EFFECTS["coulomb_friction"]
    return replace(model, effects=tuple(EFFECTS[law]() if isinstance(e, dry) else e for e in model.effects))


def with_tolerance(model: Model, tolerance: float | None) -> Model:
    """The model with its inertias believed to another tolerance."""
    if tolerance is None:
        return model
    return replace(model, robot=replace(model.robot, inertial_tolerance=tolerance))


def estimator_of(recipe: Recipe) -> Estimator:
    """Least squares weighted by each joint's residual, with the prior if there is one."""
    return weighted if recipe.tolerance is None else bayesian


class Compared(NamedTuple):
    """One run in the README's manner; what any estimate leaves of it is then one product.

    Attributes:
        columns: Base regressor behind the low-pass, thinned out, shape (r, n, b) [N m / unit].
        known: Known torque, alike, shape (r, n) [N m].
        torque: Measured torque, alike, shape (r, n) [N m].
        counts: Whether the joint moves, shape (r, n).
    """

    columns: np.ndarray
    known: np.ndarray
    torque: np.ndarray
    counts: np.ndarray

    @classmethod
    def of(cls, fit: Fit, recording: Recording, data: DataSet) -> "Compared":
        """Prepare a run for the model of a fit."""
        motion, current = filtered(recording, fit.filtering)
        motion = fit.model.loaded(motion)
        thin = slice(None, None, max(1, int(data.rate / (3 * data.cutoff))))  # closer ones say the same

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


def choose(
    data: DataSet, model: Model, runs: Sequence[Recording], tolerances: Sequence[float | None]
) -> tuple[Recipe, dict[str, Fit]]:
    """The recipe that best predicts each training run from the others, and the shaped fit of each law.

    The measure is the mean, over joints and runs left out, of the logarithm of the relative residual.
    Shapes are fitted to all training runs: a number a joint, whichever the law.
    """
    parts = thirds(runs[0]) if len(runs) == 1 else runs
    mean: dict[Recipe, float] = {}
    fits: dict[tuple[str, float | None], Fit] = {}
    for law, standstill in product(LAWS, (data.moving, None)):
        fit = fits[law, standstill] = shaped(data, model, parts, Recipe(law, standstill, None))
        prepared = [prepare(replace(run, model=fit.model), fit.filtering) for run in parts]
        equations = assemble(fit.model, fit.base, prepared)
        compared = [Compared.of(fit, run, data) for run in parts]
        for tolerance in tolerances:
            recipe = Recipe(law, standstill, tolerance)
            believed = with_tolerance(fit.model, tolerance).beliefs
            prior = replace(equations, tolerance=np.array([belief.std for belief in believed]))
            estimates = [estimator_of(recipe)(without_run(prior, k)) for k in range(len(parts))]
            left = [run.relative(e.values) for run, e in zip(compared, estimates, strict=True)]
            mean[recipe] = float(np.exp(np.mean(np.log(left))))
    best = min(mean, key=mean.__getitem__)
    rows = [[*recipe.words, mean[recipe], "<- chosen" if recipe == best else ""] for recipe in mean]
    header = ["dry friction", "slides above", "prior of inertias", "relative residual", ""]
    show(f"{data.key}: choice by predicting each training run from the others", header, rows)
    return best, {law: fits[law, best.standstill] for law in LAWS}


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


def pooled(relative: np.ndarray) -> np.ndarray:
    """Root mean square over files, (files, n) -> (n,)."""
    return np.sqrt(np.mean(relative**2, axis=0))


def residuals(data: DataSet, model: Model, quick: bool) -> dict[str, Any]:
    """Held-out relative residuals beside the README's."""
    runs = [data.run(name) for name in data.train]
    tolerances = (QUICK_TOLERANCES if quick else TOLERANCES) if data.weighed else (None,)
    recipe, fits = choose(data, model, runs, tolerances)
    held_out = [data.run(name) for name in data.held_out]
    found = {}
    for law in LAWS:
        fit = refined(fits[law], runs, recipe)
        found[law] = np.array([Compared.of(fit, run, data).relative(fit.estimate.values) for run in held_out])
    ours = found[recipe.law]
    over = {law: pooled(relative) / pooled(data.yardstick) for law, relative in found.items()}
    rows = []
    for name, mine, theirs in zip(data.held_out, ours, data.yardstick, strict=True):
        rows += [[name, "yardstick", *theirs], ["", "exidyn", *mine], ["", "ratio", *(mine / theirs)]]
    rows += [["all, rms", "ratio", *over[recipe.law]]]
    rows += [["  the same with", law, *ratio] for law, ratio in over.items() if law != recipe.law]
    joints = [f"J{j + 1}" for j in range(ours.shape[1])]
    show(f"{data.key}: relative residual on held-out runs", ["run", "", *joints], rounded(rows))
    return {
        "residual_over_yardstick": over[recipe.law],
        "residual_over_yardstick_by_file": dict(zip(data.held_out, ours / data.yardstick, strict=True)),
        "residual_over_yardstick_by_law": over,
        "relative_residual_by_file": dict(zip(data.held_out, ours, strict=True)),
        "choice": recipe._asdict(),
    }


def rounded(rows: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """Numbers with four decimals."""
    return [[value if isinstance(value, str) else round(float(value), 4) for value in row] for row in rows]


def main() -> None:
    chosen = options(__doc__.splitlines()[0])
    if not (FOLDER / UR10E.urdf).exists():
        print(f"no recordings in {FOLDER}; set EXIDYN_DATA to their folder")
        save(chosen.json, {"skipped": "no recordings"})
        return
    gains, figures = payloads(UR10E, chosen.quick)
    results: dict[str, dict[str, Any]] = {UR10E.key: figures}
    for data in (UR10E, KR300, PANDA):
        model = data.model()
        if data is UR10E:
            model = replace(model, robot=replace(model.robot, drive_gain=gains))
        results.setdefault(data.key, {}).update(residuals(data, model, chosen.quick))
    save(chosen.json, results)


if __name__ == "__main__":
    main()
