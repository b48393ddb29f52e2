r"""Goals of a trajectory, each as a sequence of objectives that approximate it increasingly well.

Objectives are criteria of the information matrix :math:`M = W^T W` (rows in units of their noise), which is a
sum over runs, earlier data and priors. A criterion is a function of M and of the size of each parameter,
shape (b,), that returns its value and its symmetric derivative by M.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Self

import numpy as np
from scipy.linalg import eigh

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import MotionGradient
from exidyn.identification.model import Model

from .experiment import Experiment, design_model
from .torque_spread import TorqueSpread

Criterion = Callable[[np.ndarray, np.ndarray], tuple[float, np.ndarray]]

SMALLEST = 1e-14
"""Share of the largest eigenvalue that is rounding of zero; smaller eigenvalues are raised to it."""


def condition(information: np.ndarray, size: np.ndarray, power: float = np.inf) -> tuple[float, np.ndarray]:
    """Logarithm of the condition number of the regressor with scaled columns.

    Columns have norm one, or less if their scale reaches its bound, `size`, which may be infinite: a slow
    joint has small columns, and scaled to one its parameters would seem to be known as well as any others. If
    `power` is finite, sums of this power over all eigenvalues replace the largest and the smallest: an upper
    bound that is smooth if eigenvalues coincide.
    """
    norm = np.sqrt(np.diag(information))
    scale = np.minimum(1.0 / norm, size)
    scaled = information * np.outer(scale, scale)
    values, vectors = eigh(scaled)
    values = np.maximum(values, SMALLEST * values[-1])
    high, by_high = _peak(np.log(values), power)
    low, by_low = _peak(-np.log(values), power)
    by_value = 0.5 * (by_high - by_low) / values
    by_scaled = (vectors * by_value) @ vectors.T
    through_scale = np.where(scale < size, np.sum(by_scaled * scaled, axis=1) / norm**2, 0.0)
    return 0.5 * (high + low), by_scaled * np.outer(scale, scale) - np.diag(through_scale)


def volume(information: np.ndarray, size: np.ndarray) -> tuple[float, np.ndarray]:
    """D-optimality: mean logarithm of relative standard deviations along the confidence ellipsoid's axes."""
    covariance, logarithm = _inverted(information, size)
    count = len(size)
    return 0.5 / count * logarithm, -0.5 / count * covariance * np.outer(size, size)


def average(information: np.ndarray, size: np.ndarray) -> tuple[float, np.ndarray]:
    """A-optimality: logarithm of the root mean square standard deviation relative to parameter size."""
    return _deviation(information, size, 1.0)


def worst(information: np.ndarray, size: np.ndarray, power: float = 16.0) -> tuple[float, np.ndarray]:
    """Smooth upper bound of the logarithm of the largest standard deviation relative to parameter size.

    A sum of this power of the variances replaces the largest, smooth if two are equal. With 16 and forty
    parameters it is at most 26 % above the largest variance, or 12 % above the largest standard deviation.
    """
    return _deviation(information, size, power)


@dataclass(frozen=True)
class Focus:
    """Like `volume`, but for some parameters only (D_s); the others are unknown, but need no precision."""

    columns: tuple[int, ...]  # indices of the selected base parameters

    def __call__(self, information: np.ndarray, size: np.ndarray) -> tuple[float, np.ndarray]:
        """Value and derivative by the information matrix."""
        selected_columns = _inverted(information, size)[0][:, list(self.columns)]
        selected = selected_columns[list(self.columns)]
        count = len(self.columns)
        gradient = -0.5 / count * selected_columns @ np.linalg.solve(selected, selected_columns.T)
        return 0.5 / count * float(np.linalg.slogdet(selected)[1]), gradient * np.outer(size, size)


def _deviation(information: np.ndarray, size: np.ndarray, power: float) -> tuple[float, np.ndarray]:
    """Logarithm of the root of a power sum of relative variances, or of their mean if the power is 1."""
    covariance, _ = _inverted(information, size)
    variance = np.diag(covariance)
    highest, share = _peak(np.log(variance), power)
    if power == 1.0:
        highest -= np.log(len(variance))
    gradient = -(covariance * (0.5 * share / variance)) @ covariance
    return 0.5 * highest, gradient * np.outer(size, size)


def _inverted(information: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, float]:
    """Covariance of parameters in units of their size, and the logarithm of its determinant.

    Columns are first scaled to one: sizes would spread the eigenvalues by a factor of thousands, and the
    smallest would be rounding.
    """
    scale = 1.0 / np.sqrt(np.diag(information))
    values, vectors = eigh(information * np.outer(scale, scale))
    values = np.maximum(values, SMALLEST * values[-1])
    relative = scale / size
    covariance = ((vectors / values) @ vectors.T) * np.outer(relative, relative)
    return covariance, float(2 * np.sum(np.log(relative)) - np.sum(np.log(values)))


def _peak(logarithms: np.ndarray, power: float) -> tuple[float, np.ndarray]:
    """Largest logarithm, or the logarithm of the power sum, and its derivative by each logarithm."""
    largest = float(np.max(logarithms))
    if np.isinf(power):
        share = np.zeros(len(logarithms))
        share[int(np.argmax(logarithms))] = 1.0
        return largest, share
    weights = np.exp(power * (logarithms - largest))
    return largest + float(np.log(weights.sum())) / power, weights / weights.sum()


CRITERIA: dict[str, Criterion] = {
    "condition": condition,
    "volume": volume,
    "average": average,
    "worst": worst,
}
"""Criterion by its name on the command line."""


def name_of(criterion: Criterion) -> str:
    """Name of a criterion in `CRITERIA`, or "focus" for any other."""
    return next((name for name, function in CRITERIA.items() if function is criterion), "focus")


class Objective(ABC):
    """A function of a motion to minimize."""

    # Whether a search can follow its gradient; a nonsmooth objective only evaluates the results of its smooth
    # approximations.
    smooth: bool = True

    @abstractmethod
    def __call__(self, motion: Motion) -> tuple[float, Callable[[], MotionGradient]]:
        """The value, and a function that computes its gradient by the motion, which a line search omits."""

    def value(self, motion: Motion) -> float:
        """The value alone."""
        return self(motion)[0]


@dataclass(frozen=True, eq=False)
class Informative(Objective):
    """Objective: a criterion of the information from an experiment."""

    experiment: Experiment  # unknowns and runs
    criterion: Criterion  # criterion of the information
    size: np.ndarray  # size of each base parameter, shape (b,)
    # Number of independent rows of the run; it matters only relative to earlier information.
    rows: float = 1.0

    @property
    def smooth(self) -> bool:  # type: ignore[override]
        return self.criterion is not condition

    def __call__(self, motion: Motion) -> tuple[float, Callable[[], MotionGradient]]:
        share = self.rows / len(motion)
        value, by = self.criterion(self.experiment.information(motion, share), self.size)
        return value, lambda: self.experiment.pull(motion, by, share)


LADDER: dict[Criterion, tuple[Criterion, ...]] = {
    condition: tuple(partial(condition, power=2.0**k) for k in range(2, 8))
}
"""Smooth approximations of a nonsmooth criterion, in which all eigenvalues near the smallest contribute:
those within tens of percent with a power of 4, within one percent with 128. Any other criterion is preceded
by the volume, to which all parameters contribute."""


FAIR = 0.1**0.5
"""Share of a column's norm in random motions below which the column counts as small in a condition number: a
tenth of the information, so that its parameter alone would need ten times the recording."""


@dataclass(frozen=True, eq=False)
class Goal(ABC):
    """The goal of a trajectory."""

    # Uncertainty of the arm's torque, for which the torque limits leave room; None for none.
    spread: TorqueSpread | None = field(default=None, kw_only=True)

    def with_spread(self, spread: TorqueSpread | None) -> Self:
        """This goal with another spread of torque."""
        return replace(self, spread=spread)

    @property
    @abstractmethod
    def model(self) -> Model:
        """Nominal model, whose torque must keep to the limits."""

    @property
    @abstractmethod
    def payloads(self) -> Sequence[str]:
        """Payload in each run of the motion."""

    @abstractmethod
    def objectives(self, limits: Limits, spacing: float) -> Sequence[Objective]:
        """Objectives for samples that are `spacing` apart [s]; the last is the goal itself.

        A spacing of 0 leaves friction as sharp as in the model.
        """

    @abstractmethod
    def reached(self, value: float) -> float:
        """Value of the last objective as a condition number, relative standard deviation or probability."""

    @abstractmethod
    def words(self, value: float) -> str:
        """Value of the last objective in words."""


@dataclass(frozen=True, eq=False)
class Identify(Goal):
    """The goal to identify a model's unknowns."""

    experiment: Experiment  # unknowns and runs
    criterion: Criterion = condition  # criterion to minimize
    rows: float = 1.0  # number of independent rows of a run, which matters relative to earlier information
    # Model whose torque must keep to the limits; that of the experiment by default.
    nominal: Model | None = None
    # Payload in each run whose torque must keep to them; those of the experiment by default.
    loads: Sequence[str] = ()

    @property
    def model(self) -> Model:
        return self.nominal or self.experiment.model

    @property
    def payloads(self) -> Sequence[str]:
        return self.loads or self.experiment.payloads

    def objectives(self, limits: Limits, spacing: float) -> Sequence[Objective]:
        smooth = replace(self.experiment, model=design_model(self.experiment.model, limits, spacing))
        size = self.experiment.sizes
        if self.criterion is condition:
            least = FAIR * np.sqrt(self.rows) * smooth.column_rms(limits)
            size = 1.0 / np.maximum(least, np.finfo(float).tiny)
        before = () if self.criterion is volume else LADDER.get(self.criterion, (volume,))
        ladder: tuple[Criterion, ...] = (*before, self.criterion)
        return [Informative(smooth, criterion, size, self.rows) for criterion in ladder]

    def condition_number(self, motion: Motion, limits: Limits) -> float:
        """Condition number from a motion, with friction as in the model, for any criterion."""
        objective = replace(self, criterion=condition).objectives(limits, 0.0)[-1]
        return float(np.exp(objective.value(motion)))

    def reached(self, value: float) -> float:
        return float(np.exp(value))

    def words(self, value: float) -> str:
        return f"{MEANING[name_of(self.criterion)]} {self.reached(value):.4g}"


MEANING = {
    "condition": "condition number",
    "volume": "mean relative standard deviation",
    "average": "root mean square relative standard deviation",
    "worst": "worst relative standard deviation",
    "focus": "mean relative standard deviation of the parameters in focus",
}
"""Meaning of the exponential of a criterion's value, by name of the criterion."""
