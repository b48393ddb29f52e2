r"""What the masses of a description say of each joint's effort: its sign, its unit, and whether they hold.

The effort of a joint is :math:`e = (\tau_0 + E c) / g + F f + D d + n`: the torque :math:`\tau_0` of the
described bodies, errors :math:`E` of one standard deviation each, the gain :math:`g` [N m per unit], friction
with a prior of mostly positive size (it brakes), and the discrepancy of `block_prediction`. With Gaussian
priors on c, f and d the likelihood of any gain and sign is closed-form.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ..arm.motion import Motion
from ..arm.robot import Robot
from ..effects import Effect
from ..effects.rigid_body import inertial_parameters, inertial_priors
from ..model import Model
from .block_prediction import discrepancy_columns, friction_columns
from .samples import Sampled, independent

DRAWN = 0.3
"""Relative error of the torque that a description's masses give: a tool, cables, a drawing."""
TOOL_MASS, TOOL_LEVER = 0.01, 0.1
"""What an arm carries unsaid, over its own mass; and how far out, over its own length."""
HEAVY, BALANCED = 300.0, 1.0
"""Mass of an arm [kg] from which on a spring or gas cylinder may hold it against gravity, which no URDF has;
and its torque over that of the bodies, standard deviation."""
BRAKES = 0.5
"""Mean and standard deviation of rotor and friction torque over the effort's own: they are rarely negative,
and an effect that no description has can make them look so."""
OFFSET, UNMODELED = 3.0, 0.1
"""Standard deviations of the offset and of each term of the discrepancy over the effort's own."""
LEAST_NOISE = 0.01
"""Least share of an effort's variance that counts as noise: no drawing explains more."""
DECADES = np.linspace(-3.0, 3.0, 61)
"""Gains that are weighed where no unit is known, as powers of ten about the gain of usual size."""
FELT = 1e-4
"""Size of an error's effect over the largest, below which no gain makes it felt."""
FEWEST = 40
"""Samples of a sliding joint that can be explained."""


def described(robot: Robot) -> bool:
    """Whether the masses of a description are a drawing's, and not one number for all."""
    masses = np.array([inertia.mass for inertia in list(robot.kinematics.inertias)[1:]])
    return bool(masses.sum() > 0 and (len(masses) == 1 or np.ptp(masses) > 0))


def described_values(robot: Robot) -> np.ndarray:
    """Inertial parameters of all links as described, shape (10 n,); zero where masses are one number."""
    values = [inertial_parameters(body) for body in list(robot.kinematics.inertias)[1:]]
    return np.concatenate(values) * described(robot)


def tool(robot: Robot) -> np.ndarray:
    """Standard deviations of what the flange may carry and no description has, in order of `INERTIAL`."""
    bodies, places = list(robot.kinematics.inertias)[1:], list(robot.kinematics.jointPlacements)[2:]
    mass = TOOL_MASS * sum(body.mass for body in bodies)
    lever = TOOL_LEVER * sum(float(np.linalg.norm(place.translation)) for place in places)
    return mass * np.array([lever**2] * 6 + [lever] * 3 + [1.0])


class Masses(NamedTuple):
    """A kind of masses that descriptions have.

    Attributes:
        probability: That a description with different masses has this kind.
        errors: Standard deviation of its masses over `DRAWN`.
        described: Whether the masses say anything of the torque.
        spread: Standard deviation of the logarithm of a stated gain, a tool and errors of all masses alike.
    """

    probability: float
    errors: float
    described: bool
    spread: float


KINDS = (
    Masses(0.65, 1.0, True, 0.4),  # a drawing's
    Masses(0.25, 3.0, True, 0.8),  # rough ones, right to a factor of two
    Masses(0.10, 10.0, False, np.inf),  # numbers that nobody measured or computed, three times as large
)
"""Kinds of masses."""
ANY = KINDS[-1]


class Stated(NamedTuple):
    """Torque that a description states beside that of its bodies, such as a spring balancer's.

    Attributes:
        columns: Torque per unit of each parameter, shape (t, n, p) [N m / unit].
        torque: By the values stated, shape (t, n) [N m].
        errors: Of one standard deviation of each parameter, shape (t, n, p) [N m]; 0 where none is stated.
    """

    columns: np.ndarray
    torque: np.ndarray
    errors: np.ndarray

    @classmethod
    def of(cls, model: Model, motion: Motion) -> "Stated":
        """Of a model's effects other than its links, friction and what is as abrupt as that."""
        each: list[tuple[Effect, slice]] = [
            (effect, place)
            for effect, place in zip(model.effects, model.columns, strict=True)
            if effect.smooth and not (effect.guessed or effect.of_links)
        ]
        columns = [effect.regressor(model.robot, motion) for effect, _ in each]
        priors = [prior for _, place in each for prior in model.priors[place]]
        every = np.concatenate([np.zeros((*motion.position.shape, 0)), *columns], axis=2)
        std = np.array([prior.std if np.isfinite(prior.std) else 0.0 for prior in priors])
        return cls(every, every @ np.array([prior.value for prior in priors]), every * std)


@dataclass(frozen=True)
class Likelihood:
    """Log-likelihood of one joint's effort by its gain, from sufficient statistics.

    Attributes:
        usual: Gain that an effort of this size usually has [N m per unit]; NaN where nothing is told.
        described: Whether the described masses need any torque.
        variance: Variance of the effort along directions that the bodies' errors move, at gain 1, (k,).
        effort, friction, torque: Effort, mean friction and described torque along these, shape (k,).
        outside: Products of effort, mean friction and described torque apart from these, shape (3, 3).
    """

    usual: float
    described: bool
    variance: np.ndarray
    effort: np.ndarray
    friction: np.ndarray
    torque: np.ndarray
    outside: np.ndarray

    @classmethod
    def of(
        cls, effort: np.ndarray, torque: np.ndarray, errors: np.ndarray, free: np.ndarray, noise: float
    ) -> "Likelihood":
        """From an effort (t,), the described torque (t,) [N m], its errors (t, k) and own terms (t, q).

        `noise` is the share of the effort's variance that is noise. Of the own terms the first three are
        rotor and friction.
        """
        std = float(effort.std())
        value = (effort - effort.mean()) / std
        size = np.sqrt((free**2).mean(axis=0))
        terms = np.divide(free, size, out=np.zeros_like(free), where=size > 1e-12)
        mean = BRAKES * terms[:, :3].sum(axis=1)
        spread = np.array([BRAKES] * 3 + [OFFSET] + [UNMODELED] * (terms.shape[1] - 4))
        # Samples say as much as that many independent ones.
        noise = max(noise, LEAST_NOISE) * len(value) / independent(effort)
        usual = float(np.sqrt(torque.var() + errors.var(axis=0).sum())) / std
        every = np.column_stack([value, mean, torque / std, errors / std])
        white = _whitened(every / np.sqrt(noise), terms * spread / np.sqrt(noise))
        basis, sizes, _ = np.linalg.svd(white[:, 3:], full_matrices=False)
        basis, sizes = basis[:, sizes > FELT * sizes.max()], sizes[sizes > FELT * sizes.max()]
        along = basis.T @ white[:, :3]
        outside = white[:, :3].T @ white[:, :3] - along.T @ along
        return cls(usual, bool(np.any(torque)), sizes**2, along[:, 0], along[:, 1], along[:, 2], outside)

    def at(self, gains: np.ndarray, sign: float, masses: "Masses | None" = None) -> np.ndarray:
        """Log-likelihood of gains (g,) [N m per unit] of a sign, up to a constant of the joint."""
        kind = masses or KINDS[0]
        inverse = 1.0 / np.asarray(gains)
        share = inverse[:, None] ** 2 * self.variance * kind.errors**2
        drawn = inverse * kind.described
        weights = np.stack([np.full_like(inverse, sign), -np.ones_like(inverse), -drawn])
        miss = np.einsum("cg,ck->gk", weights, np.stack([self.effort, self.friction, self.torque]))
        outside = np.einsum("ag,ab,bg->g", weights, self.outside, weights)
        return np.asarray(-0.5 * (outside + np.sum(miss**2 / (1 + share) + np.log1p(share), axis=1)))

    @cached_property
    def gains(self) -> np.ndarray:
        """Gains to weigh where the unit is not known, shape (g,) [N m per unit]."""
        return np.asarray(self.usual * 10.0**DECADES)

    @cached_property
    def of_any(self) -> dict[float, float]:
        """Log-likelihood by any masses and gain, of each sign."""
        return {sign: mean_of_logs(self.at(self.gains, sign, ANY)) for sign in (1.0, -1.0)}

    @property
    def known(self) -> bool:
        """Whether the joint's effort says anything."""
        return bool(np.isfinite(self.usual) and self.usual > 0)


NOTHING = Likelihood(np.nan, False, np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((3, 3)))
"""Of a joint that tells nothing."""


def likelihoods(
    model: Model, log: Sampled, rigid: np.ndarray, stated: Stated, noise: np.ndarray
) -> list[Likelihood]:
    """Likelihood of each joint's gain; `rigid` (t, n, 10 n) are the columns of the bodies."""
    robot, each = model.robot, []
    bodies = list(robot.kinematics.inertias)[1:]
    spread = np.array([prior.std for body in bodies for prior in inertial_priors(body, DRAWN).values()])
    spread[-10:] = np.hypot(spread[-10:], tool(robot))
    values, heavy = described_values(robot), sum(body.mass for body in bodies) > HEAVY
    for j in range(robot.dof):
        rows = sliding_rows(log, j)
        if not len(rows):
            each.append(NOTHING)
            continue
        torque = rigid[rows, j] @ values
        torque = torque + stated.torque[rows, j] * bool(np.any(torque))
        errors = np.hstack([rigid[rows, j] * spread, stated.errors[rows, j]])
        if heavy:
            angle = log.motion.position[rows, j]
            balancer = BALANCED * torque.std() * np.stack([np.sin(angle), np.cos(angle)], axis=1)
            errors = np.hstack([errors, balancer])
        motion = log.motion
        free = [friction_columns(motion, j), np.ones((len(motion), 1)), discrepancy_columns(motion, j)]
        errors = errors[:, errors.any(axis=0)]
        each.append(
            Likelihood.of(log.effort[rows, j], torque, errors, np.hstack(free)[rows], float(noise[j]))
        )
    return each


def mean_of_logs(logs: np.ndarray) -> float:
    """Logarithm of the mean of numbers whose logarithms are (g,)."""
    return float(np.logaddexp.reduce(logs) - np.log(len(logs)))


def sliding_rows(log: Sampled, joint: int) -> np.ndarray:
    """Samples by which a joint's effort is explained; none where they are too few or it stands still."""
    rows = np.flatnonzero(log.sliding[:, joint])
    return rows if len(rows) >= FEWEST and np.ptp(log.effort[rows, joint]) > 0.0 else rows[:0]


def _whitened(values: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """Values (t, c), reduced to their span, under unit noise and terms (t, q) of unit prior variance."""
    q = terms.shape[1]
    reduced = np.asarray(np.linalg.qr(np.hstack([terms, values]), mode="r"))
    covariance = np.eye(len(reduced)) + reduced[:, :q] @ reduced[:, :q].T
    return np.asarray(solve_triangular(np.linalg.cholesky(covariance), reduced[:, q:], lower=True))
