"""Start: whether the motion can begin from where the arm stands, and the way there."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exidyn.drivers import Info
from exidyn.identify.arm.robot import Limits
from exidyn.trajectories.clearances.clearance import Clearance
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.trajectory import Trajectory

from .errors import CannotStart
from .player import Player
from .stopping.stop import UnitOf, turning


@dataclass(frozen=True)
class StartRules:
    """How the arm may get to where the motion begins.

    Attributes:
        tolerance: Distance a joint may be away without being asked for [rad]: half a degree.
        approach: Whether it may come from further away.
        speed: Share of the limits on the way [-]: slow enough to reach the emergency stop.
        clearances: What the way must keep clear of.
        advice: What to try where it is too far away.
    """

    tolerance: float = 0.0087
    approach: bool = False
    speed: float = 0.2
    clearances: Sequence[Clearance] = ()
    advice: str = "Move it there, or let it go there slowly with --approach"


def plan_start(
    player: Player,
    measured: np.ndarray,
    joints: Sequence[str],
    limits: Limits,
    rules: StartRules,
    info: Info,
    unit_of: UnitOf = turning,
) -> Phases:
    """The way from where the arm stands, at rest, to where the motion begins.

    Args:
        player: Has the motion.
        measured: Position of the arm, shape (n,) [rad].
        joints: Names.
        limits: Finite ones of the arm.
        rules: What is allowed.
        info: Has the controller's window.
        unit_of: Unit of a joint.

    Raises:
        CannotStart: The arm is too far away, its position is unknown, or way or motion are not in order.
    """
    unknown = [name for name, value in zip(joints, measured, strict=True) if not np.isfinite(value)]
    if unknown:
        raise CannotStart(f"the controller gives no position of {', '.join(unknown)}")
    target = player.motion.state_at(0.0)
    away = np.abs(measured - target.position)
    if not rules.approach and np.any(away > rules.tolerance):
        raise CannotStart(_far(measured, target.position, joints, rules, unit_of))
    _require_window(player.motion, measured, joints, info, unit_of)
    slow = gentle(limits, rules.speed) if not np.any(target.velocity) else limits
    way = player.approach(measured, slow)
    for clearance in rules.clearances:
        nearest = clearance.worst(way)
        if not nearest.allowed:
            raise CannotStart(
                f"on the way to where the motion begins, {nearest.name} would come within "
                f"{1e3 * nearest.margin:.0f} mm of what is allowed after {nearest.time:.1f} s. Move the arm "
                "by hand to where the way is free"
            )
    return way


def gentle(limits: Limits, share: float) -> Limits:
    """The same limits of position, and a share of all others."""
    names = ("velocity", "velocity_lower", "acceleration", "acceleration_lower", "jerk")
    return replace(limits, **{name: share * getattr(limits, name) for name in names})


def _far(
    measured: np.ndarray, target: np.ndarray, joints: Sequence[str], rules: StartRules, unit_of: UnitOf
) -> str:
    far = [int(joint) for joint in np.flatnonzero(np.abs(measured - target) > rules.tolerance)]
    units = [unit_of(joint, "rad") for joint in far]
    rows = [
        f"{joints[joint]} is at {measured[joint]:.4f}, the motion begins at {target[joint]:.4f} {unit}"
        for joint, unit in zip(far, units, strict=True)
    ]
    allowed = " or ".join(f"{rules.tolerance:.4f} {unit}" for unit in dict.fromkeys(units))
    return f"the arm is not where the motion begins: {'; '.join(rows)}; allowed are {allowed}. {rules.advice}"


def _require_window(
    motion: Trajectory, measured: np.ndarray, joints: Sequence[str], info: Info, unit_of: UnitOf
) -> None:
    """Raise where the controller would not take a command that far from where the arm stands."""
    if info.window_lower is None or info.window_upper is None:
        return
    reached = motion.extremes().position
    below, above = reached.lower - measured, reached.upper - measured
    for joint, name in enumerate(joints):
        low, high = info.window_lower[joint], info.window_upper[joint]
        if below[joint] < low or above[joint] > high:
            size, unit = (180 / np.pi, "degrees") if unit_of(joint, "rad") == "rad" else (1e3, "mm")
            raise CannotStart(
                f"{name}: the motion goes {size * below[joint]:.2f} to {size * above[joint]:.2f} "
                f"{unit} from where the arm stands, the controller takes {size * low:.2f} to "
                f"{size * high:.2f}. Widen its window, or plan with 'exidyn excite --window'"
            )
