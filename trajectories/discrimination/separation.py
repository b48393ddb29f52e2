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

from collections.abc import Callable, Mapping, Sequence
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
    """A model that may be the true one.

    Attributes:
        name: What people call it.
        model: Robot and effects.
        values: What its parameters are if it is true, in the order of `Model.names`, shape (p,).
        precision: How firmly they are held, by priors and data so far: inverse of their covariance, shape
            (p, p). A zero row and column is a free parameter, an infinite diagonal entry a fixed one.
    """

    name: str
    model: Model
    values: np.ndarray
    precision: np.ndarray

    def __post_init__(self) -> None:
        count = len(self.model.names)
        if self.values.shape != (count,) or self.precision.shape != (count, count):
            raise NotComparable(
                f"hypothesis {self.name}: values {self.values.shape} and precision {self.precision.shape} "
                f"for the {count} parameters of its model"
            )
        if not np.all(np.isfinite(self.values)) or np.any(np.isnan(self.precision)):
            raise NotComparable(f"hypothesis {self.name}: values or precision hold NaN")

    @classmethod
    def of_priors(
        cls,
        name: str,
        model: Model,
        values: Mapping[str, float] | None = None,
        deviations: Mapping[str, float] | None = None,
    ) -> "Hypothesis":
        """The model's priors, of which none is about two parameters at once.

        Args:
            name: What people call it.
            model: Robot and effects.
            values: Values of parameters by name, where they are not nominal.
            deviations: Standard deviation likewise; zero fixes a parameter, infinity frees it.

        Raises:
            NotComparable: A parameter that the model does not have.
        """
        given, spread = dict(values or {}), dict(deviations or {})
        if unknown := sorted({*given, *spread} - set(model.names)):
            raise NotComparable(
                f"hypothesis {name}: no parameter '{unknown[0]}'. Valid: {', '.join(model.names)}"
            )
        centre = [given.get(n, b.value) for n, b in zip(model.names, model.priors, strict=True)]
        deviation = [spread.get(n, b.std) for n, b in zip(model.names, model.priors, strict=True)]
        with np.errstate(divide="ignore"):
            return cls(name, model, np.array(centre), np.diag(np.array(deviation, float) ** -2.0))

    @property
    def free(self) -> np.ndarray:
        """Which parameters are not fixed, shape (p,), bool."""
        return np.isfinite(np.diag(self.precision))

    def changed(self, change: Callable[[Model], Model]) -> "Hypothesis":
        """The same under a changed model of the same parameters."""
        return replace(self, model=everywhere(self.model, change))


def everywhere(model: Model, change: Callable[[Model], Model]) -> Model:
    """The model changed, and likewise what its effects carry of it, as a drive gain's error does."""
    effects = []
    for effect in model.effects:
        inner = {f.name: getattr(effect, f.name) for f in fields(effect)}
        carried = {name: everywhere(one, change) for name, one in inner.items() if isinstance(one, Model)}
        effects.append(replace(effect, **carried))
    return change(replace(model, effects=tuple(effects)))


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
