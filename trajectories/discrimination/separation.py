r"""Separation: how far a hypothesis stays from explaining what another one does.

Let A be true: it makes the torque :math:`\tau_A`, seen with noise. A rival B moves its parameters to
explain it, as far as what is known of them lets it. With everything in units of the noise,

.. math:: T_{AB} = \min_\theta \|\tau_A - W_B \theta - k_B\|^2 + (\theta - \theta_B)^T P_B (\theta - \theta_B)

is by how much B's chi-squared ends above A's on average: the *separation* of the two. Over runs it adds
up if B starts each with the values and the precision that the one before left it with.

**Probability of choosing right.** Let :math:`r` be B's residual at its values, :math:`X` its columns and
:math:`n` white noise of variance one. B's misfit is the quadratic form of
:math:`Q = I - X (X^T X + P_B)^{-1} X^T = (I + X P_B^{-1} X^T)^{-1}`, so that :math:`T = r^T Q r`. The
truth is spread about A's values by A's priors, and gives :math:`r + X_A \varepsilon + n`. B's
chi-squared is then above A's by :math:`T + 2 r^T Q (X_A \varepsilon + n)` and a form in the random parts
alone. The linear term has variance :math:`4 r^T Q (I + X_A P_A^{-1} X_A^T) Q r`, which is 4 T where both
hold the same priors of what they share. Without the form, who takes the model with the smaller
chi-squared, priors included, is right with probability :math:`\Phi(\sqrt{T} / 2)`; more often if the
truth happens to be nominal. Its mean is zero once every free parameter, which fits away one unit
of noise, is charged one.

The form vanishes as the columns that only one of them has come to look alike, which is what pairs that
data leave open do. For one such column each, at an angle :math:`\alpha`, the probability is exactly
:math:`\Phi(a) \Phi(b) + \Phi(-a) \Phi(-b)` with :math:`\sqrt{T} = 2 b \sin(\alpha / 2)` and
:math:`a = b \tan(\alpha / 2)`: for columns at a right angle :math:`\Phi(\sqrt{T} / 2)` is at worst 0.065
too high, at T = 0.5, and too low beyond T = 3.1, where 95 per cent is in truth 98.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh
from scipy.special import ndtr, ndtri

from exidyn.identify.arm.motion import Motion

from ..search.information.experiment import loaded_runs, whitening
from .hypothesis import Hypothesis

UNSEEN = 1e-12
"""Share of the largest eigenvalue, columns scaled to one, below which neither data nor priors contain
anything of a direction: rounding of the sums of products leaves 1e-14."""


def probability(separation: float) -> float:
    """Probability of choosing the right one of two models [-]: one half at separation zero."""
    return float(ndtr(0.5 * np.sqrt(max(separation, 0.0))))


def separation_for(wanted: float) -> float:
    """Inverse of `probability`: 10.8 for 95 per cent."""
    return float((2.0 * ndtri(wanted)) ** 2)


@dataclass(frozen=True, eq=False)
class Observation:
    """How well torque is seen in one run of a motion.

    Attributes:
        noise: Standard deviation of each drive's torque in an independent row, shape (n,) [N m].
        rows: Independent rows of a run: seconds times twice the bandwidth of the noise.
        payloads: Body carried in each run of the same motion; empty for none.
    """

    noise: np.ndarray
    rows: float
    payloads: Sequence[str] = ("",)

    def seen(self, hypothesis: Hypothesis, motion: Motion) -> "Seen":
        """What the hypothesis predicts of all k runs."""
        model, white = hypothesis.model, whitening(hypothesis.model, self.noise)
        runs = loaded_runs(model, motion, self.payloads)
        columns = white @ np.concatenate([model.regressor(run) for run in runs])
        known = np.concatenate([model.known_torque(run) for run in runs]) @ white.T
        return Seen(columns, columns @ hypothesis.values + known)


class Seen(NamedTuple):
    """Prediction in units of the noise.

    Attributes:
        columns: By each parameter, shape (k t, n, p).
        torque: At the hypothesis' values, shape (k t, n).
    """

    columns: np.ndarray
    torque: np.ndarray


class Explanation(NamedTuple):
    """How a hypothesis explains torque that is not its own.

    Attributes:
        separation: What remains, as chi-squared.
        residual: Torque that remains, in units of the noise, shape (k t, n).
        hypothesis: With the values and the precision that it has after the run.
    """

    separation: float
    residual: np.ndarray
    hypothesis: Hypothesis


def explain(rival: Hypothesis, seen: Seen, torque: np.ndarray, share: float | np.ndarray) -> Explanation:
    """The rival's best explanation of torque, shape (k t, n), in units of the noise.

    Args:
        rival: Who explains.
        seen: What it predicts.
        torque: What it has to explain.
        share: Independent rows that a sample stands for, one for all or shape (k t,).
    """
    free, weight = rival.free, np.broadcast_to(np.asarray(share, float), len(torque))
    left = torque - seen.torque
    columns = seen.columns[:, :, free]
    flat = (left.size, columns.shape[2])  # given, since no column may be left
    weighed = (columns * weight[:, None, None]).reshape(flat)
    information = weighed.T @ columns.reshape(flat)
    held = rival.precision[np.ix_(free, free)]
    move = _solution(information + held, weighed.T @ left.ravel())
    residual = left - columns @ move
    # Not the difference of two large sums: in this form an error of the move counts by its square.
    separation = float(weight @ np.sum(residual**2, axis=1) + move @ held @ move)
    values, precision = rival.values.copy(), rival.precision.copy()
    values[free] += move
    precision[np.ix_(free, free)] += information
    return Explanation(separation, residual, replace(rival, values=values, precision=precision))


def _solution(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Smallest solution of a positive semidefinite system, unknowns in units that make its diagonal one."""
    diagonal = np.diag(matrix)
    scale = np.where(diagonal > 0, 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0)), 0.0)
    if len(scale) == 0:
        return right
    values, vectors = eigh(matrix * np.outer(scale, scale))
    inverse = np.where(values > UNSEEN * values[-1], 1.0 / np.where(values > 0, values, 1.0), 0.0)
    return np.asarray(scale * (vectors @ (inverse * (vectors.T @ (scale * right)))))


def separation(true: Hypothesis, rival: Hypothesis, motion: Motion, observation: Observation) -> Explanation:
    """How the rival explains a run in which another hypothesis is true."""
    seen, share = observation.seen(rival, motion), observation.rows / len(motion)
    return explain(rival, seen, observation.seen(true, motion).torque, share)
