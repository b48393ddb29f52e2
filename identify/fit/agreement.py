"""Agreement: how well a fit predicts a run."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arm.robot import Robot
from ..notebook import optional
from ..preparation.prepare import Prepared
from .estimators import Estimate

HEIGHT, WIDTH = 1.4, 9.0
"""Figure height for one joint and figure width for all joints [inch]."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """How well a fit predicts one run; all signals have passed the decimation filter."""

    run: str  # name of the run
    time: np.ndarray  # time of the decimated samples, shape (r,) [s]
    measured: np.ndarray  # torque from currents and drive gains, shape (r, n) [N m]
    predicted: np.ndarray  # torque of the model, shape (r, n) [N m]
    weight: np.ndarray  # 0 where a joint sticks, else 1, shape (r, n)
    noise: np.ndarray  # noise floor of the measured torque, shape (n,) [N m]
    velocity: np.ndarray  # joint velocity, shape (r, n) [rad/s]
    position: np.ndarray | None = None  # joint position, shape (r, n) [rad]; None if it was not stored
    noise_source: str = ""  # how the noise floor was determined; see `Prepared`

    @property
    def residual(self) -> np.ndarray:
        """Measured minus predicted torque, shape (r, n) [N m]."""
        return self.measured - self.predicted

    @property
    def residual_rms(self) -> np.ndarray:
        """Root mean square of the residual while the joint slides, shape (n,) [N m]."""
        return np.sqrt(self._mean(self.residual**2))

    @property
    def relative(self) -> np.ndarray:
        """Norm of the residual over norm of the measured torque, shape (n,) [-]; NaN without motion."""
        return _over(self.residual_rms, np.sqrt(self._mean(self.measured**2)))

    @property
    def r_squared(self) -> np.ndarray:
        """Share of the torque's variance explained, shape (n,) [-]."""
        variance = self._mean((self.measured - self._mean(self.measured)) ** 2)
        return 1.0 - _over(self._mean(self.residual**2), variance)

    @property
    def over_noise(self) -> np.ndarray:
        """Residual over the noise floor, shape (n,) [-]; about one where the model is complete.

        NaN for a joint without a motor: its torque is known to be zero and has no noise.
        """
        return _over(self.residual_rms, self.noise)

    def _mean(self, values: np.ndarray) -> np.ndarray:
        return np.sum(values * self.weight, axis=0) / np.maximum(self.weight.sum(axis=0), 1.0)


def _over(numerator: np.ndarray, denominator: np.ndarray) -> np.ndarray:
    """Ratios, shape (n,); NaN for joints that do not move in the run."""
    return np.divide(numerator, denominator, out=np.full(len(denominator), np.nan), where=denominator > 0.0)


@dataclass(frozen=True, eq=False)
class Scores:
    """Scores of one run, used for the fit or held out, without its samples; see `Agreement`.

    Relative residual, R^2 and residual over noise have shape (n,) [-], residual and noise (n,) [N m].
    """

    run: str
    noise_source: str
    relative: np.ndarray
    r_squared: np.ndarray
    residual_rms: np.ndarray
    noise: np.ndarray
    over_noise: np.ndarray
    held_out: bool = False


def agreement(run: Prepared, estimate: Estimate, regressor: np.ndarray, known: np.ndarray) -> Agreement:
    """Compare an estimate with a run, given its regressor (r, n, b) and known torque (r, n)."""
    gain = estimate.gain if run.measures == "current" else np.ones_like(estimate.gain)
    return Agreement(
        run=run.name,
        time=run.decimated_time,
        measured=gain * run.decimated_current,
        predicted=regressor @ estimate.values + known,
        weight=run.weight,
        noise=np.abs(gain) * run.noise,
        velocity=run.decimation.apply(run.motion.velocity),
        position=run.decimation.apply(run.motion.position),
        noise_source=run.noise_source,
    )


def figure(run: Agreement, robot: Robot) -> Any:
    """One axis for each joint, over time [s].

    Raises:
        MissingPackage: matplotlib is not installed.
    """
    pyplot = optional("matplotlib.pyplot", "a plot")
    size = (WIDTH, HEIGHT * robot.dof + 0.9)
    canvas, grid = pyplot.subplots(robot.dof, sharex=True, squeeze=False, figsize=size, layout="constrained")
    axes = grid[:, 0]
    for joint, (axis, unit) in enumerate(zip(axes, robot.units("N m"), strict=True)):
        axis.plot(run.time, run.measured[:, joint], color="0.6", label="measured")
        axis.plot(run.time, run.predicted[:, joint], linewidth=1.0, label="predicted")
        axis.plot(run.time, run.residual[:, joint], linewidth=0.8, label="residual")
        axis.set_ylabel(f"{robot.joints[joint]} [{unit}]")
    canvas.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=3)
    axes[0].set_title(run.run)
    axes[-1].set_xlabel("time [s]")
    pyplot.close(canvas)  # a notebook shows open figures too: with the value of a cell, it would be twice
    return canvas
