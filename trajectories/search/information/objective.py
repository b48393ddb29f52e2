"""Objective: the number that a search makes small, with its gradient by the motion."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.effects import MotionGradient

from .criteria import Criterion
from .experiment import Experiment


class Objective(Protocol):
    """A number that a motion makes, to be minimised."""

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
        criterion: Of the information.
        size: Of each base parameter, shape (b,).
        rows: Independent rows a second that count, times the seconds of the run; only their sum with
            earlier information depends on it.
    """

    experiment: Experiment
    criterion: Criterion
    size: np.ndarray
    rows: float = 1.0

    def __call__(self, motion: Motion) -> tuple[float, Callable[[], MotionGradient]]:
        share = self.rows / len(motion)
        columns = self.experiment.columns(motion)
        information = self.experiment.gathered(columns, share)
        value, by = self.criterion(information, self.size)
        return value, lambda: self.experiment.pull(motion, columns, by, share)
