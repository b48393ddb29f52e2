"""Gains of position servos from simulations, for runs in which a regression does not determine them.

A regression without measured torque takes the torque of the file's bodies. Dry friction that exceeds it hides
the gains: a joint that sticks says nothing in a regression, but its simulation shows when it sticks. Gains,
armature, damping, dry friction and one delay are fitted together to the positions of short simulations.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from ..arm.servo_law import ServoLaw
from ..diagnosis.questions.block_answer import CERTAIN_ODDS
from ..fit.servo_fit import ServoFit
from ..fit.servo_runs import LONGEST
from ..robot_files.mjcf import compile_mjcf
from .refine import FIELDS, dofs_of, joint_numbers
from .servo_changes import common_factor, determined, doubtful
from .trial import Trial
from .windows import clipped_errors, windows

FACTORS = tuple(2.0**power for power in range(-8, 4))
"""Factors on the file's stiffness with which simulations are tried: files state gains that are wrong by a
hundred, of which a hobby servo is softer."""
SHARES = (0.0, 0.5)
"""Dry friction over the usual torque of a servo, with which simulations are tried besides the file's."""
LEAST = np.array([1e-3, 1e-2, 1e-2])
"""Armature, damping and dry friction from which a search starts if the file has less: the logarithm of zero
does not exist."""
TEN = float(np.log(10.0))
"""Prior deviation of the logarithm of a number of the file."""
CYCLE = 0.01
"""Prior deviation of the delay [s]: half a period of a usual log."""
RIDGE = 1e-4
"""Share of the squared error of the start that a change by its prior deviation costs: numbers that the
simulation does not show stay as they are."""
EVALUATIONS = 15
"""Maximum number of steps of the search."""
ENOUGH = 1e-3
"""Relative change below which the search ends: a hundredth of the accuracy that counts as determined."""
GAINS = ("stiffness", "damping", "delay")
"""Numbers of a servo that are searched for."""
ALL = (*GAINS, "limit", "feed_forward", "integral")
DIFFERENCE = 0.02
"""Step of a finite difference in logarithms, and in delays of `CYCLE`: simulations go in steps."""


def with_simulated_gains(fit: ServoFit, training: Trial, file: ServoLaw) -> ServoFit:
    """The fit, with gains from simulations of the training runs for joints that it does not determine."""
    joints = np.flatnonzero(~determined(fit) & ~doubtful(fit))
    if fit.measured or not len(joints):
        return fit
    search = _Search(training, file, fit, joints)
    values, std = search.optimum(search.start(FACTORS))
    usual = search.start([common_factor(fit, file)])
    held, _ = search.optimum(usual, np.arange(len(usual)) >= len(joints))
    credible = np.flatnonzero(search.odds(held, values) > CERTAIN_ODDS)
    return search.fitted(values, std, joints[credible])


def with_simulated_delay(fit: ServoFit, training: Trial, law: ServoLaw) -> ServoFit:
    """The fit, with one delay of all joints from simulations of the training runs.

    In a regression, damping is nearly a delay of damping over stiffness. `law` is that of the trial's file,
    whose gains are nearly right.
    """
    joints, first = np.arange(len(law.delay)), float(np.median(np.clip(fit.law.delay, 0.0, LONGEST)))
    start = replace(law, delay=np.full(len(joints), first))
    search = _Search(training, start, fit, joints)
    simulated = search.fitted(*search.optimum(search.start([1.0])), joints)
    return replace(
        fit,
        law=replace(fit.law, delay=simulated.law.delay),
        std=replace(fit.std, delay=simulated.std.delay),
    )


@dataclass
class _Search:
    """Search for gains, armature, damping and dry friction of some joints, and for their delay."""

    trial: Trial  # the file, and the runs to which the numbers are fitted
    file: ServoLaw  # servos of the file
    fit: ServoFit  # servos by regression
    joints: np.ndarray  # indices of the joints whose numbers are searched for, shape (u,)

    def __post_init__(self) -> None:
        source, names = self.trial.source, self.trial.model.robot.joints
        self.simulator = self.trial.simulator(source.text)
        self.dofs = np.array(dofs_of(self.simulator.model, names))[self.joints]
        self.simulator.set_limits(np.minimum(self.file.limit, self.fit.law.limit))
        self.windows = windows(self.trial.runs)
        numbers = joint_numbers(compile_mjcf(source.text.decode(), source.folder), names)
        self.numbers = np.maximum(numbers[:, self.joints], LEAST[:, None])
        others = np.delete(np.arange(len(names)), self.joints)
        self.law = with_joints(self.file, self.fit.law, others)
        self.delay = float(np.median(self.law.delay[others] if len(others) else self.law.delay))

    def start(self, factors: Sequence[float]) -> np.ndarray:
        """Numbers that simulate best without a search, with one of these factors on the file's stiffness.

        They are logarithms of factors, armature, damping and dry friction, and the delay over `CYCLE`.
        """
        errors = [run.command - run.position for run in self.trial.runs if run.command is not None]
        usual = np.sqrt(np.mean(np.concatenate(errors) ** 2, axis=0)) * self.file.stiffness
        starts = []
        for factor in factors:
            for share in SHARES:
                armature, damping, dry = self.numbers
                dry = np.maximum(dry, share * factor * usual[self.joints])
                rows = np.log([np.full(len(dry), factor), armature, damping, dry])
                starts.append(np.append(rows, self.delay / CYCLE))
        return min(starts, key=lambda start: float(np.linalg.norm(self._residual(start))))

    def optimum(self, start: np.ndarray, free: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the least squared error, of which some are free, and standard deviations."""
        free = np.ones(len(start), bool) if free is None else free
        first, deviation = self._residual(start), np.append(np.full(len(start) - 1, TEN), 1.0)[free]
        weight = np.sqrt(RIDGE * float(first @ first))

        def moved(values: np.ndarray) -> np.ndarray:
            numbers = start.copy()
            numbers[free] = values
            return numbers

        def error(values: np.ndarray) -> np.ndarray:
            return np.append(self._residual(moved(values)), weight * (values - start[free]) / deviation)

        def jacobian(values: np.ndarray) -> np.ndarray:
            here, steps = error(values), DIFFERENCE * np.eye(len(values))
            return np.stack([error(values + step) - here for step in steps], axis=1) / DIFFERENCE

        ends = {"ftol": ENOUGH, "xtol": ENOUGH, "max_nfev": EVALUATIONS}
        best = least_squares(error, start[free], jacobian, x_scale=deviation, **ends)
        residual, std = self._residual(moved(best.x)), np.zeros(len(start))
        # The error of a window counts as one sample, since errors within a window are correlated.
        variance = float(residual @ residual) / len(self.windows)
        std[free] = np.sqrt(variance * np.diag(np.linalg.pinv(best.jac.T @ best.jac, hermitian=True)))
        return moved(best.x), std

    def odds(self, held: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Log odds that each joint needs another gain than the one held, shape (u,).

        Another gain costs as in the Bayesian information criterion, and the number of factors tried.
        """
        with_held, without = (self._squares(numbers) for numbers in (held, values))
        count = len(self.windows)
        tiny = np.finfo(float).tiny
        gain = 0.5 * count * np.log(np.maximum(with_held, tiny) / np.maximum(without, tiny))
        return np.asarray(gain - 0.5 * np.log(count) - np.log(len(FACTORS)))

    def fitted(self, values: np.ndarray, std: np.ndarray, joints: np.ndarray) -> ServoFit:
        """The fit with numbers of a search for some of its joints."""
        law, relative = self._law(values), np.zeros(len(self.law.stiffness))
        relative[self.joints] = std[: len(self.joints)]
        spread = replace(
            law, stiffness=relative * law.stiffness, damping=relative * law.damping,
            delay=np.full(len(law.delay), CYCLE * std[-1]),
        )  # fmt: skip
        return replace(
            self.fit,
            law=with_joints(self.fit.law, law, joints, GAINS),
            std=with_joints(self.fit.std, spread, joints, GAINS),
            simulated=np.isin(np.arange(len(relative)), joints),
        )

    def _squares(self, values: np.ndarray) -> np.ndarray:
        """Mean squared error of each joint relative to its motion, shape (u,) [-]."""
        return np.asarray(np.mean(self._residual(values).reshape(-1, len(self.joints)) ** 2, axis=0))

    def _law(self, values: np.ndarray) -> ServoLaw:
        """Law of all joints, of which some have other gains and another delay."""
        factors = np.ones(len(self.law.stiffness))
        factors[self.joints] = np.exp(values[: len(self.joints)])
        delay = self.law.delay.copy()
        delay[self.joints] = max(CYCLE * values[-1], 0.0)
        stiffness, damping = factors * self.law.stiffness, factors * self.law.damping
        return replace(self.law, stiffness=stiffness, damping=damping, delay=delay)

    def _residual(self, values: np.ndarray) -> np.ndarray:
        """Simulated minus recorded positions of the joints over their motion, shape (r,)."""
        law = self._law(values)
        self.simulator.set_gains(law.stiffness, law.damping)
        self.simulator.delay = law.delay
        rows = np.exp(values[len(self.joints) : -1]).reshape(len(FIELDS), -1)
        for name, row in zip(FIELDS.values(), rows, strict=True):
            getattr(self.simulator.model, name)[self.dofs] = row
        self.simulator.renew()
        errors = clipped_errors(self.windows, self.simulator.roll_all(self.windows))
        return errors.reshape(-1, len(law.delay))[:, self.joints].ravel()


def with_joints(law: ServoLaw, other: ServoLaw, joints: np.ndarray, names: Sequence[str] = ALL) -> ServoLaw:
    """A law with some numbers of another one for some joints."""
    values = {name: np.array(getattr(law, name)) for name in names}
    for name, numbers in values.items():
        numbers[joints] = getattr(other, name)[joints]
    return replace(law, **values)
