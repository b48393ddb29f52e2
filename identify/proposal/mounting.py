"""Where gravity points in the base frame: as described, or otherwise, as of an arm on a wall or a ceiling.

Bodies whose masses are free explain the efforts about as well under gravity of the opposite direction. So a
direction is looked for up to its sign, and the sign is asked of the described masses and of friction, which
brakes whichever way the arm is mounted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from scipy import optimize

from ..arm.rigid_regressor import rigid_regressor
from ..arm.robot import Robot
from .agreement import DECIDED, Guess, Sampled, agreement_odds, independent, left_in_and_out, left_out
from .described_bodies import (
    PLACEHOLDER,
    Bodies,
    bodies_of,
    described_values,
    log_likelihood,
    sliding_rows,
)
from .drives import agreed, braking_odds

GRAVITY = "direction of gravity"
"""What a guess of the mounting asks."""
OTHERWISE = 0.02
"""Probability that an arm stands far from how its description has it."""
DIRECTIONS = 10_000
"""Directions that are distinguished beforehand, a degree apart."""
EVALUATIONS = 60
"""Directions that are tried from the best start: to a tenth of a degree."""
STEP = 0.2
"""First step of that search [rad]."""

Direction = tuple[float, float, float]
"""A unit vector in the base frame."""


def described_direction(robot: Robot) -> Direction | None:
    """Where the description has gravity; None without gravity."""
    size = float(np.linalg.norm(robot.gravity))
    return _direction(robot.gravity) if size > 0 else None


def under(robot: Robot, direction: Sequence[float] | np.ndarray) -> Robot:
    """The robot with gravity along a direction of its base frame."""
    kinematics = robot.kinematics.copy()
    kinematics.gravity = pin.Motion(np.linalg.norm(robot.gravity) * np.asarray(direction), np.zeros(3))
    return replace(robot, kinematics=kinematics)


def found_direction(robot: Robot, log: Sampled) -> Direction | None:
    """Direction under which bodies, of any mass and as described, explain a log best.

    None where the described one does better than each of those 45 degrees apart: a base that leans by less
    than half of that is left to the diagnosis.
    """
    described = described_direction(robot)
    if described is None:
        return None
    fields, values = Fields.of(robot, log), described_values(robot)

    def odds(direction: np.ndarray, signs: Sequence[int] = (1,)) -> float:
        rigid = fields.along(direction)
        of_described = max(agreed(fields.along(sign * direction) @ values, log) for sign in signs)
        return agreement_odds(log, left_out(rigid, log)) + of_described

    frame = _frame(np.array(described))
    others = [unit(frame @ np.array(one)) for one in product((0, 1, -1), repeat=3) if _one_of_two(one)]
    start = max(others, key=lambda one: odds(one, (1, -1)))
    if odds(start, (1, -1)) <= odds(np.array(described)):
        return None
    start = max((start, -start), key=odds)
    across = _frame(start)[:, 1:]

    def loss(lean: np.ndarray) -> float:
        return -odds(unit(start + across @ lean))

    simplex = STEP * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    options = {"maxfev": EVALUATIONS, "initial_simplex": simplex, "xatol": 1e-3, "fatol": 0.01}
    best = optimize.minimize(loss, np.zeros(2), method="Nelder-Mead", options=options)
    return _direction(start + across @ best.x)


def right_way(robot: Robot, direction: Direction, log: Sampled) -> float:
    """Log odds of gravity along a direction over the opposite one, by described masses and friction.

    The masses are those of a drawing, or numbers that say nothing: for all bodies alike.
    """
    fields = Fields.of(robot, log)
    ways = []
    for sign in (1.0, -1.0):
        rigid = fields.along(sign * np.array(direction))
        left, each = left_in_and_out(rigid, log)[0], bodies_of(robot, log, rigid)
        drawn, any_mass = np.sum(
            [_of_masses(bodies, log, j, left[j]) for j, bodies in enumerate(each)], axis=0
        )
        ways.append(np.logaddexp(np.log(1 - PLACEHOLDER) + drawn, np.log(PLACEHOLDER) + any_mass))
    return float(ways[0] - ways[1])


def mounted_robot(
    robot: Robot, directions: Mapping[Direction, float], sample: Sampled
) -> tuple[Robot, list[Guess]]:
    """The robot as it stands, and what is guessed of that, unless it surely is as described.

    Each direction of gravity, up to its sign, has its probability.
    """
    if not directions:
        return robot, []
    likeliest = max(directions, key=lambda one: directions[one])
    as_described = likeliest == described_direction(robot)
    prior = np.log((1 - OTHERWISE) / OTHERWISE) if as_described else 0.0
    way = right_way(robot, likeliest, sample) + prior
    direction = tuple(np.sign(way) * part for part in likeliest)
    probability = directions[likeliest] / (1 + np.exp(-min(abs(way), 99.0)))
    if as_described and way > 0 and probability >= DECIDED:
        return robot, []
    why, option = "bodies, friction", "gravity in robot.toml"
    guess = Guess(GRAVITY, f"{direction_words(direction)} of the base", probability, why, option)
    return (under(robot, direction) if guess.decided else robot), [guess]


def direction_words(direction: Sequence[float]) -> str:
    """A direction as three numbers."""
    return ", ".join(f"{part + 0.0:.2f}" for part in np.round(direction, 2))


class Fields(NamedTuple):
    """Columns (t, n, p) of the bodies' torque without gravity, and what gravity along each axis adds."""

    still: np.ndarray
    each: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, robot: Robot, log: Sampled) -> "Fields":
        """Of the motion of a log."""
        axes = (np.zeros(3), *np.eye(3))
        still, *more = (rigid_regressor(under(robot, axis).kinematics, log.motion) for axis in axes)
        return cls(still, tuple(one - still for one in more))

    def along(self, direction: np.ndarray) -> np.ndarray:
        """Columns under gravity of a direction (3,)."""
        columns = self.still.copy()
        for share, field in zip(direction, self.each, strict=True):
            columns += share * field
        return columns


def _of_masses(bodies: Bodies, log: Sampled, joint: int, left: float) -> tuple[float, float]:
    """Log-likelihood of an effort by bodies as described, and by those of any mass; drives of either sign."""
    rows = sliding_rows(log, joint)
    if not len(rows) or not np.any(bodies.torque[rows]):
        return 0.0, 0.0
    bodies, effort = bodies.at(rows), log.effort[rows, joint]
    noise = max(left, 0.01) * effort.var() * len(rows) / independent(effort)
    gains = bodies.gains(effort)
    brakes = braking_odds(bodies, effort)
    each = []
    for kind in (bodies, bodies.of_any_mass):
        either = [np.logaddexp.reduce(log_likelihood(sign * effort, kind, noise, gains)) for sign in (1, -1)]
        each.append(
            float(np.logaddexp(either[0] - np.logaddexp(0, -brakes), either[1] - np.logaddexp(0, brakes)))
        )
    return each[0], each[1]


def _frame(axis: np.ndarray) -> np.ndarray:
    """Three unit vectors at right angles, as columns; the first along an axis (3,), either way."""
    return np.linalg.qr(np.column_stack([axis, np.eye(3)]))[0]


def unit(vector: Sequence[float] | np.ndarray) -> np.ndarray:
    """The vector of length 1 in that direction."""
    return np.asarray(vector) / np.linalg.norm(vector)


def _direction(vector: np.ndarray) -> Direction:
    x, y, z = unit(vector).tolist()
    return x, y, z


def _one_of_two(one: Sequence[int]) -> bool:
    """Of each two opposite directions the one whose first part that is not 0 is positive; not (1, 0, 0)."""
    return next((part for part in one if part), 0) > 0 and one != (1, 0, 0)
