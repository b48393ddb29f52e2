r"""Likelihood of each joint's effort given the described masses: its sign, its unit, and their consistency.

The effort of a joint is :math:`e = (\tau_0 + E c) / g + F f + D d + n`: the torque :math:`\tau_0` of the
described bodies, their errors :math:`E` (one standard deviation per column), the gain :math:`g` [N m per
unit], friction with a mostly positive prior (it brakes), and a discrepancy: torque that depends on position,
direction, speed and the neighbors' motion, as of cables or unusual friction. With
Gaussian priors on c, f and d, the likelihood of any gain and sign has a closed form.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

from ..arm.motion import Motion
from ..arm.rigid_regressor import INERTIAL
from ..arm.robot import Robot
from ..effects import Effect
from ..effects.rigid_body import inertial_parameters, inertial_priors
from ..model import Model
from .samples import Sampled, independent

DRAWN = 0.3
"""Relative error of torque computed from a description's masses: tool, cables, inaccurate drawing."""
TOOL_MASS, TOOL_LEVER = 0.01, 0.1
"""Unstated payload relative to the arm's mass, and its distance relative to the arm's length."""
PAYLOAD_MASS = 0.2
"""Mass of a payload that was not weighed relative to the arm's mass: arms carry 5 to 50 % of their own."""
HEAVY, BALANCED = 300.0, 1.0
"""Mass of an arm [kg] above which a spring or gas cylinder, which no URDF describes, may balance gravity; and
the standard deviation of its torque relative to that of the bodies."""
BRAKES = 0.5
"""Mean and standard deviation of rotor and friction torque relative to the effort: they are rarely negative,
but an undescribed effect can make them appear so."""
OFFSET, UNMODELED = 3.0, 0.1
"""Standard deviations of the offset and of each term of the discrepancy relative to the effort."""
LEAST_NOISE = 0.01
"""Smallest share of an effort's variance that counts as noise: no drawing is more accurate."""
DECADES = np.linspace(-3.0, 3.0, 61)
"""Gains to consider if the unit is unknown, as powers of ten relative to the gain of usual size."""
FELT = 1e-4
"""Effect of an error relative to the largest one, below which it is negligible at any gain."""
FEWEST = 40
"""Minimum number of samples of a sliding joint."""
POSITION_WAVES, DIRECTION_WAVES = 6, 4
"""Number of half waves over a joint's range in torque that depends on position, and in torque that also
changes sign with direction."""


def joint_columns(motion: Motion, joint: int) -> np.ndarray:
    """Terms of a joint alone: rotor, viscous and Coulomb friction, offset, shape (t, 4)."""
    velocity = motion.velocity[:, joint]
    return np.stack([motion.acceleration[:, joint], velocity, np.sign(velocity), np.ones(len(velocity))], 1)


def discrepancy_columns(motion: Motion, joint: int) -> np.ndarray:
    """Torque that depends on a joint's position, direction and speed, and on its neighbors, shape (t, k)."""
    position, velocity = motion.position[:, joint], motion.velocity[:, joint]
    direction = np.sign(velocity)
    share = (position - position.min()) / max(float(np.ptp(position)), 1e-12)
    speed = np.abs(velocity) / max(float(np.abs(velocity).max()), 1e-12)
    columns = [np.cos(np.pi * k * share) for k in range(1, POSITION_WAVES + 1)]
    columns += [direction * np.cos(np.pi * k * share) for k in range(1, DIRECTION_WAVES + 1)]
    columns += [speed, np.sqrt(speed), direction * np.sqrt(speed), direction * speed**2]
    for k in (joint - 1, joint + 1):
        if 0 <= k < motion.position.shape[1]:
            columns += [motion.velocity[:, k], np.sign(motion.velocity[:, k])]
    return np.stack(columns, axis=1)


def described(robot: Robot) -> bool:
    """Whether a description has plausible masses rather than the same number for all links."""
    masses = np.array([inertia.mass for inertia in list(robot.kinematics.inertias)[1:]])
    return robot.body_units.informative and bool(len(masses) == 1 or np.ptp(masses) > 0)


def tool(robot: Robot) -> np.ndarray:
    """Standard deviations of an undescribed tool on the flange, in the order of `INERTIAL`, shape (10,)."""
    return body_spread(robot, TOOL_MASS * sum(body.mass for body in list(robot.kinematics.inertias)[1:]))


def body_spread(robot: Robot, mass: float) -> np.ndarray:
    """Standard deviations of a body of about a mass [kg] on the flange, as in `INERTIAL`, shape (10,)."""
    places = list(robot.kinematics.jointPlacements)[2:]
    lever = TOOL_LEVER * sum(float(np.linalg.norm(place.translation)) for place in places)
    return mass * np.array([lever**2] * 6 + [lever] * 3 + [1.0])


def payload_errors(model: Model, motion: Motion) -> np.ndarray:
    """Torque per standard deviation of each unknown parameter of the payload, shape (t, n, p) [N m]."""
    robot, arm = model.robot, sum(body.mass for body in list(model.robot.kinematics.inertias)[1:])
    errors = [np.zeros((*motion.position.shape, 0))]
    for payload in (model.payloads[name] for name in {motion.payload} & set(model.payloads)):
        known = dict(payload.known)
        spread = body_spread(robot, known.get("M", PAYLOAD_MASS * arm))
        std = [std for name, std in zip(INERTIAL, spread, strict=True) if name not in known]
        errors.append(payload.regressor(robot, motion) * std)
    return np.concatenate(errors, axis=2)


class Masses(NamedTuple):
    """A quality level of the masses in descriptions."""

    probability: float  # probability that a description with different masses has this quality
    errors: float  # standard deviation of the mass errors in units of `DRAWN`
    described: bool  # whether the masses are informative about the torque
    # Standard deviation of the logarithm of a stated gain, including a tool and a common error of all masses.
    spread: float


KINDS = (
    Masses(0.65, 1.0, True, 0.4),  # from a drawing
    Masses(0.25, 3.0, True, 0.8),  # rough, right within a factor of two
    Masses(0.10, 10.0, False, np.inf),  # arbitrary, neither measured nor computed
)
"""Quality levels of masses."""
ANY = KINDS[-1]


class Stated(NamedTuple):
    """Torque that is stated in addition to the arm's bodies, such as that of a balancer or a payload."""

    columns: np.ndarray  # torque per unit of each parameter, shape (t, n, p) [N m / unit]
    torque: np.ndarray  # torque at the stated values, shape (t, n) [N m]
    # Torque per standard deviation of each parameter, 0 if none is stated, and of the payload's, (t, n, q).
    errors: np.ndarray

    @classmethod
    def of(cls, model: Model, motion: Motion) -> "Stated":
        """Stated torque of a model's smooth effects, without links and friction."""
        each: list[tuple[Effect, slice]] = [
            (effect, place)
            for effect, place in zip(model.effects, model.columns, strict=True)
            if effect.smooth and not (effect.guessed or effect.of_links or effect.payload)
        ]
        columns = [effect.regressor(model.robot, motion) for effect, _ in each]
        priors = [prior for _, place in each for prior in model.priors[place]]
        regressor = np.concatenate([np.zeros((*motion.position.shape, 0)), *columns], axis=2)
        std = np.array([prior.std if np.isfinite(prior.std) else 0.0 for prior in priors])
        torque = regressor @ np.array([prior.value for prior in priors]) + model.known_torque(motion)
        errors = np.concatenate([regressor * std, payload_errors(model, motion)], axis=2)
        return cls(regressor, torque, errors)


@dataclass(frozen=True)
class Likelihood:
    """Log-likelihood of one joint's effort as a function of its gain, from sufficient statistics."""

    usual: float  # typical gain for an effort of this size [N m per unit]; NaN without information
    described: bool  # whether the described masses cause any torque
    variance: np.ndarray  # variance of the effort along the directions of mass errors at gain 1, shape (k,)
    effort: np.ndarray  # effort along them, shape (k,)
    friction: np.ndarray  # mean friction along them, shape (k,)
    torque: np.ndarray  # described torque along them, shape (k,)
    outside: np.ndarray  # products of these three orthogonal to them, shape (3, 3)

    @classmethod
    def of(
        cls, effort: np.ndarray, torque: np.ndarray, errors: np.ndarray, free: np.ndarray, noise: float
    ) -> "Likelihood":
        """Likelihood from an effort (t,), described torque (t,) [N m], its errors (t, k), and terms (t, q).

        `noise` is the noise share of the effort's variance. `free` are the joint's terms; the first three
        are rotor and friction.
        """
        std = float(effort.std())
        value = (effort - effort.mean()) / std
        size = np.sqrt((free**2).mean(axis=0))
        terms = np.divide(free, size, out=np.zeros_like(free), where=size > 1e-12)
        mean = BRAKES * terms[:, :3].sum(axis=1)
        spread = np.array([BRAKES] * 3 + [OFFSET] + [UNMODELED] * (terms.shape[1] - 4))
        # The number of independent samples determines the information.
        noise = max(noise, LEAST_NOISE) * len(value) / independent(effort)
        usual = float(np.sqrt(torque.var() + errors.var(axis=0).sum())) / std
        regressor = np.column_stack([value, mean, torque / std, errors / std])
        white = _whitened(regressor / np.sqrt(noise), terms * spread / np.sqrt(noise))
        basis, sizes, _ = np.linalg.svd(white[:, 3:], full_matrices=False)
        basis, sizes = basis[:, sizes > FELT * sizes.max()], sizes[sizes > FELT * sizes.max()]
        along = basis.T @ white[:, :3]
        outside = white[:, :3].T @ white[:, :3] - along.T @ along
        return cls(usual, bool(np.any(torque)), sizes**2, along[:, 0], along[:, 1], along[:, 2], outside)

    def at(self, gains: np.ndarray, sign: float, masses: "Masses | None" = None) -> np.ndarray:
        """Log-likelihood of gains (g,) [N m per unit] with a given sign, up to a constant of the joint."""
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
        """Gains to consider if the unit is unknown, shape (g,) [N m per unit]."""
        return np.asarray(self.usual * 10.0**DECADES)

    @cached_property
    def of_any(self) -> dict[float, float]:
        """Log-likelihood of each sign, averaged over all gains, with arbitrary masses."""
        return {sign: mean_of_logs(self.at(self.gains, sign, ANY)) for sign in (1.0, -1.0)}

    @property
    def known(self) -> bool:
        """Whether the joint's effort is informative."""
        return bool(np.isfinite(self.usual) and self.usual > 0)


NOTHING = Likelihood(np.nan, False, np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((3, 3)))
"""Likelihood of a joint without information."""


def likelihoods(
    model: Model, log: Sampled, rigid: np.ndarray, stated: Stated, noise: np.ndarray
) -> list[Likelihood]:
    """Likelihood of each joint's gain; `rigid` (t, n, 10 n) has the columns of the bodies."""
    robot, each = model.robot, []
    bodies = list(robot.kinematics.inertias)[1:]
    spread = np.array([prior.std for body in bodies for prior in inertial_priors(body, DRAWN).values()])
    spread[-10:] = np.hypot(spread[-10:], tool(robot))
    values = np.concatenate([inertial_parameters(body) for body in bodies]) * described(robot)
    heavy = sum(body.mass for body in bodies) > HEAVY
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
        errors = errors[:, errors.any(axis=0)]
        free = np.hstack([joint_columns(log.motion, j)[rows], discrepancy_columns(log.motion, j)[rows]])
        each.append(Likelihood.of(log.effort[rows, j], torque, errors, free, float(noise[j])))
    return each


def mean_of_logs(logs: np.ndarray) -> float:
    """Logarithm of the mean of numbers with logarithms (g,)."""
    return float(np.logaddexp.reduce(logs) - np.log(len(logs)))


def sliding_rows(log: Sampled, joint: int) -> np.ndarray:
    """Rows in which a joint slides; empty if they are too few or the effort is constant."""
    rows = np.flatnonzero(log.sliding[:, joint])
    return rows if len(rows) >= FEWEST and np.ptp(log.effort[rows, joint]) > 0.0 else rows[:0]


def _whitened(values: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """Values (t, c) whitened under unit noise and terms (t, q) of unit prior variance, in reduced rows."""
    q = terms.shape[1]
    reduced = np.asarray(np.linalg.qr(np.hstack([terms, values]), mode="r"))
    covariance = np.eye(len(reduced)) + reduced[:, :q] @ reduced[:, :q].T
    return np.asarray(solve_triangular(np.linalg.cholesky(covariance), reduced[:, q:], lower=True))
