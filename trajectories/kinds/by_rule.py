"""Kinds of run that follow a rule, not an optimization: a function for each, and `by_rule` for a plan."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.model import Model

from ..clearances.clearance import clear_position
from ..errors import in_words_of
from ..limits.usable_limits import usable
from ..planning.planner import plan
from ..planning.wishes import Wishes, beside_periods, shortest_run
from ..plans.plan import Plan
from ..trajectory import Trajectory
from .rests import Workspace
from .single_joint import constant_velocity_sweeps, single_joint_runs
from .static_poses import static_poses
from .with_chirp import with_chirp

POSES = 15
"""Poses of a static run: gravity has about ten base parameters on six joints, each seen more than once."""
CALM = 0.5
"""Share of the velocity, acceleration and jerk limits that the motion under a chirp leaves to the chirp."""
UNDER_CHIRP = 12.0
"""Duration of the motion under a chirp [s]: long enough for the two octaves a chirp needs, short enough not
to warm up the drives."""
SEARCH = 12.0
"""Search time for the motion under a chirp [s]: it need not be the best."""


Progress = Callable[[str], None]
"""Called with a sentence at each stage."""
Run = tuple[Trajectory, Sequence[str]]
"""The motion, and sentences on what was left out, and why."""
Kind = Callable[[Model, Wishes, Workspace, Sequence[int], Progress], Run]


def _joint_progress(model: Model, joints: Sequence[int], progress: Progress) -> Callable[[int], None]:
    """A function that reports progress when the part of a joint begins."""

    def begin(joint: int) -> None:
        progress(f"move {model.robot.joints[joint]}, {list(joints).index(joint) + 1} of {len(joints)} joints")

    return begin


def sweeps(model: Model, wishes: Wishes, space: Workspace, joints: Sequence[int], progress: Progress) -> Run:
    """Constant-velocity sweeps back and forth, joint by joint: friction curves."""
    pose = _rest_pose(model, wishes, space.limits)
    begin = _joint_progress(model, joints, progress)
    return constant_velocity_sweeps(space, joints, pose, begin), ()


def poses(model: Model, wishes: Wishes, space: Workspace, joints: Sequence[int], progress: Progress) -> Run:
    """Rests at poses approached from both sides: gravity and offsets."""
    run = static_poses(
        space,
        POSES,
        model,
        wishes.start,
        begin=lambda pose, poses: progress(f"move to pose {pose} of {poses}"),
    )
    return run.trajectory, run.notes


def single_joint(
    model: Model, wishes: Wishes, space: Workspace, joints: Sequence[int], progress: Progress
) -> Run:
    """One joint at a time, fast and slow: its dynamics without coupling to the others."""
    pose = _rest_pose(model, wishes, space.limits)
    begin = _joint_progress(model, joints, progress)
    return single_joint_runs(space, joints, pose, begin), ()


def chirp(model: Model, wishes: Wishes, space: Workspace, joints: Sequence[int], progress: Progress) -> Run:
    """A chirp on a calm motion of all joints: elasticity, backlash, delay."""
    calm = replace(wishes.margins, velocity=CALM, acceleration=CALM, jerk=CALM)
    limits, _ = usable(model.robot, calm, wishes.window, wishes.start)
    base_wishes = replace(wishes, margins=calm)
    seconds = max(UNDER_CHIRP + beside_periods(base_wishes, limits), shortest_run(base_wishes, limits))
    base_wishes = replace(base_wishes, seconds=seconds)
    motion = plan(model, base_wishes, starts=1, seconds=SEARCH, progress=progress)[0].trajectory
    progress("add the chirp")
    return with_chirp(motion, joints, space), ()


def _rest_pose(model: Model, wishes: Wishes, limits: Limits) -> np.ndarray:
    """Pose of the resting joints: the start if there is one, else a clear pose or the middle of the range."""
    if wishes.start is not None:
        return wishes.start
    if wishes.clearances:
        return clear_position(replace(model.robot, limits=limits), wishes.clearances)
    return np.asarray(0.5 * (limits.position_lower + limits.position_upper))


KINDS: dict[str, Kind] = {"sweeps": sweeps, "poses": poses, "single-joint": single_joint, "chirp": chirp}
"""Kind by its name on the command line."""


def by_rule(
    kind: str, model: Model, wishes: Wishes, joints: Sequence[int] = (), progress: Progress = lambda _: None
) -> Plan:
    """Plan of a run of one kind in `KINDS`, on joints from 0; on all by default."""
    limits, assumed = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    space = Workspace(limits, wishes.tick, wishes.clearances)
    with in_words_of(model.robot):
        run, notes = KINDS[kind](model, wishes, space, joints or range(model.robot.dof), progress)
    return Plan.of(
        run,
        model,
        margins=vars(wishes.margins),
        tick=wishes.tick,
        assumed=(*assumed, *notes),
        details={"kind": kind},
    )
