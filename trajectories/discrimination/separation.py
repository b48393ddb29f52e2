r"""Separation: the difference in chi-squared between a true hypothesis and a rival that explains its torque.

Let A be true: it produces the torque :math:`\tau_A`, observed with noise. A rival B adjusts its parameters to
explain this torque, within its priors. In units of the noise,

.. math:: T_{AB} = \min_\theta \|\tau_A - W_B \theta - k_B\|^2 + (\theta - \theta_B)^T P_B (\theta - \theta_B)

is the mean excess of B's chi-squared over A's: the *separation* of the two. Separations of several runs add
up if B starts each run with the values and the precision after the previous one.

**Probability of choosing right.** Let :math:`r` be B's residual at its values, :math:`X` its regressor and
:math:`n` white noise of variance one. B's chi-squared is the quadratic form of
:math:`Q = I - X (X^T X + P_B)^{-1} X^T = (I + X P_B^{-1} X^T)^{-1}`, so that :math:`T = r^T Q r`. The true
parameters are spread about A's values by A's priors, which gives :math:`r + X_A \varepsilon + n`. B's
chi-squared then exceeds A's by :math:`T + 2 r^T Q (X_A \varepsilon + n)` and a quadratic form in the random
parts alone. The linear term has variance :math:`4 r^T Q (I + X_A P_A^{-1} X_A^T) Q r`, which is 4 T if both
have the same priors for shared parameters. Without the quadratic form, choosing the model with the smaller
chi-squared, priors included, is right with probability :math:`\Phi(\sqrt{T} / 2)`, and more often if the
true parameters are nominal. The mean of the quadratic form is zero if every free parameter, which fits one
unit of noise, is penalized by one.

The quadratic form vanishes as the regressor columns that only one of the models has become alike, which is
the case for pairs that data leave open. For one such column each, at an angle :math:`\alpha`, the probability
is exactly :math:`\Phi(a) \Phi(b) + \Phi(-a) \Phi(-b)` with :math:`\sqrt{T} = 2 b \sin(\alpha / 2)` and
:math:`a = b \tan(\alpha / 2)`. For columns at a right angle, :math:`\Phi(\sqrt{T} / 2)` is too high by at
most 0.065, at T = 0.5, and too low beyond T = 3.1, where the exact value for 95 % is 98 %.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.special import ndtr, ndtri

from exidyn.identification.arm.motion import Motion
from exidyn.identification.model import Model

from ..errors import NotComparable
from ..search.experiment import loaded_runs, whitening


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A model that may be the true one."""

    name: str  # name in messages
    model: Model  # robot and effects
    # Parameter values if the hypothesis is true, in the order of `Model.names`, shape (p,).
    values: np.ndarray
    # Inverse covariance of the parameters from priors and data so far, shape (p, p). A zero row and column is
    # a free parameter, an infinite diagonal entry a fixed one.
    precision: np.ndarray

    def __post_init__(self) -> None:
        count = len(self.model.names)
        if self.values.shape != (count,) or self.precision.shape != (count, count):
            raise NotComparable(
                f"hypothesis {self.name}: values {self.values.shape} and precision {self.precision.shape} "
                f"for the {count} parameters of its model"
            )
        if not np.all(np.isfinite(self.values)) or np.any(np.isnan(self.precision)):
            raise NotComparable(f"hypothesis {self.name}: values or precision contain NaN")

    @classmethod
    def of_priors(cls, name: str, model: Model) -> "Hypothesis":
        """Hypothesis with the independent priors of the model's parameters.

        A standard deviation of zero fixes a parameter, infinity frees it.
        """
        std = np.array([prior.std for prior in model.priors], float)
        with np.errstate(divide="ignore"):
            return cls(name, model, model.nominal_values, np.diag(std**-2.0))

    @property
    def free(self) -> np.ndarray:
        """Which parameters are not fixed, shape (p,), bool."""
        return np.isfinite(np.diag(self.precision))

    def changed(self, change: Callable[[Model], Model]) -> "Hypothesis":
        """This hypothesis with a changed model of the same parameters."""
        return replace(self, model=everywhere(self.model, change))


def everywhere(model: Model, change: Callable[[Model], Model]) -> Model:
    """The changed model; models inside its effects, such as in a drive gain's error, are changed too."""
    effects = []
    for effect in model.effects:
        inner = {f.name: getattr(effect, f.name) for f in fields(effect)}
        carried = {
            name: everywhere(value, change) for name, value in inner.items() if isinstance(value, Model)
        }
        effects.append(replace(effect, **carried))
    return change(replace(model, effects=tuple(effects)))


UNSEEN = 1e-12
"""Share of the largest eigenvalue, with columns scaled to one, below which neither data nor priors contain
information on a direction: rounding of the sums of products leaves 1e-14."""


def probability(separation: float) -> float:
    """Probability of choosing the right one of two models [-]: one half at separation zero."""
    return float(ndtr(0.5 * np.sqrt(max(separation, 0.0))))


def separation_for(wanted: float) -> float:
    """Inverse of `probability`: 10.8 for 95 %."""
    return float((2.0 * ndtri(wanted)) ** 2)


@dataclass(frozen=True, eq=False)
class Observation:
    """How precisely torque is observed in one run of a motion."""

    noise: np.ndarray  # standard deviation of each drive's torque in an independent row, shape (n,) [N m]
    rows: float  # number of independent rows of a run: duration times twice the bandwidth of the noise
    payloads: Sequence[str] = ("",)  # payload in each run of the same motion; empty for none

    def seen(self, hypothesis: Hypothesis, motion: Motion) -> "Seen":
        """Prediction of the hypothesis for all k runs."""
        model, white = hypothesis.model, whitening(hypothesis.model, self.noise)
        runs = loaded_runs(model, motion, self.payloads)
        columns = white @ np.concatenate([model.regressor(run) for run in runs])
        known = np.concatenate([model.known_torque(run) for run in runs]) @ white.T
        return Seen(columns, columns @ hypothesis.values + known)


class Seen(NamedTuple):
    """Prediction in units of the noise."""

    columns: np.ndarray  # regressor, shape (k t, n, p)
    torque: np.ndarray  # torque at the values of the hypothesis, shape (k t, n)


class Explanation(NamedTuple):
    """How a hypothesis explains the torque of another."""

    separation: float  # remaining chi-squared
    residual: np.ndarray  # residual torque in units of the noise, shape (k t, n)
    hypothesis: Hypothesis  # the hypothesis with its values and precision after the run


def explain(rival: Hypothesis, seen: Seen, torque: np.ndarray, share: float | np.ndarray) -> Explanation:
    """The rival's best explanation of torque, shape (k t, n), in units of the noise, as `seen` by the rival.

    `share` is the number of independent rows per sample, a scalar or shape (k t,).
    """
    free, weight = rival.free, np.broadcast_to(np.asarray(share, float), len(torque))
    unexplained = torque - seen.torque
    columns = seen.columns[:, :, free]
    flat = (unexplained.size, columns.shape[2])  # explicit, since there may be no column
    weighed = (columns * weight[:, None, None]).reshape(flat)
    information = weighed.T @ columns.reshape(flat)
    held = rival.precision[np.ix_(free, free)]
    move = _solution(information + held, weighed.T @ unexplained.ravel())
    residual = unexplained - columns @ move
    # Not as the difference of two large sums: in this form an error of the move enters by its square.
    separation = float(weight @ np.sum(residual**2, axis=1) + move @ held @ move)
    values, precision = rival.values.copy(), rival.precision.copy()
    values[free] += move
    precision[np.ix_(free, free)] += information
    return Explanation(separation, residual, replace(rival, values=values, precision=precision))


def _solution(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Minimum-norm solution of a positive semidefinite system, with unknowns scaled to a unit diagonal."""
    diagonal = np.diag(matrix)
    scale = np.where(diagonal > 0, 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0)), 0.0)
    if len(scale) == 0:
        return right
    values, vectors = eigh(matrix * np.outer(scale, scale))
    inverse = np.where(values > UNSEEN * values[-1], 1.0 / np.where(values > 0, values, 1.0), 0.0)
    return np.asarray(scale * (vectors @ (inverse * (vectors.T @ (scale * right)))))
