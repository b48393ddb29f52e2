"""Static poses: gravity, springs and offsets, with dry friction averaged out.

A drive at rest holds any torque between gravity plus and gravity minus dry friction, depending on how it
came to rest. So each pose is visited twice, once with all joints coming from below and once from above.
Friction enters the two with opposite signs: the mean is what holds the arm, and half of the difference is
friction.
"""

from collections.abc import Callable, Collection
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Limits
from exidyn.identification.fit.base_parameters import from_columns
from exidyn.identification.model import Model

from ..clearances.clearance import Clearance
from ..errors import Infeasible, NothingToIdentify
from ..families.phases import Phases
from ..families.sequence import Sequence
from .rests import Workspace, joined

APPROACH = 0.05
"""Distance over which each joint approaches a pose [rad]: six times the 8 mrad over which friction builds up
after a reversal in a soft gear, and more than any backlash."""
DWELL = 1.0
"""Rest at each visit [s]."""
DETOURS = 4
"""Number of detours tried when the direct move collides, the shortest first."""


class PoseRun(NamedTuple):
    """A motion from pose to pose that reaches k poses."""

    trajectory: Sequence  # motion that begins and ends at rest at the same pose
    poses: np.ndarray  # poses in the order of the visits, shape (k, n) [rad]
    notes: tuple[str, ...]  # a sentence for each pose that was left out, and for each detour


def static_poses(
    space: Workspace,
    count: int,
    model: Model,
    start: np.ndarray | None = None,
    seed: int = 0,
    dwell: float = DWELL,
    begin: Callable[[int, int], None] = lambda pose, poses: None,
) -> PoseRun:
    """Rests at poses that distinguish gravity and offsets, each visited from below and from above.

    Args:
        space: Limits, sampling period, and clearances to keep, at the poses and between them.
        count: Number of poses.
        model: Nominal model, whose parameters the poses excite at rest.
        start: Pose to begin and end at, shape (n,) [rad]; the first pose by default.
        seed: Seed of the random positions from which the poses are chosen.
        dwell: Rest at each visit [s]; each pose has two visits.
        begin: Called with the number of each pose, and of all poses, before the move to it is planned.

    Raises:
        Infeasible: The start is not clear, or no pose can be reached.
        NothingToIdentify: No parameter of the model acts at rest.
    """
    limits = space.limits
    candidates = clear_positions(limits, APPROACH, space.clearances, seed, count)
    chosen = candidates[informative(candidates, count, limits, model)]
    home = chosen[0] if start is None else start
    space.require_clear_pose(home)
    router = _Router(space, np.array([home, *chosen]), dwell)
    notes: list[str] = []
    visits = router.visits(home, _nearest_first(home, chosen, limits), notes, begin)
    return_moves = router.home(visits, home, notes)
    if not visits:
        raise Infeasible(f"none of {count} poses can be reached. {notes[0]}")
    notes += [f"the move to {_words(visit.pose)} takes a detour" for visit in visits if visit.detour]
    run = joined([*(part for visit in visits for part in visit.parts), *return_moves])
    return PoseRun(run, np.array([visit.pose for visit in visits]), tuple(notes))


class _Visit(NamedTuple):
    """The moves to a pose with both rests there, and whether they take a detour."""

    pose: np.ndarray
    parts: list[Phases]
    detour: bool


class _Router(NamedTuple):
    """Finds contact-free moves between rests; `waypoints` are the poses of detours, shape (k, n) [rad]."""

    space: Workspace
    waypoints: np.ndarray
    dwell: float

    def between(self, start: np.ndarray, target: np.ndarray) -> list[Phases]:
        """The direct move, or two moves through a waypoint; raises Infeasible if all tried moves collide."""
        try:
            return [self.space.move_clear(start, target)]
        except Infeasible:
            limits = self.space.limits
            cost = _time(limits, start - self.waypoints) + _time(limits, self.waypoints - target)
            for index in np.argsort(cost)[:DETOURS]:
                middle = self.waypoints[index]
                try:
                    return [self.space.move_clear(start, middle), self.space.move_clear(middle, target)]
                except Infeasible:
                    continue
            raise

    def visit(self, start: np.ndarray, pose: np.ndarray) -> _Visit:
        """Approach a pose from below, rest, approach it from above, rest."""
        still = self.space.pause(pose, self.dwell)
        there, move = self.between(start, pose - APPROACH), self.space.move_clear
        from_below = [move(pose - APPROACH, pose), still]
        from_above = [move(pose, pose + APPROACH), move(pose + APPROACH, pose), still]
        return _Visit(pose, [*there, *from_below, *from_above], len(there) > 1)

    def visits(
        self, at: np.ndarray, poses: list[np.ndarray], notes: list[str], begin: Callable[[int, int], None]
    ) -> list[_Visit]:
        """Visits to all reachable poses, in their order; the others are added to the notes."""
        visits = []
        for number, pose in enumerate(poses, 1):
            begin(number, len(poses))
            try:
                visits.append(self.visit(at, pose))
                at = pose
            except Infeasible as error:
                notes.append(f"{_words(pose)} was left out: {error}")
        return visits

    def home(self, visits: list[_Visit], home: np.ndarray, notes: list[str]) -> list[Phases]:
        """Moves from the last visit back home; visits without such a move are removed from the list."""
        while visits:
            try:
                return self.between(visits[-1].pose, home)
            except Infeasible as error:
                notes.append(f"{_words(visits.pop().pose)} was left out; on the way home: {error}")
        return []


def _nearest_first(home: np.ndarray, poses: np.ndarray, limits: Limits) -> list[np.ndarray]:
    """Poses ordered such that each is the nearest remaining one to its predecessor."""
    remaining, ordered, at = list(poses), [], home
    while remaining:
        nearest = int(np.argmin(_time(limits, np.array(remaining) - at)))
        at = remaining.pop(nearest)
        ordered.append(at)
    return ordered


def _time(limits: Limits, travel: np.ndarray) -> np.ndarray:
    """Time that the slowest joint needs at full speed for travels of shape (t, n) [rad]; shape (t,) [s]."""
    return np.max(np.maximum(travel / limits.velocity, travel / limits.velocity_lower), axis=1)


def _words(pose: np.ndarray) -> str:
    return f"pose ({', '.join(f'{position:.3g}' for position in pose)})"


DRAWN = 400
"""Random positions in each draw."""
WANTED = 200
"""Number of clear positions to choose from: the best of 200 is among the best half percent of all."""
DRAWS = 10
"""Maximum number of draws; if less than one position in twenty is clear, the cell's description is wrong."""
HALF_TURN = np.pi
"""Largest distance of a joint from the middle of its range [rad]; a full turn covers all gravity torques."""
PRIOR = 1e-6
"""Prior information on each unknown, as a share of the information from one pose: makes the first choices
comparable before all unknowns are excited, and is negligible afterwards."""
TEMPERATURE = 20.0
"""Temperature of every joint [degC]: at rest no friction depends on it."""


def clear_positions(
    limits: Limits, margin: float, clearances: Collection[Clearance], seed: int, count: int
) -> np.ndarray:
    """Random positions that keep all clearances, a margin [rad] inside the limits; shape (c, n) [rad].

    Raises:
        Infeasible: A joint's range is smaller than the margins, or fewer than `count` positions are clear.
    """
    lower, upper = limits.position_lower + margin, limits.position_upper - margin
    for joint in np.flatnonzero(~(lower < upper)):
        raise Infeasible(
            f"joint {joint + 1}: its range, {limits.position_lower[joint]:g} to "
            f"{limits.position_upper[joint]:g} rad, leaves no room for an approach of {margin:g} rad at both "
            "ends. Try a shorter approach"
        )
    middle = 0.5 * (lower + upper)
    lower, upper = np.maximum(lower, middle - HALF_TURN), np.minimum(upper, middle + HALF_TURN)
    random, accepted = np.random.default_rng(seed), np.empty((0, len(lower)))
    best_margin, best_name = -np.inf, ""
    for _ in range(DRAWS):
        drawn = random.uniform(lower, upper, (DRAWN, len(lower)))
        clear = np.ones(DRAWN, bool)
        for clearance in clearances:
            margins = clearance.margins(drawn)
            clear &= np.all(margins >= 0.0, axis=1)
            best = margins[int(np.argmax(np.min(margins, axis=1, initial=np.inf)))]
            if best.size and np.min(best) > best_margin:
                best_margin, best_name = float(np.min(best)), clearance.names[int(np.argmin(best))]
        accepted = np.concatenate([accepted, drawn[clear]])
        if len(accepted) >= max(WANTED, count):
            return accepted
    if len(accepted) < count:
        raise Infeasible(
            f"{len(accepted)} of {DRAWS * DRAWN} random poses keep all clearances; {count} are needed. The "
            f"best has a margin of {best_margin:.4g} m ({best_name}). Try fewer poses, or check the region "
            "and geometry"
        )
    return accepted


def informative(candidates: np.ndarray, count: int, limits: Limits, model: Model) -> np.ndarray:
    """Indices of poses that greedily maximize the determinant of the information matrix, shape (k,).

    Greedy is close to optimal here: the log-determinant is submodular, so the gain is at least 63 % of the
    best possible gain (Nemhauser 1978).

    Args:
        candidates: Candidate poses, shape (c, n) [rad].
        count: Number of poses to choose.
        limits: Torque limits, which scale each joint's torque, as a drive's noise grows with its size.
        model: Model whose regressor at rest is reduced to the base parameters that poses can distinguish.

    Raises:
        NothingToIdentify: No parameter acts on this arm at rest.
    """
    columns = _resting_columns(candidates, model)
    if np.all(np.isfinite(limits.torque)):
        columns = columns / limits.torque[:, None]
    columns = columns / np.sqrt(np.mean(np.sum(columns**2, axis=1), axis=0))
    information = PRIOR * np.eye(columns.shape[2])
    chosen: list[int] = []
    for _ in range(min(count, len(candidates))):
        spread = columns @ np.linalg.solve(information, np.swapaxes(columns, 1, 2))
        gain = np.linalg.slogdet(np.eye(columns.shape[1]) + spread)[1]
        gain[chosen] = -np.inf
        chosen.append(int(np.argmax(gain)))
        information += columns[chosen[-1]].T @ columns[chosen[-1]]
    return np.array(chosen)


def _resting_columns(positions: np.ndarray, model: Model) -> np.ndarray:
    """Regressor at rest of the base parameters that poses can distinguish, shape (c, n, b)."""
    still = np.zeros_like(positions)
    warm = np.full_like(positions, TEMPERATURE)
    motion = Motion.of(np.arange(len(positions)) * 1.0, positions, still, still, temperature=warm)
    # the torque of an effect with memory depends on the motion before the rest, not on the pose
    resting = replace(model, effects=tuple(effect for effect in model.effects if effect.pointwise))
    columns = resting.regressor(resting.loaded(motion))
    rows = columns.reshape(-1, columns.shape[2])
    if not np.any(rows):
        raise NothingToIdentify(
            f"{model.robot.name}: at rest, no parameter of the model produces torque in any pose, so static "
            "poses cannot identify it. Try a motion"
        )
    return columns[:, :, from_columns(tuple(resting.parameters), rows).kept]
