"""Most informative poses for what holds an arm up: gravity, springs and offsets of the current."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.arm.robot import Limits
from exidyn.identify.fit.base_parameters import from_columns
from exidyn.identify.model import Model

from ..clearances.clearance import Clearance
from ..errors import Infeasible, NothingToIdentify

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
