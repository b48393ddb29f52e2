"""Torque limits of position servos from simulations, for runs without measured torque.

Without measured torque, a servo at its limit shows only in the motion: the joint falls behind its command,
and a simulation without the limit does not. A regression sees this only with fine encoders at high rates.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from ..arm.servo_law import ServoLaw
from ..diagnosis.questions.block_answer import CERTAIN_ODDS
from ..fit.servo_fit import ServoFit
from .servo_changes import changed_law, servo_changes
from .trial import Trial
from .windows import clipped_errors, windows

NEAR = np.linspace(0.85, 1.15, 13)
"""Limits that are tried, over the largest torque of the recorded motion: friction may be wrong by a tenth."""
NEARER = np.linspace(0.98, 1.02, 9)
"""Limits that are tried, over that of a regression."""
LARGEST = 99.0
"""Percentile of the torque of the recorded motion that counts as its largest: noise has peaks beyond it."""


def with_simulated_limits(fit: ServoFit, training: Trial, file: ServoLaw) -> ServoFit:
    """The fit, with limits of joints whose simulations of the training runs need one.

    A limit of a regression by commands alone is only a suggestion: other friction may look like one.

    Args:
        fit: Servos by regression; unchanged if it is by measured torque.
        training: The file, and the runs to which limits are fitted.
        file: Servos of the file.
    """
    if fit.measured:
        return fit
    law = changed_law(file, servo_changes(fit, file))
    search = _Search(training, replace(law, limit=file.limit))
    limits = [search.limit_of(joint, suggested) for joint, suggested in enumerate(fit.law.limit.tolist())]
    limit, std = np.array(limits).T
    return replace(fit, law=replace(fit.law, limit=limit), std=replace(fit.std, limit=std))


@dataclass
class _Search:
    """Search for the limit of one joint after the other."""

    trial: Trial  # the file, and the runs to which limits are fitted
    law: ServoLaw  # law of the servos, with the limits of the file

    def __post_init__(self) -> None:
        self.simulator = self.trial.simulator(self.trial.source.text)
        self.simulator.set_gains(self.law.stiffness, self.law.damping)
        self.simulator.delay = self.law.delay
        self.windows = windows(self.trial.runs)
        self.squares = self._squares(self.law.limit)
        torque = np.abs(np.concatenate([self.simulator.torque(run) for run in self.trial.runs]))
        self.largest = np.percentile(torque, LARGEST, axis=0)

    def limit_of(self, joint: int, suggested: float) -> tuple[float, float]:
        """Limit of a joint and its standard deviation [N m]; infinite unless a limit is credible.

        `suggested` is that of a regression, or infinite. It may be too low to hold the arm's weight.
        The error of a window counts as one sample, since errors within a window are correlated. A limit costs
        as in the Bayesian information criterion, and the number of limits that were tried on all joints.
        """
        limits = NEAR * self.largest[joint]
        if np.isfinite(suggested):
            limits = np.sort(np.append(limits, NEARER * suggested))
        squares = np.array([self._with_limit(joint, limit) for limit in limits])
        count, best = len(self.windows), int(np.argmin(squares))
        tiny = np.finfo(float).tiny  # a simulation without any error needs no limit
        gain = 0.5 * count * float(np.log(max(self.squares[joint], tiny) / max(squares[best], tiny)))
        cost = 0.5 * np.log(count) + np.log(len(limits) * len(self.law.limit))
        if gain - cost < CERTAIN_ODDS:
            return np.inf, np.inf
        ends = limits[max(best - 1, 0)], limits[min(best + 1, len(limits) - 1)]
        fine = minimize_scalar(lambda limit: self._with_limit(joint, limit), bounds=ends)
        return float(fine.x), self._std(joint, float(fine.x), float(fine.fun))

    def _std(self, joint: int, limit: float, least: float) -> float:
        """Standard deviation of a limit by the curvature of the squares about their minimum [N m]."""
        step = 0.02 * limit
        around = [self._with_limit(joint, limit + sign * step) for sign in (-1.0, 1.0)]
        curvature = max((sum(around) - 2.0 * least) / step**2, np.finfo(float).tiny)
        return float(np.sqrt(2.0 * least / len(self.windows) / curvature))

    def _with_limit(self, joint: int, limit: float) -> float:
        """Mean squared error of a joint with a limit, relative to its motion [-]."""
        limits = self.law.limit.copy()
        limits[joint] = min(limit, limits[joint])
        return float(self._squares(limits)[joint])

    def _squares(self, limits: np.ndarray) -> np.ndarray:
        """Mean squared error of each joint relative to its motion, shape (n,) [-]."""
        self.simulator.set_limits(limits)
        errors = clipped_errors(self.windows, self.simulator.roll_all(self.windows))
        return np.asarray(np.mean(errors.reshape(-1, len(limits)) ** 2, axis=0))
