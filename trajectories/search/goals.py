"""Goals of a trajectory, each as a sequence of objectives that approximate it increasingly well."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Self

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import MotionGradient
from exidyn.identification.model import Model

from .criteria import Criterion, condition, name_of, volume
from .experiment import Experiment
from .torque_spread import TorqueSpread
from .unknowns import design_model


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
