"""Checks before a run: whether a robot may run a plan and start where it stands, and the approach."""

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
from exidyn.trajectories.plans.plan import (
    Plan,
    file_warnings,
    model_differences,
    narrowed,
    robot_differences,
    some,
    within,
)
from exidyn.trajectories.plans.plan_check import Curve, nominal_torque, violations
from exidyn.trajectories.trajectory import Trajectory

from .arms import with_body
from .errors import CannotStart, NotAllowed
from .player import Player

NO_MARGIN = Margins(position=0.0, slide=0.0, velocity=0.0, acceleration=0.0, jerk=0.0, torque=0.0)
RATES = ("velocity", "velocity_lower", "acceleration", "acceleration_lower", "jerk")


@dataclass(frozen=True)
class CheckedPlan:
    """A plan that this robot may run."""

    plan: Plan  # plan at playback speed; its limits are no wider than the robot's
    model: Model  # robot with its payload
    limits: Limits  # limits of the robot; missing ones are those that the planner assumes or the motion needs
    torque: Curve  # torque of the motion, computed with the nominal model
    # Sentences about edits in the plan's file and about differences since it was planned.
    warnings: tuple[str, ...]


def check_plan(
    plan: Plan, model: Model, speed: float = 1.0, payload: KnownPayload | None = None
) -> CheckedPlan:
    """Check that a robot may run a plan at a share of its speed [-] and with its payload.

    The limits are those of this robot; the plan's file can only narrow them.

    Raises:
        NotAllowed: If the plan is for another robot or exceeds a limit of this one.
    """
    different = robot_differences(plan, model.robot)
    if different:
        raise NotAllowed(
            f"{model.robot.name} must not run a plan for {plan.robot}: {some(different)}. Plan it again"
        )
    warnings = (*file_warnings(plan, model.robot), *model_differences(plan, model))
    limited = within(plan, model.robot)
    slowed = limited if speed == 1.0 else replace(limited, trajectory=Slowed(plan.trajectory, speed))
    # The two runs of a pair are checked separately: this one needs the torque with its own payload only.
    single = replace(slowed, payload_pair=bool(payload))
    carrying = with_body(model, payload)
    torque = nominal_torque(single, carrying)
    beyond = violations(single, torque)
    if beyond:
        raise NotAllowed(
            f"the plan{', edited by hand,' if plan.edited else ''} exceeds the limits of "
            f"{_limits_owner(plan, model.robot)}: {some(beyond)}. Plan it again, or play it slower "
            "(exidyn record --speed)"
        )
    return CheckedPlan(slowed, carrying, _finite_limits(model.robot, slowed.trajectory), torque, warnings)


def _limits_owner(plan: Plan, robot: Robot) -> str:
    """Names the owner of the limits: the robot, and the plan's file if it narrows them."""
    narrower = narrowed(plan, robot)
    return robot.name + (f" and of its own file, narrower in {some(narrower)}" if narrower else "")


def require_clear(ready: CheckedPlan, clearances: Sequence[Clearance]) -> None:
    """Refuse a motion that collides or leaves its region.

    Raises:
        NotAllowed: If it does; the message says where, when and how deep.
    """
    nearest = [clearance.worst(ready.plan.trajectory) for clearance in clearances]
    touching = [
        f"{worst.name} by {-1e3 * worst.distance:.0f} mm at {worst.time:.1f} s"
        for worst in nearest
        if worst.collides
    ]
    if touching:
        raise NotAllowed(
            f"the plan runs into the arm itself, an obstacle or a wall: {some(touching)}. Plan it again"
        )


def _finite_limits(robot: Robot, motion: Trajectory) -> Limits:
    """The robot's limits; missing ones are as the planner assumes, or as the motion needs."""
    limits, assumed = robot.limits, usable(robot, NO_MARGIN).limits
    extremes = motion.extremes()
    finite: dict[str, np.ndarray] = {}
    for name in RATES:
        used = getattr(extremes, name.removesuffix("_lower"))
        if name.endswith("_lower"):
            needed = np.minimum(getattr(assumed, name), used.lower)
        else:
            needed = np.maximum(
                getattr(assumed, name), np.maximum(used.upper, -used.lower * (name == "jerk"))
            )
        finite[name] = np.where(np.isfinite(getattr(limits, name)), getattr(limits, name), needed)
    return replace(limits, **finite)


@dataclass(frozen=True)
class StartRules:
    """How the arm may move to the start of the motion."""

    # Maximum distance of a joint from the start without `approach` [rad] or [m]: half a degree.
    tolerance: float = 0.0087
    approach: bool = False  # whether the arm may start further away
    # Share of the limits used on the approach [-]: slow enough to reach the emergency stop.
    speed: float = 0.2
    clearances: Sequence[Clearance] = ()  # obstacles and regions to respect on the approach
    # Advice if the arm is too far away.
    advice: str = "Move it there, or let it go there slowly with --approach"


def plan_start(
    player: Player, measured: np.ndarray, robot: Robot, limits: Limits, rules: StartRules, info: Info
) -> Phases:
    """Plan the approach from the measured position (n,) [rad] or [m] at rest to the start of the motion.

    Raises:
        CannotStart: If the arm is too far away, its position is unknown, or the approach is not allowed.
    """
    unknown = [name for name, value in zip(robot.joints, measured, strict=True) if not np.isfinite(value)]
    if unknown:
        raise CannotStart(f"the controller reports no position of {', '.join(unknown)}")
    target = player.motion.state_at(0.0)
    away = np.abs(measured - target.position)
    if not rules.approach and np.any(away > rules.tolerance):
        raise CannotStart(_too_far_text(measured, target.position, robot, rules))
    _require_window(player.motion, measured, robot, info)
    slow = scaled_limits(limits, rules.speed) if not np.any(target.velocity) else limits
    approach = player.approach(measured, slow)
    for clearance in rules.clearances:
        nearest = clearance.worst(approach)
        if not nearest.allowed:
            raise CannotStart(
                f"on the approach to the start of the motion, {nearest.name} would come "
                f"{-1e3 * nearest.margin:.0f} mm closer than allowed after {nearest.time:.1f} s. Move the "
                "arm by hand to where the approach is free"
            )
    return approach


def scaled_limits(limits: Limits, share: float) -> Limits:
    """The limits with velocity, acceleration and jerk scaled by a share [-]."""
    return replace(limits, **{name: share * getattr(limits, name) for name in RATES})


def _too_far_text(measured: np.ndarray, target: np.ndarray, robot: Robot, rules: StartRules) -> str:
    far = [int(joint) for joint in np.flatnonzero(np.abs(measured - target) > rules.tolerance)]
    units = [robot.unit(joint, "rad") for joint in far]
    rows = [
        f"{robot.joints[joint]} is at {measured[joint]:.4f}, the motion begins at {target[joint]:.4f} {unit}"
        for joint, unit in zip(far, units, strict=True)
    ]
    allowed = " or ".join(f"{rules.tolerance:.4f} {unit}" for unit in dict.fromkeys(units))
    return f"the arm is not where the motion begins: {'; '.join(rows)}; limit {allowed}. {rules.advice}"


def _require_window(motion: Trajectory, measured: np.ndarray, robot: Robot, info: Info) -> None:
    """Raise if the motion leaves the window around the current position that the controller accepts."""
    if info.window_lower is None or info.window_upper is None:
        return
    reached = motion.extremes().position
    below, above = reached.lower - measured, reached.upper - measured
    for joint, name in enumerate(robot.joints):
        low, high = info.window_lower[joint], info.window_upper[joint]
        if below[joint] < low or above[joint] > high:
            size, unit = (180 / np.pi, "degrees") if robot.revolute[joint] else (1e3, "mm")
            raise CannotStart(
                f"{name}: the motion goes {size * below[joint]:.2f} to {size * above[joint]:.2f} "
                f"{unit} from where the arm stands; the controller accepts {size * low:.2f} to "
                f"{size * high:.2f}. Widen its window, or plan with 'exidyn excite --window'"
            )
