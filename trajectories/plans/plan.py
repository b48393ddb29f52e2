"""Plan: a trajectory with its robot, limits and criterion, and how it fits another robot.

A plan's file narrows the limits of the robot that runs it, and never widens them.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.model import Model
from exidyn.identification.notebook import InNotebook
from exidyn.identification.robot_files.robot_text import model_text, moving_text
from exidyn.identification.schema import Name, Number, Size

from ..errors import BadLimits, NotATrajectory
from ..limits.usable_limits import require_movable
from ..trajectory import States, Trajectory

if TYPE_CHECKING:
    from pathlib import Path

UNITS = ("rad", "m")
"""Units of the positions of revolute and prismatic joints."""
HASH_DIGITS = 16
"""Number of hexadecimal digits, of 64: 64 bits, so that no two robots have the same hash by chance."""


@dataclass(frozen=True, eq=False)
class Plan(InNotebook):
    """A planned trajectory, and what the arm and its operator need to know about it."""

    trajectory: Trajectory  # the motion
    robot: Name  # name of the robot
    robot_hash: Name  # hash of the robot's geometry and limits
    model_hash: Name  # hash of the nominal model
    joints: tuple[Name, ...]  # names of the joints, in the order of every (t, n) array
    units: tuple[str, ...]  # unit of each joint's position, "rad" or "m"
    limits: Limits  # limits of the robot, without margins
    # Safety margins to the limits, by name: a share [-], or a position [rad].
    margins: Mapping[str, Size] = field(default_factory=dict)
    criterion: str = ""  # minimized criterion; empty if nothing was minimized
    reached: float = float("nan")  # value of the criterion; NaN if nothing was minimized
    # Other facts by name, such as condition number, largest deviation, solver, seconds.
    details: Mapping[str, int | float | str] = field(default_factory=dict)
    seed: int = 0  # seed of the random starts
    tick: Number = 0.004  # sampling period of the controller [s]
    payload_pair: bool = False  # whether the motion is to be run twice, unloaded and loaded
    assumed: tuple[str, ...] = ()  # sentences on assumptions
    # Whether it was read from a file without a checksum, which a person wrote or changed.
    edited: bool = False

    if TYPE_CHECKING:  # `exidyn.api` binds it

        def save(self, path: Path | str) -> Path: ...

    def to_arrays(self, tick: float | None = None) -> States:
        """Time (t,) [s], position, velocity, acceleration and jerk (t, n), every `tick` or `self.tick`."""
        return self.trajectory.every(tick or self.tick)

    def __post_init__(self) -> None:
        n = self.trajectory.dof
        counts = {"joints": len(self.joints), "units": len(self.units)}
        counts |= {f"limits.{f.name}": getattr(self.limits, f.name).size for f in fields(self.limits)}
        for name, count in counts.items():
            if count != n:
                raise NotATrajectory(f"{name} has {count} entries, and the trajectory moves {n} joints")
        for unit in self.units:
            if unit not in UNITS:
                raise NotATrajectory(f"units: '{unit}' is not one of {', '.join(UNITS)}")
        if not 0.0 < self.tick < np.inf:
            raise NotATrajectory(f"tick is {self.tick:g} s, expected above 0")

    def __repr__(self) -> str:
        reached = f", {self.criterion} {self.reached:.4g}" if self.criterion else ""
        return f"<Plan for {self.robot}: {self.trajectory.duration:g} s{reached}>"

    @classmethod
    def of(cls, trajectory: Trajectory, model: Model, **options: Any) -> "Plan":
        """A plan for a model's robot; `options` are the remaining fields."""
        robot = model.robot
        return cls(
            trajectory=trajectory,
            joints=robot.joints,
            units=units_of(robot),
            robot=robot.name,
            robot_hash=robot_hash(robot),
            model_hash=model_hash(model),
            limits=robot.limits,
            **options,
        )


def units_of(robot: Robot) -> tuple[str, ...]:
    """Unit of each joint's position, "rad" or "m"."""
    return tuple("rad" if revolute else "m" for revolute in robot.revolute)


def robot_hash(robot: Robot) -> str:
    """Short hash of the robot's geometry and limits."""
    return hashlib.sha256(moving_text(robot).encode()).hexdigest()[:HASH_DIGITS]


def model_hash(model: Model) -> str:
    """Short hash of the nominal model."""
    return hashlib.sha256(model_text(model).encode()).hexdigest()[:HASH_DIGITS]


def fits(plan: Plan, model: Model) -> list[str]:
    """Sentences on how a robot and model differ from those planned for; empty if they agree."""
    return [*robot_differences(plan, model.robot), *model_differences(plan, model)]


def robot_differences(plan: Plan, robot: Robot) -> list[str]:
    """Reasons why this robot must not run the plan: other joints, limits or geometry.

    The hash is that of the robot planned for. It does not cover the limits in the plan's file, which may have
    been edited since: `within` restricts those to the robot's.
    """
    if plan.joints != robot.joints:
        return [
            f"the plan is for the joints {', '.join(plan.joints)} of {plan.robot}; "
            f"{robot.name} has {', '.join(robot.joints)}"
        ]
    units = units_of(robot)
    if plan.units != units:
        return [f"the plan states units {', '.join(plan.units)}; {robot.name} has {', '.join(units)}"]
    if plan.robot_hash == robot_hash(robot):
        return []
    differences = [
        f"limit {name} of {joint} is {current:g}; it was {planned:g} when the plan was made"
        for name, joint, planned, current in differing_limits(plan, robot)
    ]
    return differences or [
        f"{robot.name} has another geometry than {plan.robot}, for which the plan was made "
        f"(hash {robot_hash(robot)}, planned {plan.robot_hash})"
    ]


def differing_limits(plan: Plan, robot: Robot) -> Iterator[tuple[str, str, float, float]]:
    """Name and joint of each limit that differs, with the values of plan and robot."""
    for name, planned in vars(plan.limits).items():
        current = getattr(robot.limits, name)
        for place in np.flatnonzero(planned != current):
            yield name, robot.joints[place], float(planned[place]), float(current[place])


def model_differences(plan: Plan, model: Model) -> list[str]:
    """Warning if the nominal model has changed, so that predicted torques may not hold."""
    if plan.model_hash == model_hash(model):
        return []
    return [
        f"the model of {model.robot.name} is not the one of the plan (hash {model_hash(model)}, planned "
        f"{plan.model_hash}): torques, and the information on the parameters, may differ"
    ]


SOME = 3
"""Maximum number of limits named in a sentence; a file with all limits changed would name 48."""
EDITED = "the plan's file has no checksum: it was written or edited by hand"
CHECKED_ANEW = (
    "Its limits, stops and torque are checked again, and collisions if the robot's geometry is known; its "
    "margins and criterion are not"
)
NAME_ROBOT = "Percentages refer to the limits in the file; use --robot to refer to those of the robot"


def tightest(first: Limits, second: Limits) -> Limits:
    """The narrower of two limits for each joint and side."""
    narrower = {}
    for name, limit in vars(first).items():
        tighter = np.maximum if name.endswith("_lower") else np.minimum
        narrower[name] = tighter(limit, getattr(second, name))
    return Limits(**narrower)


def within(plan: Plan, robot: Robot) -> Plan:
    """The plan with its limits restricted to those of a robot with the same joints.

    Raises:
        BadLimits: The position limits of plan and robot do not overlap.
    """
    limits = tightest(plan.limits, robot.limits)
    try:
        require_movable(limits)
    except BadLimits as error:
        raise BadLimits(f"limits of {robot.name} combined with those in the plan's file: {error}") from error
    return replace(plan, limits=limits)


def file_warnings(plan: Plan, robot: Robot | None = None) -> list[str]:
    """Warnings on the file of a plan, before `within`, for an operator; none if exidyn wrote it."""
    warnings = [f"{EDITED}. {CHECKED_ANEW if robot else NAME_ROBOT}"] if plan.edited else []
    if robot is None:
        return warnings
    if wider := _differences(plan, robot, wider=True):
        warnings.append(
            f"limits in the plan's file exceed those of {robot.name}, which are used: {some(wider)}"
        )
    if narrower := narrowed(plan, robot):
        warnings.append(
            f"limits in the plan's file are narrower than those of {robot.name}, and are used: "
            f"{some(narrower)}"
        )
    return warnings


def narrowed(plan: Plan, robot: Robot) -> list[str]:
    """Descriptions of limits in the plan's file that are narrower than those of its robot."""
    return _differences(plan, robot, wider=False)


def _differences(plan: Plan, robot: Robot, wider: bool) -> list[str]:
    """Descriptions of limits in the plan's file that are wider, or narrower, than the robot's.

    The result is empty for another robot than the one planned for, for which `robot_differences` names them.
    """
    if plan.robot_hash != robot_hash(robot):
        return []
    return [
        f"{name} of {joint} ({planned:g}, robot {current:g})"
        for name, joint, planned, current in differing_limits(plan, robot)
        if (planned < current if name.endswith("_lower") else planned > current) == wider
    ]


def some(sentences: list[str]) -> str:
    """The first sentences, and the number of further ones."""
    more = len(sentences) - SOME
    return "; ".join(sentences[:SOME]) + (f"; and {more} more" if more > 0 else "")
