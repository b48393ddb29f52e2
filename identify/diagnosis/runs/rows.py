"""Rows: what was measured, what is nominal, and the columns that explain the difference."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...effects import JointEffect, Prior
from ...fit.base_parameters import BaseParameters
from ...fit.equations import decimated_regressor
from ...model import Model
from .driven import Driven, slices


@dataclass(frozen=True, eq=False)
class Rows:
    """Stacked rows of some runs.

    Attributes:
        runs: Rows of each run.
        difference: Measured torque minus that of the nominal model, shape (r, n) [N m].
        weight: 0 where a joint sticks, else 1, shape (r, n).
        columns: Torque per unit of each unknown, shape (r, n, b).
        names: Of the unknowns.
        std: How far each unknown may be from its mean, infinite without a prior, shape (b,).
        mean: Prior mean of each, zero but for what was found and is known to be whole, shape (b,).
        lower: Smallest value that physics allows each, shape (b,); none where it is None.
        bounds: Whether the deviation of each is that of a bound, shape (b,); of none where it is None.
    """

    runs: tuple[slice, ...]
    difference: np.ndarray
    weight: np.ndarray
    columns: np.ndarray
    names: tuple[str, ...]
    std: np.ndarray
    mean: np.ndarray
    lower: np.ndarray | None = None
    bounds: np.ndarray | None = None

    @property
    def limited(self) -> np.ndarray:
        """Places of the unknowns that physics limits."""
        return np.flatnonzero(np.isfinite(self.least))

    @property
    def least(self) -> np.ndarray:
        """Smallest value of each, shape (b,); minus infinity without a limit."""
        return np.full(len(self.names), -np.inf) if self.lower is None else self.lower

    @property
    def bounded(self) -> np.ndarray:
        """Whether each is certain to be within the square root of three deviations, shape (b,)."""
        return np.zeros(len(self.names), bool) if self.bounds is None else self.bounds

    def plus(
        self,
        names: Sequence[str],
        columns: np.ndarray,
        std: np.ndarray,
        mean: np.ndarray | None = None,
        lower: Sequence[float] | None = None,
        bounded: bool = False,
    ) -> "Rows":
        """The same with more unknowns: columns (r, n, p), deviations (p,) from a mean (p,), and limits.

        Deviations may be those of bounds.
        """
        return replace(
            self,
            columns=np.concatenate([self.columns, columns], axis=2),
            names=(*self.names, *names),
            std=np.concatenate([self.std, std]),
            mean=np.concatenate([self.mean, np.zeros(len(std)) if mean is None else mean]),
            lower=np.append(self.least, np.full(len(std), -np.inf) if lower is None else lower),
            bounds=np.append(self.bounded, np.full(len(std), bounded)),
        )


def model_rows(model: Model, runs: Sequence[Driven], values: np.ndarray | None = None) -> Rows:
    """Rows whose unknowns are the deviations of the model's parameters from their priors.

    Args:
        model: With its priors.
        runs: Of which rows are made.
        values: Parameters (p,) that give the load for the friction of gears; nominal ones by default.
    """
    carrying = model if values is None else _with_values(model, values)
    nominal, every = model.nominal_values, np.arange(len(model.names))
    # Priors make the system regular, so that no base parameters are needed.
    base = BaseParameters(tuple(model.parameters), every, np.eye(len(every)), (1.0, 0.0))
    columns, difference = [], []
    for run in runs:
        regressor, known = decimated_regressor(carrying, base, run.prepared, run.motion)
        measured = run.prepared.gain * run.prepared.decimated_current
        columns.append(regressor)
        difference.append(measured - known - regressor @ nominal)
    return Rows(
        slices(runs),
        np.concatenate(difference),
        np.concatenate([run.prepared.weight for run in runs]),
        np.concatenate(columns),
        tuple(model.names),
        np.array([prior.std for prior in model.priors]),
        np.zeros(len(model.names)),
        _limits(model) - nominal,
        np.array([name in model.bounded for name in model.names]),
    )


def _with_values(model: Model, values: np.ndarray) -> Model:
    priors = {name: Prior(float(value)) for name, value in zip(model.names, values, strict=True)}
    return replace(model, stated=priors)


def _limits(model: Model) -> np.ndarray:
    """Smallest value of each parameter, shape (p,); none of bodies and rotors, which share their inertia."""
    found: list[float] = []
    for effect in model.effects:
        own = isinstance(effect, JointEffect) and effect.massless
        found += [one.minimum if own else -np.inf for one in effect.parameters(model.robot)]
    return np.array(found)
