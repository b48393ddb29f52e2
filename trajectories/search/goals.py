"""Goals: what a trajectory is to be best for, as objectives that come nearer to it one after the other."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import MotionGradient
from exidyn.identification.model import Model

from .criteria import Criterion, condition, name_of, volume
from .experiment import Experiment
from .torque_spread import TorqueSpread
from .unknowns import design_model


class Objective(Protocol):
    """A number that a motion makes, to be minimised.

    Attributes:
        smooth: Whether a search can follow its gradient; what is not smooth judges what its stand-ins find.
    """

    smooth: bool = True

    def __call__(self, motion: Motion) -> tuple[float, Callable[[], MotionGradient]]:
        """Value, and what computes its gradient by the motion: a line search asks for the value alone."""

    def value(self, motion: Motion) -> float:
        """Value alone."""
        return self(motion)[0]


@dataclass(frozen=True, eq=False)
class Informative(Objective):
    """Objective: a criterion of the information that an experiment gives per run of unit length.

    Attributes:
        experiment: Unknowns and runs.
        criterion: Criterion of the information.
        size: Size of each base parameter, shape (b,).
        rows: Independent rows a second that count, times the seconds of the run; only their sum with
            earlier information depends on it.
    """

    experiment: Experiment
    criterion: Criterion
    size: np.ndarray
    rows: float = 1.0

    @property
    def smooth(self) -> bool:  # type: ignore[override]
        return self.criterion is not condition

    def __call__(self, motion: Motion) -> tuple[float, Callable[[], MotionGradient]]:
        share = self.rows / len(motion)
        columns = self.experiment.columns(motion)
        information = self.experiment.gathered(columns, share)
        value, by = self.criterion(information, self.size)
        return value, lambda: self.experiment.pull(motion, columns, by, share)


LADDER: dict[Criterion, tuple[Criterion, ...]] = {
    condition: tuple(partial(condition, power=2.0**k) for k in range(2, 8))
}
"""Stand-ins for a criterion that is not smooth: where several eigenvalues are nearly the smallest, they pull
together, with a power of 4 all that are within some tens of per cent of it, with 128 within one. Before any
other criterion comes the volume, which all parameters move."""


FAIR = 0.1**0.5
"""Share of a column's norm in random motions below which the column counts as small in a condition number: a
tenth of the information, so that its parameter alone would need ten times the recording."""


class Goal(Protocol):
    """What a trajectory is to be best for."""

    @property
    def model(self) -> Model:
        """The nominal arm: for its torque."""

    @property
    def payloads(self) -> Sequence[str]:
        """Body carried in each run of the motion."""

    @property
    def spread(self) -> TorqueSpread | None:
        """What is not known of the arm's torque, for which its limits leave room; None for nothing."""

    def with_spread(self, spread: TorqueSpread | None) -> "Goal":
        """The same with another spread of torque."""

    def objectives(self, limits: Limits, spacing: float) -> Sequence[Objective]:
        """Objectives for samples that are `spacing` apart [s]; the last is the goal itself.

        A spacing of 0 leaves friction as sharp as the model states it.
        """

    def reached(self, value: float) -> float:
        """What a value of the last objective means, as a number: a condition number, a probability."""

    def words(self, value: float) -> str:
        """The same in words."""


@dataclass(frozen=True, eq=False)
class Identify:
    """To identify a model's unknowns.

    Attributes:
        experiment: Unknowns and runs.
        criterion: What to make small.
        rows: Independent rows of a run, seconds times rows a second; matters beside earlier information.
        nominal: The model whose torque is kept to the limits; that of the experiment unless given.
        spread: What is not known of that torque.
    """

    experiment: Experiment
    criterion: Criterion = condition
    rows: float = 1.0
    nominal: Model | None = None
    spread: TorqueSpread | None = None

    @property
    def model(self) -> Model:
        """The nominal arm."""
        return self.nominal or self.experiment.model

    @property
    def payloads(self) -> Sequence[str]:
        """Body carried in each run."""
        return self.experiment.payloads

    def with_spread(self, spread: TorqueSpread | None) -> "Identify":
        return replace(self, spread=spread)

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
        """Condition number from a motion, with friction as stated, whatever the criterion."""
        judge = replace(self, criterion=condition).objectives(limits, 0.0)[-1]
        return float(np.exp(judge.value(motion)))

    def reached(self, value: float) -> float:
        return float(np.exp(value))

    def words(self, value: float) -> str:
        return f"{MEANING[name_of(self.criterion)]} {self.reached(value):.4g}"


MEANING = {
    "condition": "condition number",
    "volume": "mean relative deviation",
    "average": "root mean square relative deviation",
    "worst": "worst relative deviation",
    "focus": "mean relative deviation of what is in focus",
}
"""Name of a criterion -> what the exponential of its value is."""
