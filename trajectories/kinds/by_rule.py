"""Kinds of run beside the optimised one, one function a kind, and a run of one kind as a plan."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.model import Model

from ..clearances.configurations import clear_position
from ..errors import in_words_of
from ..limits.usable_limits import usable
from ..planning.planner import plan
from ..planning.wishes import Wishes
from ..plans.plan import Plan
from ..trajectory import Trajectory
from .single_joint import single_joint_runs
from .static_poses import static_poses
from .sweeps import constant_velocity_sweeps
from .with_chirp import with_chirp

POSES = 15
"""Poses of a static run: gravity has some ten base parameters on six joints, each seen more than once."""
CALM = 0.5
"""Share of velocity, acceleration and jerk that the motion under a chirp leaves to it."""
UNDER_CHIRP = 12.0
"""Length of that motion [s]: long enough for two octaves a chirp needs, short enough to warm nothing up."""
SEARCH = 12.0
"""Of search for it [s]: a calm motion need not be the best."""


class Made(NamedTuple):
    """A run made by rule.

    Attributes:
        trajectory: The motion.
        notes: What was left out of it and why, a sentence each.
    """

    trajectory: Trajectory
    notes: tuple[str, ...] = ()


Progress = Callable[[str], None]
"""Called with a sentence at each stage."""
Kind = Callable[[Model, Wishes, Limits, Sequence[int], Progress], Made]


def _each(model: Model, joints: Sequence[int], progress: Progress) -> Callable[[int], None]:
    """What is called with a joint before its part is made, and says so."""

    def begin(joint: int) -> None:
        progress(f"move {model.robot.joints[joint]}, {list(joints).index(joint) + 1} of {len(joints)} joints")

    return begin


def sweeps(model: Model, wishes: Wishes, limits: Limits, joints: Sequence[int], progress: Progress) -> Made:
    """Constant velocities back and forth, joint by joint: friction curves."""
    pose = _pose(model, wishes, limits)
    begin = _each(model, joints, progress)
    return Made(
        constant_velocity_sweeps(limits, joints, pose, wishes.tick, clearances=wishes.clearances, begin=begin)
    )


def poses(model: Model, wishes: Wishes, limits: Limits, joints: Sequence[int], progress: Progress) -> Made:
    """Rests at poses reached from both sides: gravity and offsets."""
    run = static_poses(
        limits,
        POSES,
        wishes.tick,
        clearances=wishes.clearances,
        model=model,
        start=wishes.start,
        begin=lambda pose, poses: progress(f"move to pose {pose} of {poses}"),
    )
    return Made(run.trajectory, tuple(run.notes))


def single_joint(
    model: Model, wishes: Wishes, limits: Limits, joints: Sequence[int], progress: Progress
) -> Made:
    """One joint at a time, slow and fast: what each does without the others."""
    pose = _pose(model, wishes, limits)
    begin = _each(model, joints, progress)
    return Made(
        single_joint_runs(limits, joints, pose, wishes.tick, clearances=wishes.clearances, begin=begin)
    )


def chirp(model: Model, wishes: Wishes, limits: Limits, joints: Sequence[int], progress: Progress) -> Made:
    """A swept sine on a calm motion of all joints: elasticity, backlash, delay."""
    calm = replace(wishes.margins, velocity=CALM, acceleration=CALM, jerk=CALM)
    under = replace(wishes, margins=calm, seconds=UNDER_CHIRP)
    motion = plan(model, under, starts=1, seconds=SEARCH, progress=progress)[0].trajectory
    progress("add the chirp")
    return Made(with_chirp(motion, joints, limits, wishes.tick, clearances=wishes.clearances))


def _pose(model: Model, wishes: Wishes, limits: Limits) -> np.ndarray:
    """Where the other joints rest: the start if one is given, else the middle, or a place that is clear."""
    if wishes.start is not None:
        return wishes.start
    if wishes.clearances:
        return clear_position(replace(model.robot, limits=limits), wishes.clearances)
    return np.asarray(0.5 * (limits.position_lower + limits.position_upper))


KINDS: dict[str, Kind] = {"sweeps": sweeps, "poses": poses, "single-joint": single_joint, "chirp": chirp}
"""By the name that the command line gives them."""


def by_rule(
    kind: str,
    model: Model,
    wishes: Wishes,
    joints: Sequence[int] = (),
    progress: Progress = lambda _: None,
) -> Plan:
    """A run of a kind.

    Args:
        kind: A name in `KINDS`.
        model: Model of the arm.
        wishes: What is wanted of it.
        joints: That move, from 0; all by default.
        progress: Called with a sentence at each stage.
    """
    limits, assumed = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    with in_words_of(model.robot):
        made = KINDS[kind](model, wishes, limits, joints or range(model.robot.dof), progress)
    return Plan.of(
        made.trajectory,
        model,
        margins=vars(wishes.margins),
        tick=wishes.tick,
        assumed=(*assumed, *made.notes),
        details={"kind": kind},
    )
