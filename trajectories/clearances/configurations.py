"""Random positions within the limits, and the search for a collision-free one."""

from collections.abc import Sequence

import numpy as np

from exidyn.identification.arm.robot import Robot

from ..errors import Infeasible
from .clearance import Clearance

WITHOUT_LIMITS = (np.pi, 1.0)
"""Range either way of a revolute joint without limits, a full turn [rad], and of a prismatic one, 1 m."""
TRIED = 2000
"""Number of random positions: a set of one percent of all positions is missed once in 5e8 tries."""
MENDED = 10
"""Number of nearest misses that are moved along the gradient, for regions that few random positions hit."""
STEPS = 60
"""Number of steps of each; Gauss-Newton comes close in about ten."""


def random_positions(robot: Robot, count: int, seed: int = 0) -> np.ndarray:
    """Uniformly distributed positions within the position limits, shape (count, n) [rad] or [m]."""
    lower, upper = _ends(robot)
    return np.random.default_rng(seed).uniform(lower, upper, (count, robot.dof))


def _ends(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Finite position limits."""
    wide = np.where(robot.revolute, *WITHOUT_LIMITS)
    lower, upper = robot.limits.position_lower, robot.limits.position_upper
    one_sided = np.isfinite(lower) != np.isfinite(upper)
    low = np.where(np.isfinite(lower), lower, np.where(one_sided, upper - 2 * wide, -wide))
    return low, np.where(np.isfinite(upper), upper, np.where(one_sided, lower + 2 * wide, wide))


def clear_position(robot: Robot, clearances: Sequence[Clearance], seed: int = 0) -> np.ndarray:
    """The position with the largest smallest margin that was found, shape (n,) [rad] or [m].

    Raises:
        Infeasible: No position keeps all clearances; the message names those that the best one violates.
    """
    position = random_positions(robot, TRIED, seed)
    worst = _worst(clearances, position)
    if np.max(worst) < 0:
        lower, upper = _ends(robot)
        position = position[np.argsort(worst)[-MENDED:]]
        for _ in range(STEPS):
            position = np.clip(position + _step(clearances, position), lower, upper)
            worst = _worst(clearances, position)
            if np.max(worst) >= 0:
                break
    best = position[np.argmax(worst)]
    if np.max(worst) < 0:
        raise Infeasible(_miss(robot, clearances, best))
    return best


def _worst(clearances: Sequence[Clearance], position: np.ndarray) -> np.ndarray:
    """Smallest of all margins at each position, shape (t,) [m]."""
    margins = [clearance.margins(position) for clearance in clearances]
    return np.min(np.concatenate([np.full((len(position), 1), np.inf), *margins], axis=1), axis=1)


def _step(clearances: Sequence[Clearance], position: np.ndarray) -> np.ndarray:
    """Gauss-Newton step toward margins of 5 mm, shape (t, n)."""
    gradients = [clearance.gradient(position) for clearance in clearances]
    margin = np.concatenate([margins for margins, _ in gradients], axis=1)
    slope = np.concatenate([slopes for _, slopes in gradients], axis=1)
    missing = np.maximum(5e-3 - margin, 0.0)
    slope = slope * (missing > 0)[:, :, None]
    # damped by 5 cm per radian, so that rows with small slopes cause no large steps
    square = slope @ np.swapaxes(slope, 1, 2) + 0.05**2 * np.eye(margin.shape[1])
    weight = np.linalg.solve(square, missing[:, :, None])
    return (np.swapaxes(slope, 1, 2) @ weight)[:, :, 0]


def _miss(robot: Robot, clearances: Sequence[Clearance], position: np.ndarray) -> str:
    """Message that names the margins that the best position violates."""
    names = [name for clearance in clearances for name in clearance.names]
    margins = np.concatenate([clearance.margins(position[None])[0] for clearance in clearances])
    misses = [f"{name} by {-margin:.4g} m" for name, margin in zip(names, margins, strict=True) if margin < 0]
    where = ", ".join(f"{joint} {x:.3g}" for joint, x in zip(robot.joints, position, strict=True))
    return (
        f"{robot.name}: no position within the joint limits keeps all clearances. The best of {TRIED} random "
        f"positions, improved, violates {'; '.join(misses)} ({where}). Widen the region, or check its frame, "
        "which is the robot's base, and its units, which are meters"
    )
