"""Gains of position servos from simulations, for runs in which a regression does not determine them.

A regression without measured torque takes the torque of the file's bodies. Dry friction that exceeds it hides
the gains: a joint that sticks says nothing in a regression, but its simulation shows when it sticks. Gains,
armature, damping, dry friction and one delay are fitted together to the positions of short simulations.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from ..arm.servo_law import ServoLaw
from ..fit.servo_fit import ServoFit
from ..robot_files.mjcf import compile_mjcf
from .refine import FIELDS, dofs_of, joint_numbers
from .servo_changes import determined, doubtful
from .trial import Trial
from .windows import clipped_errors, windows

FACTORS = 2.0 ** np.arange(-8.0, 4.0)
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
DIFFERENCE = 0.02
"""Step of a finite difference in logarithms, and in delays of `CYCLE`: simulations go in steps."""


def with_simulated_gains(fit: ServoFit, training: Trial, file: ServoLaw) -> ServoFit:
    """The fit, with gains from simulations of the training runs for joints that it does not determine."""
    unknown = ~determined(fit) & ~doubtful(fit)
    if fit.measured or not np.any(unknown):
        return fit
    return _Search(training, file, fit, unknown).fit_of_all()


@dataclass
class _Search:
    """Search for gains, armature, damping, dry friction and a delay.

    Attributes:
        trial: The file, and the runs to which the numbers are fitted.
        file: Servos of the file.
        fit: Servos by regression.
        unknown: Joints whose gains are searched for, shape (n,).
    """

    trial: Trial
    file: ServoLaw
    fit: ServoFit
    unknown: np.ndarray

    def __post_init__(self) -> None:
        source, joints = self.trial.source, self.trial.model.robot.joints
        self.simulator = self.trial.simulator(source.text)
        self.dofs = dofs_of(self.simulator.model, joints)
        self.simulator.set_limits(np.minimum(self.file.limit, self.fit.law.limit))
        self.windows = windows(self.trial.runs)
        numbers = joint_numbers(compile_mjcf(source.text.decode(), source.folder), joints)
        self.start = np.log(np.maximum(numbers, LEAST[:, None]))
        self.law = replace(
            self.file,
            stiffness=np.where(self.unknown, self.file.stiffness, self.fit.law.stiffness),
            damping=np.where(self.unknown, self.file.damping, self.fit.law.damping),
        )

    def fit_of_all(self) -> ServoFit:
        """The fit with the gains that are found."""
        start = self._start()
        first = self._residual(start)
        weight = np.sqrt(RIDGE * float(first @ first))
        deviation = np.append(np.full(len(start) - 1, TEN), 1.0)

        def error(values: np.ndarray) -> np.ndarray:
            return np.append(self._residual(values), weight * (values - start) / deviation)

        def jacobian(values: np.ndarray) -> np.ndarray:
            steps = DIFFERENCE * np.eye(len(values))
            return np.stack([error(values + step) - error(values) for step in steps], axis=1) / DIFFERENCE

        best = least_squares(error, start, jacobian, x_scale=deviation, max_nfev=EVALUATIONS)
        residual = self._residual(best.x)
        # The error of a window counts as one sample, since errors within a window are correlated.
        variance = float(residual @ residual) / len(self.windows)
        std = np.sqrt(variance * np.diag(np.linalg.inv(best.jac.T @ best.jac)))
        return self._with(best.x, std)

    def _start(self) -> np.ndarray:
        """Logarithms of the numbers that simulate best without a search, and no delay."""
        count, starts = int(self.unknown.sum()), []
        for factor in FACTORS:
            torque = factor * self.law.stiffness * self._usual_error()
            for share in SHARES:
                armature, damping, dry = self.start
                dry = np.maximum(dry, np.log(np.maximum(share * torque, LEAST[2])))
                numbers = np.concatenate([armature, damping, dry])
                starts.append(np.concatenate([np.full(count, np.log(factor)), numbers, [0.0]]))
        return min(starts, key=lambda start: float(np.linalg.norm(self._residual(start))))

    def _usual_error(self) -> np.ndarray:
        """Rms of command minus position, shape (n,) [rad]."""
        errors = [run.command - run.position for run in self.trial.runs if run.command is not None]
        return np.asarray(np.sqrt(np.mean(np.concatenate(errors) ** 2, axis=0)))

    def _split(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Factors on the gains (n,), armature, damping and dry friction (3, n), and the delay [s]."""
        count = int(self.unknown.sum())
        factors = np.ones(len(self.unknown))
        factors[self.unknown] = np.exp(values[:count])
        return factors, np.exp(values[count:-1]).reshape(self.start.shape), CYCLE * float(values[-1])

    def _residual(self, values: np.ndarray) -> np.ndarray:
        """Simulated minus recorded positions over the motion of the joints, shape (r,)."""
        factors, numbers, delay = self._split(values)
        self.simulator.set_gains(factors * self.law.stiffness, factors * self.law.damping)
        self.simulator.delay = np.full(len(factors), max(delay, 0.0))
        for name, row in zip(FIELDS.values(), numbers, strict=True):
            getattr(self.simulator.model, name)[self.dofs] = row
        self.simulator.renew()
        return clipped_errors(self.windows, self.simulator.roll_all(self.windows))

    def _with(self, values: np.ndarray, std: np.ndarray) -> ServoFit:
        factors, _, delay = self._split(values)
        count, unknown, law = int(self.unknown.sum()), self.unknown, self.fit.law
        relative = np.zeros(len(unknown))
        relative[unknown] = std[:count]
        stiffness, damping = factors * self.law.stiffness, factors * self.law.damping
        return replace(
            self.fit,
            law=replace(
                law,
                stiffness=np.where(unknown, stiffness, law.stiffness),
                damping=np.where(unknown, damping, law.damping),
                delay=np.where(unknown, max(delay, 0.0), law.delay),
            ),
            std=replace(
                self.fit.std,
                stiffness=np.where(unknown, relative * stiffness, self.fit.std.stiffness),
                damping=np.where(unknown, relative * damping, self.fit.std.damping),
                delay=np.where(unknown, CYCLE * std[-1], self.fit.std.delay),
            ),
        )
