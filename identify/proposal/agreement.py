"""Hypotheses' probabilities, and how well positions and efforts agree with a tree of rigid bodies.

The torque of each joint is fitted with all parameters of all bodies free, and friction, on four fifths of a
log, and predicted on the other. So only geometry and units are asked, and no inertia has to be right.
"""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np

from ..arm.motion import Motion
from ..arm.rigid_regressor import rigid_regressor
from ..arm.robot import Robot
from ..preparation.filters import differentiate, low_pass, uniform

Key = TypeVar("Key", bound=Hashable)

DECIDED = 0.95
"""Probability from which on a guess is written down: at most one in twenty of those at the limit is wrong."""
CUTOFF = 5.0
"""Low-pass of positions and efforts [Hz]: arms move below it."""
RATE = 100.0
"""Samples a second that are differentiated [Hz]."""
MOST = 1500
"""Samples that are fitted, at most."""
SLIDES = 0.03
"""Share of a joint's usual speed below which it may stick, so that friction has no sign there."""
HOLDS = 0.01
"""Share of the fastest joint's usual speed below which a joint holds its place: what is left is noise and
the servo's error, which tell nothing of bodies."""
FOLDS = 5
RIDGE = 1e-2
"""Variance of the noise over that of a column: how far parameters that no sample tells apart are held back.
With less, fits to 10 s of an arm predict no other 2 s of it, under any hypothesis."""
LONG = 1000.0
"""Gap, in median steps of time, between two runs."""
LEAST = 1e-3
"""Share of a variance below which no description of an arm is right: less left says nothing more."""
MODEL_ERRORS = 20
"""Independent pieces of an effort, at most. What a description leaves out (cables, gears, friction) depends
on pose and direction: it is the same wherever these return, however long a log is. A hypothesis that leaves a
hundredth less than another is then as good as it, and no certainty comes of many samples."""
FEWEST = 40
"""Samples of a sliding joint that can be fitted and left out in turn."""


@dataclass(frozen=True)
class Guess:
    """One thing that was guessed.

    Attributes:
        what: Is asked.
        value: The likeliest answer.
        probability: Probability of that answer among those that were weighed, given the log and the robot.
        why: What speaks for it.
        option: What a person does where it is wrong or not decided.
    """

    what: str
    value: str
    probability: float
    why: str
    option: str = ""

    @property
    def decided(self) -> bool:
        """Whether it is sure enough to be written down."""
        return self.probability >= DECIDED


def posterior(log_odds: Mapping[Key, float]) -> dict[Key, float]:
    """Probability of each hypothesis, from log of prior times likelihood; the likeliest first."""
    values = np.array(list(log_odds.values()))
    weights = np.exp(values - values.max())
    found = dict(zip(log_odds, weights / weights.sum(), strict=True))
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def log_normal(value: float, middle: float, spread: float) -> float:
    """Log of the density of log(value), normal about log(middle) with standard deviation `spread`."""
    return float(-0.5 * (np.log(value / middle) / spread) ** 2 - np.log(spread * np.sqrt(2 * np.pi)))


class Sampled(NamedTuple):
    """A log, low-passed and thinned out.

    Attributes:
        motion: Motion of the joints.
        effort: Shape (t, n), in the log's unit.
        sliding: Where each joint slides, bool of that shape.
    """

    motion: Motion
    effort: np.ndarray
    sliding: np.ndarray

    def ordered(self, order: Sequence[int], factor: np.ndarray) -> "Sampled":
        """The same with columns in another order (n,), and positions times a factor (n,) thereafter."""
        old, columns = self.motion, list(order)
        moved = (one[:, columns] * factor for one in (old.position, old.velocity, old.acceleration))
        return Sampled(Motion.of(old.time, *moved), self.effort[:, columns], self.sliding[:, columns])


def runs_of(time: np.ndarray) -> list[slice]:
    """Rows of each run of a log, by the long gaps in its time (t,)."""
    steps = np.diff(time)
    ends = [0, *(np.flatnonzero(steps > LONG * np.median(steps)) + 1).tolist(), len(time)]
    return [slice(start, end) for start, end in pairwise(ends)]


def sampled(time: np.ndarray, position: np.ndarray, effort: np.ndarray) -> Sampled:
    """Motion and effort at the same samples; time (t,) [s] increases, the others are (t, n)."""
    rate = min(RATE, 1.0 / float(np.median(np.diff(time))))
    runs, n = runs_of(time), position.shape[1]
    seconds = sum(time[run][-1] - time[run][0] for run in runs)
    step = max(1, int(np.ceil(rate * seconds / MOST)))
    parts = [_smooth(time[run], np.hstack([position[run], effort[run]]), rate, step) for run in runs]
    even, smooth, velocity, acceleration = (np.concatenate(part) for part in zip(*parts, strict=True))
    motion = Motion.of(even, smooth[:, :n], velocity[:, :n], acceleration[:, :n])
    usual = np.percentile(np.abs(motion.velocity), 90, axis=0)
    usual = np.maximum(usual, HOLDS / SLIDES * usual.max())
    return Sampled(motion, smooth[:, n:], np.abs(motion.velocity) > SLIDES * usual)


def _smooth(time: np.ndarray, values: np.ndarray, rate: float, step: int) -> tuple[np.ndarray, ...]:
    """Every `step`-th sample of a run at even times, low-passed: times, values and their two derivatives."""
    even, values = uniform(time, values, rate)
    smooth = low_pass(values, rate, min(CUTOFF, 0.2 * rate))
    end = min(len(even) // 4, int(rate / CUTOFF) + 3)
    inside = slice(end, len(even) - end, step)
    return even[inside], smooth[inside], *(one[inside] for one in differentiate(smooth, rate))


def friction_columns(motion: Motion, joint: int) -> np.ndarray:
    """Rotor inertia, drag and dry friction of a joint, shape (t, 3)."""
    velocity = motion.velocity[:, joint]
    return np.stack([motion.acceleration[:, joint], velocity, np.sign(velocity)], axis=1)


def agreement(robot: Robot, log: Sampled) -> np.ndarray:
    """Share of each effort's variance that a fit does not predict, shape (n,); 1 if nothing is."""
    return left_out(rigid_regressor(robot.kinematics, log.motion), log)


def left_out(rigid: np.ndarray, log: Sampled) -> np.ndarray:
    """The same by columns of the bodies' torque, shape (t, n, p)."""
    return left_in_and_out(rigid, log)[1]


def left_in_and_out(rigid: np.ndarray, log: Sampled) -> tuple[np.ndarray, np.ndarray]:
    """Shares that a fit leaves of samples it was fitted to, and of others, each of shape (n,)."""
    inside, outside = np.array([_left(rigid[:, j], log, j) for j in range(rigid.shape[1])]).T
    return inside, outside


def agreement_odds(log: Sampled, left: np.ndarray) -> float:
    """Log-likelihood of a hypothesis under which `left` (n,) remains."""
    return odds_of(left, pieces(log))


def odds_of(left: np.ndarray, weights: np.ndarray) -> float:
    """The same from the shares left (n,), and how many pieces of each effort are independent (n,)."""
    return float(-0.5 * np.sum(weights * np.log(np.maximum(left, LEAST))))


def pieces(log: Sampled) -> np.ndarray:
    """How many pieces of each effort say something of their own, shape (n,)."""
    return np.array([independent(log.effort[rows, j]) for j, rows in enumerate(log.sliding.T)])


def independent(values: np.ndarray) -> int:
    """Independent pieces of values (t,): as many as they cross their mean, up to `MODEL_ERRORS`."""
    crossings = int(np.sum(np.diff(np.signbit(values - values.mean())))) if len(values) else 1
    return min(max(1, crossings), MODEL_ERRORS)


def _left(rigid: np.ndarray, log: Sampled, joint: int) -> tuple[float, float]:
    rows = np.flatnonzero(log.sliding[:, joint])
    effort = log.effort[rows, joint]
    if len(rows) < FEWEST or np.ptp(effort) == 0.0:
        return 1.0, 1.0
    columns = np.hstack([rigid, friction_columns(log.motion, joint)])[rows]
    size = np.sqrt((columns**2).mean(axis=0))
    columns = np.hstack([columns[:, size > 0] / size[size > 0], np.ones((len(rows), 1))])
    pieces = list(zip(np.array_split(columns, FOLDS), np.array_split(effort, FOLDS), strict=True))
    normal, right = columns.T @ columns, columns.T @ effort
    every = np.linalg.solve(normal + RIDGE * len(rows) * np.eye(len(normal)), right)
    inside, missed = float(((effort - columns @ every) ** 2).sum()), 0.0
    for own, measured in pieces:
        rest = normal - own.T @ own + RIDGE * (len(rows) - len(own)) * np.eye(len(normal))
        values = np.linalg.solve(rest, right - own.T @ measured)
        missed += float(((measured - own @ values) ** 2).sum())
    size = float(((effort - effort.mean()) ** 2).sum())
    return min(1.0, inside / size), min(1.0, missed / size)
