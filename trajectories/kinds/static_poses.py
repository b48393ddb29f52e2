"""Static poses: what holds the arm up, gravity, springs and offsets, with dry friction averaged out.

A drive at rest holds anything between gravity plus and gravity minus dry friction; where in between, how it
came to rest decides. So each pose is visited twice, with all joints coming from below and with all from
above: friction enters the two with opposite signs, the mean is what holds the arm, and half of the
difference is friction.
"""

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.fit.base_parameters import from_columns
from exidyn.identification.model import Model

from ..clearances.clearance import Clearance
from ..errors import BadLimits, Infeasible, NothingToIdentify
from ..families.phases import Phases
from ..families.sequence import Sequence
from ..trajectory import Trajectory
from .rests import pause, require_clear_pose, require_limits, require_pose, way

APPROACH = 0.05
"""How far each joint comes from below or above [rad]: six times the 8 mrad over which friction builds up
after a reversal in a soft gear, and more than any backlash."""
DWELL = 1.0
"""Rest at each visit [s]."""
DETOURS = 4
"""Poses over which a way is tried that collides by itself, the shortest first."""


class PoseRun(NamedTuple):
    """A motion from pose to pose; k poses were reached.

    Attributes:
        trajectory: Begins and ends at rest at the same pose.
        poses: In the order of the visits, shape (k, n) [rad].
        rests: Begin and end of the rests at each pose, come from below and from above, shape (k, 2, 2) [s].
        notes: A sentence for each pose that was left out, and each way that goes round.
    """

    trajectory: Sequence
    poses: np.ndarray
    rests: np.ndarray
    notes: tuple[str, ...]


def static_poses(
    limits: Limits,
    count: int,
    tick: float,
    dwell: float = DWELL,
    seed: int = 0,
    clearances: Collection[Clearance] = (),
    model: Model | None = None,
    start: np.ndarray | None = None,
    approach: float = APPROACH,
    begin: Callable[[int, int], None] = lambda pose, poses: None,
) -> PoseRun:
    """Rests at poses that distinguish gravity and offsets, each visited from below and from above.

    Args:
        limits: Finite but for the torque.
        count: How many poses.
        tick: Cycle of the controller [s].
        dwell: Rest at each visit [s]; each pose has two.
        seed: Seed of the random positions from which poses are chosen.
        clearances: What to keep clear of, in poses and on the ways.
        model: Nominal; poses are those that show its parameters at rest. Spread out without.
        start: Where to begin and end, shape (n,) [rad]; the first pose unless given.
        approach: How far each joint comes from below or above [rad].
        begin: Called with the number of each pose, and of all, before the way to it is looked for.

    Raises:
        BadLimits: Limits, a tick, a count or an approach that are none.
        Infeasible: A start outside the limits or not clear, or no pose that can be reached.
        NothingToIdentify: Nothing in the model acts at rest.
    """
    require_limits(limits, tick)
    if count < 1 or not 0.0 < approach < np.inf or not 0.0 <= dwell < np.inf:
        raise BadLimits(
            f"{count} poses, rests of {dwell:g} s, approach over {approach:g} rad; expected at least one "
            "pose, a rest of 0 or more and an approach above 0"
        )
    candidates = clear_positions(limits, approach, clearances, seed, count)
    if model is None:
        chosen = candidates[spread_out(candidates, count, limits)]
    else:
        chosen = candidates[informative(candidates, count, limits, model)]
    home = chosen[0] if start is None else require_pose(start, limits)
    require_clear_pose(home, clearances)
    ways = _Ways(limits, tick, tuple(clearances), np.array([home, *chosen]))
    notes: list[str] = []
    ordered = _said(_nearest_first(home, chosen, limits), begin)
    visits = ways.visits(home, ordered, dwell, approach, notes)
    back = ways.home(visits, home, notes)
    if not visits:
        raise Infeasible(f"none of {count} poses can be reached. {notes[0]}")
    notes += [f"the way to {_words(visit.pose)} goes round" for visit in visits if visit.round]
    return _run(visits, back, notes)


def _said(poses: list[np.ndarray], begin: Callable[[int, int], None]) -> Iterator[np.ndarray]:
    """The poses one by one, each said before it is asked for."""
    for number, pose in enumerate(poses, 1):
        begin(number, len(poses))
        yield pose


class _Visit(NamedTuple):
    """The way to a pose and both rests there, the last of the parts and the fourth from the last."""

    pose: np.ndarray
    parts: list[Phases]
    round: bool


class _Ways(NamedTuple):
    """Ways between rests without a contact; `over` are poses that a way may go round by, (k, n) [rad]."""

    limits: Limits
    tick: float
    clearances: tuple[Clearance, ...]
    over: np.ndarray

    def between(self, start: np.ndarray, target: np.ndarray) -> list[Phases]:
        """One way, or two that go round by a pose; raises Infeasible if all that were tried collide."""
        try:
            return [self._straight(start, target)]
        except Infeasible:
            cost = _time(self.limits, start - self.over) + _time(self.limits, self.over - target)
            for index in np.argsort(cost)[:DETOURS]:
                middle = self.over[index]
                try:
                    return [self._straight(start, middle), self._straight(middle, target)]
                except Infeasible:
                    continue
            raise

    def visit(self, start: np.ndarray, pose: np.ndarray, dwell: float, approach: float) -> _Visit:
        """To a pose from below, a rest, to it from above, a rest."""
        still = pause(pose, dwell, self.tick)
        there = self.between(start, pose - approach)
        from_below = self._straight(pose - approach, pose)
        away, from_above = self._straight(pose, pose + approach), self._straight(pose + approach, pose)
        return _Visit(pose, [*there, from_below, still, away, from_above, still], len(there) > 1)

    def visits(
        self, at: np.ndarray, poses: Iterable[np.ndarray], dwell: float, approach: float, notes: list[str]
    ) -> list[_Visit]:
        """Visits to all poses that can be reached, in their order; what cannot is noted."""
        found = []
        for pose in poses:
            try:
                found.append(self.visit(at, pose, dwell, approach))
                at = pose
            except Infeasible as error:
                notes.append(f"{_words(pose)} was left out: {error}")
        return found

    def home(self, visits: list[_Visit], home: np.ndarray, notes: list[str]) -> list[Phases]:
        """The way back from the last visit; visits from which there is none are taken off the list."""
        while visits:
            try:
                return self.between(visits[-1].pose, home)
            except Infeasible as error:
                notes.append(f"{_words(visits.pop().pose)} was left out; on the way home: {error}")
        return []

    def _straight(self, start: np.ndarray, target: np.ndarray) -> Phases:
        return way(start, target, self.limits, self.tick, self.clearances)


def _nearest_first(home: np.ndarray, poses: np.ndarray, limits: Limits) -> list[np.ndarray]:
    """Poses in an order in which each is the nearest that is left to the one before."""
    left, ordered, at = list(poses), [], home
    while left:
        nearest = int(np.argmin(_time(limits, np.array(left) - at)))
        at = left.pop(nearest)
        ordered.append(at)
    return ordered


def _time(limits: Limits, travel: np.ndarray) -> np.ndarray:
    """Time that the slowest joint needs at full speed, of travels of shape (t, n) [rad]; (t,) [s]."""
    return np.max(np.maximum(travel / limits.velocity, travel / limits.velocity_lower), axis=1)


def _run(visits: list[_Visit], back: list[Phases], notes: list[str]) -> PoseRun:
    """Everything joined, and when the rests are."""
    rests, now = [], 0.0
    for visit in visits:
        ends = now + np.cumsum([part.duration for part in visit.parts])
        now = float(ends[-1])
        rests.append([ends[[-5, -4]], ends[[-2, -1]]])
    parts: list[Trajectory] = [part for visit in visits for part in visit.parts]
    parts = [part for part in [*parts, *back] if part.duration > 0.0]
    return PoseRun(
        Sequence(tuple(parts)), np.array([visit.pose for visit in visits]), np.array(rests), tuple(notes)
    )


def _words(pose: np.ndarray) -> str:
    return f"pose ({', '.join(f'{position:.3g}' for position in pose)})"


DRAWN = 400
"""Random positions at a time."""
WANTED = 200
"""Clear ones that are enough to choose from: the best of 200 are among the best half per cent there are."""
DRAWS = 10
"""How often at most; below one clear position in twenty something is wrong with the cell's description."""
HALF_TURN = np.pi
"""Either side of the middle of its range a joint is taken [rad]; a whole turn has all that gravity knows."""
PRIOR = 1e-6
"""Information that is assumed of each unknown, as a share of what one pose gives: makes the first choices
comparable before all unknowns are seen, and weighs nothing after."""
TEMPERATURE = 20.0
"""Of every joint [degC]: at rest there is no friction that could depend on it."""


def clear_positions(
    limits: Limits, margin: float, clearances: Collection[Clearance], seed: int, count: int
) -> np.ndarray:
    """Random positions that are clear of everything, a margin [rad] inside the limits; shape (c, n) [rad].

    Raises:
        Infeasible: A joint's range is smaller than the margins, or fewer than `count` were found.
    """
    lower, upper = limits.position_lower + margin, limits.position_upper - margin
    for joint in np.flatnonzero(~(lower < upper)):
        raise Infeasible(
            f"joint {joint + 1}: {limits.position_lower[joint]:g} to {limits.position_upper[joint]:g} rad, "
            f"less {margin:g} at both ends to come to a pose from, is nothing. Try a shorter approach"
        )
    middle = 0.5 * (lower + upper)
    lower, upper = np.maximum(lower, middle - HALF_TURN), np.minimum(upper, middle + HALF_TURN)
    random, found = np.random.default_rng(seed), np.empty((0, len(lower)))
    worst, name = -np.inf, ""
    for _ in range(DRAWS):
        drawn = random.uniform(lower, upper, (DRAWN, len(lower)))
        clear = np.ones(DRAWN, bool)
        for clearance in clearances:
            margins = clearance.margins(drawn)
            clear &= np.all(margins >= 0.0, axis=1)
            best = int(np.argmax(np.min(margins, axis=1, initial=np.inf)))
            if margins.size and np.min(margins[best]) > worst:
                worst, name = float(np.min(margins[best])), clearance.names[int(np.argmin(margins[best]))]
        found = np.concatenate([found, drawn[clear]])
        if len(found) >= max(WANTED, count):
            return found
    if len(found) < count:
        raise Infeasible(
            f"{len(found)} of {DRAWS * DRAWN} random poses are clear of everything, and {count} are wanted; "
            f"the best has {worst:.4g} m of room ({name}). Try fewer poses, or check region and geometry"
        )
    return found


def informative(candidates: np.ndarray, count: int, limits: Limits, model: Model) -> np.ndarray:
    """Indices of the poses that a greedy search for the largest determinant of the information takes, (k,).

    Greedy is near the best here: the logarithm of the determinant has diminishing returns, so that what is
    gained is at least 63 % of what the best choice gains (Nemhauser 1978).

    Args:
        candidates: Shape (c, n) [rad].
        count: How many to take.
        limits: Torque limits are the unit of each joint's torque, as a drive's noise grows with its size.
        model: Its regressor at rest, reduced to what poses can distinguish.

    Raises:
        NothingToIdentify: Nothing acts on this arm at rest.
    """
    columns = _resting_columns(candidates, model)
    if np.all(np.isfinite(limits.torque)):
        columns = columns / limits.torque[:, None]
    columns = columns / np.sqrt(np.mean(np.sum(columns**2, axis=1), axis=0))
    information = PRIOR * np.eye(columns.shape[2])
    taken: list[int] = []
    for _ in range(min(count, len(candidates))):
        spread = columns @ np.linalg.solve(information, np.swapaxes(columns, 1, 2))
        gain = np.linalg.slogdet(np.eye(columns.shape[1]) + spread)[1]
        gain[taken] = -np.inf
        taken.append(int(np.argmax(gain)))
        information += columns[taken[-1]].T @ columns[taken[-1]]
    return np.array(taken)


def _resting_columns(positions: np.ndarray, model: Model) -> np.ndarray:
    """Regressor at rest of the base parameters that poses can distinguish, shape (c, n, b)."""
    still = np.zeros_like(positions)
    warm = np.full_like(positions, TEMPERATURE)
    motion = Motion.of(np.arange(len(positions)) * 1.0, positions, still, still, temperature=warm)
    # what an effect with a memory does at rest is decided by the way there, not by the pose
    resting = replace(model, effects=tuple(effect for effect in model.effects if effect.pointwise))
    columns = resting.regressor(resting.loaded(motion))
    rows = columns.reshape(-1, columns.shape[2])
    if not np.any(rows):
        raise NothingToIdentify(
            f"{model.robot.name}: at rest no parameter of the model makes any torque, in no pose; there is "
            "nothing that static poses could show. Try a motion"
        )
    return columns[:, :, from_columns(tuple(resting.parameters), rows).kept]


def spread_out(candidates: np.ndarray, count: int, limits: Limits) -> np.ndarray:
    """Indices of poses each of which is farthest from those before it, as shares of the ranges; (k,)."""
    scaled = candidates / (limits.position_upper - limits.position_lower)
    middle = 0.5 * (limits.position_upper + limits.position_lower)
    away = np.linalg.norm((candidates - middle) / (limits.position_upper - limits.position_lower), axis=1)
    taken = [int(np.argmax(away))]
    distance = np.full(len(candidates), np.inf)
    for _ in range(min(count, len(candidates)) - 1):
        distance = np.minimum(distance, np.linalg.norm(scaled - scaled[taken[-1]], axis=1))
        taken.append(int(np.argmax(distance)))
    return np.array(taken)
