"""Before: whether a robot may run a plan, whether that can begin where the arm stands, and the way there."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exidyn.drivers import Info
from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.trajectories.clearances.clearance import Clearance
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.families.sequence import Slowed
from exidyn.trajectories.limits.usable_limits import Margins, usable
from exidyn.trajectories.plans.plan import Plan, model_differences, robot_differences
from exidyn.trajectories.plans.plan_check import Torque, nominal_torque, violations
from exidyn.trajectories.plans.plan_limits import file_warnings, narrowed, some, within
from exidyn.trajectories.trajectory import Trajectory

from .arms import with_body
from .errors import CannotStart, NotAllowed
from .player import Player
from .stopping.stop import UnitOf, turning

NO_MARGIN = Margins(position=0.0, slide=0.0, velocity=0.0, acceleration=0.0, jerk=0.0, torque=0.0)
RATES = ("velocity", "velocity_lower", "acceleration", "acceleration_lower", "jerk")


@dataclass(frozen=True)
class Checked:
    """A plan that this robot may run.

    Attributes:
        plan: At the speed at which it is to be played, its limits no wider than the robot's.
        model: The robot with what it carries.
        limits: The robot's; those that are not given as the planner assumes them, or as the motion uses them.
        torque: Torque of the motion by the nominal model.
        warnings: What was edited in its file, and what may be different than when it was planned, a sentence
            each.
    """

    plan: Plan
    model: Model
    limits: Limits
    torque: Torque
    warnings: tuple[str, ...]


def checked(plan: Plan, model: Model, speed: float = 1.0, payload: KnownPayload | None = None) -> Checked:
    """The plan at a share of its speed [-], if the robot at hand may run it with what it carries.

    Limits are those of the robot at hand; the plan's file can only narrow them.

    Raises:
        NotAllowed: It is for another robot, or goes beyond the limits of this one.
    """
    different = robot_differences(plan, model.robot)
    if different:
        raise NotAllowed(
            f"{model.robot.name} must not run a plan for {plan.robot}: {some(different)}. Plan it again"
        )
    warnings = (*file_warnings(plan, model.robot), *model_differences(plan, model))
    held = within(plan, model.robot)
    slowed = held if speed == 1.0 else replace(held, trajectory=Slowed(plan.trajectory, speed))
    # A pair is run twice, each run by itself; the torque of this run is that with its own payload.
    single = replace(slowed, payload_pair=bool(payload))
    carrying = with_body(model, payload)
    torque = nominal_torque(single, carrying)
    beyond = violations(single, torque)
    if beyond:
        raise NotAllowed(
            f"the plan{', edited by hand,' if plan.edited else ''} goes beyond the limits of "
            f"{_whose(plan, model.robot)}: {some(beyond)}. Plan it again, or play it slower "
            "(exidyn record --speed)"
        )
    return Checked(slowed, carrying, _finite(model.robot, slowed.trajectory), torque, warnings)


def _whose(plan: Plan, robot: Robot) -> str:
    """Whose limits were checked: the robot's, and those that the plan's file narrows."""
    narrower = narrowed(plan, robot)
    return robot.name + (f" and of its own file, narrower in {some(narrower)}" if narrower else "")


def require_clear(ready: Checked, clearances: Sequence[Clearance]) -> None:
    """Refuse a motion that touches something, or leaves a region.

    Raises:
        NotAllowed: With where, and how deep.
    """
    nearest = [clearance.worst(ready.plan.trajectory) for clearance in clearances]
    touching = [
        f"{one.name} by {-1e3 * one.distance:.0f} mm at {one.time:.1f} s" for one in nearest if one.collides
    ]
    if touching:
        raise NotAllowed(
            f"the plan runs into the arm itself, an obstacle or a wall: {some(touching)}. Plan it again"
        )


def _finite(robot: Robot, motion: Trajectory) -> Limits:
    """The robot's limits; those not given as assumed, but no less than what the motion uses."""
    given, assumed = robot.limits, usable(robot, NO_MARGIN).limits
    extremes = motion.extremes()
    found: dict[str, np.ndarray] = {}
    for name in RATES:
        used = getattr(extremes, name.removesuffix("_lower"))
        if name.endswith("_lower"):
            needed = np.minimum(getattr(assumed, name), used.lower)
        else:
            needed = np.maximum(
                getattr(assumed, name), np.maximum(used.upper, -used.lower * (name == "jerk"))
            )
        found[name] = np.where(np.isfinite(getattr(given, name)), getattr(given, name), needed)
    return replace(given, **found)


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
    """The way from where the arm stands, at rest at `measured` (n,) [rad] or [m], to where the motion begins.

    Args:
        player: Has the motion.
        measured: Position of the arm.
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
