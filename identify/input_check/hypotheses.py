"""What a person may have got wrong in a log: changes of its samples, weighed by what bodies explain."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..arm.motion import Motion
from ..arm.rigid_regressor import rigid_regressor
from ..arm.robot import Robot
from ..model import Model
from ..proposal.agreement import Sampled, left_in_and_out, odds_of, pieces
from ..proposal.described_bodies import Stated
from ..proposal.mounting import Direction, described_direction, direction_words, found_direction, under
from .coupled import EXPLAINS, Coupled

MISTAKE = 0.03
"""Probability that a log of which nothing else is known has one of the mistakes below."""


UNEXPLAINED = 0.3
"""Share of its variance that bodies leave of an effort, from which on more than friction is wrong."""
UNITS = (
    ("degrees", np.pi / 180, 'state it: --degrees, or [position] unit = "deg" in a preset'),
    ("radians, and taken for degrees", 180 / np.pi, "import without --degrees"),
    ("counts of 12 bits a turn", 2 * np.pi / 2**12, "give the log with positions in radians or degrees"),
)
"""Units of positions that are taken for others: name, radians a unit of what is stated, cure."""
STATE_GRAVITY = "state it: gravity in robot.toml"
BEYOND = 0.1
"""Share of a joint's range, and of its speed, by which a log may exceed it: encoders see a little more."""


class Mistake(NamedTuple):
    """One mistake.

    Attributes:
        what: What is wrong, in a clause.
        cure: What to do about it.
        right: The samples without it; None where the samples are right.
        model: The arm without it, if the mistake is in its description.
    """

    what: str
    cure: str
    right: Sampled | None
    model: Model | None = None


def mistakes(robot: Robot, log: Sampled) -> Iterator[Mistake]:
    """All that are weighed of a log."""
    n, joints = robot.dof, robot.joints
    plain = np.arange(n)
    for a, b in combinations(range(n), 2):
        order = plain.copy()
        order[[a, b]] = b, a
        names = f"{joints[a]} and {joints[b]}"
        columns = "give their columns the other way round ([position] and [current] or [torque] column)"
        yield Mistake(f"all columns of {names} are exchanged", columns, _moved(log, order, order))
        columns = "give them the other way round: [position] column in a preset, or --columns"
        yield Mistake(f"the positions of {names} are exchanged", columns, _moved(log, order, plain))
        columns = "give them the other way round: [current] or [torque] column in a preset, or --columns"
        yield Mistake(f"the efforts of {names} are exchanged", columns, _moved(log, plain, order))
    if n > 2:
        for order, words in (
            (plain[::-1], "are in reverse order"),
            (np.roll(plain, 1), "begin one late"),
            (np.roll(plain, -1), "begin one early"),
        ):
            yield Mistake(f"the columns {words}", "give them in the robot's order", _moved(log, order, order))
    ranks = np.array([sorted(joints).index(joint) for joint in joints])
    if not np.array_equal(ranks, plain):
        yield Mistake(
            "the columns are sorted by name", "give them in the robot's order", _moved(log, ranks, ranks)
        )
    for j in range(n):
        factor = np.where(plain == j, -1.0, 1.0)
        yield Mistake(
            f"the position of {joints[j]} counts the other way",
            "turn it: [position] sign in a preset, or the axis in the robot's description",
            _scaled(log, factor),
        )
    turning = np.flatnonzero(robot.revolute).tolist()
    for which in [[j] for j in turning] + [turning] * (len(turning) > 1):
        words = f"position of {joints[which[0]]} is" if len(which) == 1 else "positions are"
        for unit, value, cure in UNITS if len(which) == len(turning) else UNITS[:1]:
            right = _scaled(log, np.where(np.isin(plain, which), value, 1.0))
            if _reachable(robot, right):
                yield Mistake(f"the {words} in {unit}", cure, right)


def log_odds(model: Model, log: Sampled, stated: np.ndarray | None) -> tuple[dict[int, float], list[Mistake]]:
    """Log of prior times likelihood of each mistake by its place, and of none at place -1.

    `stated` (n,) are gains, where they are stated.

    Returns:
        Odds and mistakes.
    """
    every = list(mistakes(model.robot, log))
    explained = {-1: Explained.of(model, log, stated)}
    explained |= {place: Explained.of(model, one.right or log, stated) for place, one in enumerate(every)}
    # A direction takes a search: only where something is wrong.
    odds = _better(explained)
    # One joint alone turns about one axis: gravity across it is in any direction as good.
    moving = np.count_nonzero(log.sliding.any(axis=0)) > 1
    if moving and (max(odds.values()) > odds[-1] or explained[-1].poor):
        direction = found_direction(model.robot, log)
        if direction is not None:
            every.append(_mounting(model, direction))
            explained[len(every) - 1] = Explained.of(under_gravity(model, direction), log, stated)
    return _better(explained), every


class Explained(NamedTuple):
    """How well bodies explain efforts.

    Attributes:
        fitted: Log-likelihood of samples that were fitted, joint by joint.
        predicted: That of samples that were left out.
        outside: Share of each effort's variance that is not predicted, shape (n,).
        coupled: Log-likelihood by one set of bodies for all joints, with gains as stated; None without.
        together: Share of all efforts that those do not predict.
    """

    fitted: float
    predicted: float
    outside: np.ndarray
    coupled: float | None
    together: float

    @property
    def poor(self) -> bool:
        """Whether something larger than friction is wrong."""
        by_all = self.coupled is not None and self.together > EXPLAINS**2
        return by_all or bool(np.any(self.outside > UNEXPLAINED))

    @classmethod
    def of(cls, model: Model, log: Sampled, stated: np.ndarray | None) -> "Explained":
        """By bodies of any mass, and what is stated beside them, of any size."""
        columns = torque_columns(model, log.motion)
        inside, outside = left_in_and_out(columns, log)
        weights, ones = pieces(log), np.ones(len(outside))
        fitted, predicted = odds_of(inside, weights), odds_of(outside, weights)
        if stated is None:
            return cls(fitted, predicted, outside, None, 1.0)
        coupled = Coupled.of(columns, log._replace(effort=log.effort * stated))
        return cls(fitted, predicted, outside, coupled.odds(ones), coupled.left(ones).mean())


def _better(explained: Mapping[int, Explained]) -> dict[int, float]:
    """Log odds of each: as it is at place -1, and mistakes.

    Where, under any of them, one set of bodies explains all joints, that is what tells: it is far stricter.
    Gains a little off mislead it: what speaks against a mistake joint by joint, with each gain free, counts
    as well. Else joint by joint the less of what is fitted and predicted: a joint that hardly moves predicts
    better and explains less.
    """
    as_is, prior = explained[-1], float(np.log(MISTAKE / (len(explained) + 1)))
    odds = {-1: float(np.log(1 - MISTAKE))}
    credible = min(one.together for one in explained.values()) < EXPLAINS**2
    for place, one in explained.items():
        if place < 0:
            continue
        gain = min(one.fitted - as_is.fitted, one.predicted - as_is.predicted)
        if credible and one.coupled is not None and as_is.coupled is not None:
            gain = one.coupled - as_is.coupled + min(0.0, gain)
        odds[place] = prior + gain
    return odds


def torque_columns(model: Model, motion: Motion) -> np.ndarray:
    """Torque per unit of the ten parameters of each link, and of what is stated beside, shape (t, n, p)."""
    return np.concatenate(
        [rigid_regressor(model.robot.kinematics, motion), Stated.of(model, motion).columns], axis=2
    )


def under_gravity(model: Model, direction: Sequence[float]) -> Model:
    """The model with gravity along a direction of its robot's base."""
    return replace(model, robot=under(model.robot, direction))


def upside_down(model: Model, log: Sampled) -> Mistake | None:
    """An arm that hangs and is described standing, or the other way round; None where that shows nowhere."""
    described = described_direction(model.robot)
    if described is None or np.count_nonzero(log.sliding.any(axis=0)) < 2:
        return None
    opposite = [-part for part in described]
    words = f"gravity points along {direction_words(opposite)} of the base, opposite to the description"
    return Mistake(words, STATE_GRAVITY, None, under_gravity(model, opposite))


def _mounting(model: Model, direction: Direction) -> Mistake:
    """An arm that stands otherwise."""
    words = f"{direction_words(direction)} or {direction_words([-part for part in direction])}"
    what = f"gravity points along {words} of the base"
    return Mistake(what, STATE_GRAVITY, None, under_gravity(model, direction))


def joined(logs: Sequence[Sampled]) -> Sampled:
    """Logs one after the other."""
    motions = [log.motion for log in logs]
    time, position, velocity, acceleration = (
        np.concatenate([getattr(motion, name) for motion in motions])
        for name in ("time", "position", "velocity", "acceleration")
    )
    effort, sliding = (np.concatenate([log[place] for log in logs]) for place in (1, 2))
    return Sampled(Motion.of(time, position, velocity, acceleration), effort, sliding)


def thinned(log: Sampled, most: int) -> Sampled:
    """At most that many of its samples, evenly."""
    kept = slice(None, None, max(1, -(-len(log.effort) // most)))
    return Sampled(log.motion[kept], log.effort[kept], log.sliding[kept])


def _reachable(robot: Robot, log: Sampled) -> bool:
    """Whether all positions and speeds are within the robot's limits."""
    limits, motion = robot.limits, log.motion
    over = BEYOND * np.minimum(limits.position_upper - limits.position_lower, 2 * np.pi)
    inside = (motion.position > limits.position_lower - over) & (
        motion.position < limits.position_upper + over
    )
    slow = np.percentile(np.abs(motion.velocity), 99, axis=0) <= (1 + BEYOND) * limits.velocity
    return bool(inside.all() and slow.all())


def _moved(log: Sampled, position: np.ndarray, effort: np.ndarray) -> Sampled:
    """Columns of positions and of efforts in other orders (n,)."""
    old = log.motion
    motion = Motion.of(
        old.time, old.position[:, position], old.velocity[:, position], old.acceleration[:, position]
    )
    return Sampled(motion, log.effort[:, effort], log.sliding[:, position])


def _scaled(log: Sampled, factor: np.ndarray) -> Sampled:
    """Positions times a factor (n,)."""
    old = log.motion
    return log._replace(
        motion=Motion.of(old.time, old.position * factor, old.velocity * factor, old.acceleration * factor)
    )
