"""The bodies of a description: the torque they need, how wrong that may be, how well it explains efforts."""

from typing import NamedTuple

import numpy as np

from ..arm.motion import Motion
from ..arm.rigid_regressor import rigid_regressor
from ..arm.robot import Robot
from ..effects import Effect
from ..effects.rigid_body import inertial_parameters, inertial_priors
from ..model import Model
from .agreement import FEWEST, Sampled, friction_columns

DRAWN = 0.3
"""Relative error of the torque that a description's masses give: a tool, cables, a drawing."""
PLACEHOLDER = 0.1
"""Probability that the masses of a description are numbers that nobody measured or computed."""
TEN_TIMES = 10.0
"""Standard deviation of such masses, over that of a drawing's: three times the number that stands there."""
TOOL_MASS, TOOL_LEVER = 0.05, 0.1
"""What an arm carries unsaid, over its own mass; and how far out, over its own length."""
HEAVY, BALANCED = 300.0, 1.0
"""Mass of an arm [kg] from which on a spring or gas cylinder may hold it against gravity, which no URDF has;
and its torque over that of the bodies, standard deviation."""
WIDE = 3.0
"""Standard deviation of what friction may be, over the effort's own."""
DECADES = np.linspace(-3.0, 3.0, 121)
"""Gains that are weighed where nothing is known of the unit, as powers of ten about the described torque and
what may be wrong of it over the effort, as standard deviations: the gain of a drive that carries nothing but
the described bodies. A gain a thousand times as far is that of another arm."""


class Bodies(NamedTuple):
    """What a description says of one joint's torque.

    Attributes:
        torque: Shape (t,) [N m].
        errors: Torque of one standard deviation of each thing that may differ, shape (t, k) [N m].
        friction: Inertia of the rotor, drag and dry friction, each of size 1, shape (t, 3).
    """

    torque: np.ndarray
    errors: np.ndarray
    friction: np.ndarray

    def at(self, rows: np.ndarray) -> "Bodies":
        """At some samples."""
        return Bodies(self.torque[rows], self.errors[rows], self.friction[rows])

    def gains(self, effort: np.ndarray) -> np.ndarray:
        """Gains to weigh for an effort (t,), by the likely size of the torque, shape (g,) [N m per unit]."""
        usual = np.sqrt(self.torque.var() + np.sum(self.errors.var(axis=0)))
        return np.asarray(usual / effort.std() * 10.0**DECADES)

    @property
    def of_any_mass(self) -> "Bodies":
        """The same bodies where the described masses say nothing."""
        return self._replace(torque=0.0 * self.torque, errors=TEN_TIMES * self.errors)


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
            (effect, own)
            for effect, own in zip(model.effects, model.columns, strict=True)
            if effect.smooth and not (effect.guessed or effect.of_links)
        ]
        columns = [effect.regressor(model.robot, motion) for effect, _ in each]
        priors = [prior for _, own in each for prior in model.priors[own]]
        every = np.concatenate([np.zeros((*motion.position.shape, 0)), *columns], axis=2)
        std = np.array([prior.std if np.isfinite(prior.std) else 0.0 for prior in priors])
        return cls(every, every @ np.array([prior.value for prior in priors]), every * std)


def bodies_of(
    robot: Robot, log: Sampled, rigid: np.ndarray | None = None, stated: Stated | None = None
) -> list[Bodies]:
    """What is described of each joint's torque, by columns of the bodies (t, n, 10 n) or the log's motion.

    Bodies are as described but for `DRAWN`, a tool and a balancer; `stated` comes on top of them.
    """
    if rigid is None:
        rigid = rigid_regressor(robot.kinematics, log.motion)
    bodies = list(robot.kinematics.inertias)[1:]
    spread = np.array([prior.std for body in bodies for prior in inertial_priors(body, DRAWN).values()])
    spread[-10:] = np.hypot(spread[-10:], tool(robot))
    heavy, values, each = sum(body.mass for body in bodies) > HEAVY, described_values(robot), []
    for j in range(robot.dof):
        torque, errors = rigid[:, j] @ values, rigid[:, j] * spread
        if heavy:
            angle = log.motion.position[:, j]
            balancer = BALANCED * torque.std() * np.stack([np.sin(angle), np.cos(angle)], axis=1)
            errors = np.hstack([errors, balancer])
        if stated is not None:
            torque, errors = torque + stated.torque[:, j], np.hstack([errors, stated.errors[:, j]])
        each.append(Bodies(torque, errors, friction_columns(log.motion, j)))
    return each


def sliding_rows(log: Sampled, joint: int) -> np.ndarray:
    """Samples by which a joint's effort is explained; none where they are too few or it stands still."""
    rows = np.flatnonzero(log.sliding[:, joint])
    return rows if len(rows) >= FEWEST and np.ptp(log.effort[rows, joint]) > 0.0 else rows[:0]


def log_likelihood(effort: np.ndarray, bodies: Bodies, noise: float, gains: np.ndarray) -> np.ndarray:
    """Log-likelihood of each gain (g,) [N m per unit], up to a constant.

    Effort = torque of the bodies / gain + friction + offset, these of either sign and of any size up to
    `WIDE`; effort has shape (t,), `noise` is the variance of a sample, as if samples were independent.
    """
    free = np.column_stack([bodies.friction, np.ones(len(effort))])
    free *= WIDE * effort.std() / np.maximum(np.sqrt((free**2).mean(axis=0)), 1e-12)
    every = np.column_stack([bodies.errors, free, bodies.torque, effort])
    reduced, k = np.asarray(np.linalg.qr(every, mode="r")), bodies.errors.shape[1]
    errors, wide = reduced[:, :k] @ reduced[:, :k].T, reduced[:, k:-2] @ reduced[:, k:-2].T
    likely = []
    for gain in gains:
        covariance = noise * np.eye(len(reduced)) + wide + errors / gain**2
        miss = reduced[:, -1] - reduced[:, -2] / gain
        _, size = np.linalg.slogdet(covariance)
        likely.append(-0.5 * (size + miss @ np.linalg.solve(covariance, miss)))
    return np.array(likely)
