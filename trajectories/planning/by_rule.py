"""Kinds of run that follow a rule, not an optimization: a function for each, and `by_rule` for a plan."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.model import Model

from ..clearances.clearance import clear_position
from ..errors import BadLimits, Infeasible, in_words_of
from ..families.chirp import Chirp
from ..limits.brake import stoppable
from ..limits.usable_limits import ranges, usable
from ..plans.plan import Plan
from ..trajectory import Trajectory
from .planner import plan
from .rests import Workspace
from .single_joint import constant_velocity_sweeps, single_joint_runs
from .static_poses import static_poses
from .wishes import Wishes, beside_periods, shortest_run

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


def sweeps(model: Model, wishes: Wishes, space: Workspace, joints: Sequence[int], progress: Progress) -> Run:
    """Constant-velocity sweeps back and forth, joint by joint: friction curves."""
    return _joint_by_joint(constant_velocity_sweeps, model, wishes, space, joints, progress)


def poses(model: Model, wishes: Wishes, space: Workspace, joints: Sequence[int], progress: Progress) -> Run:
    """Rests at poses approached from both sides: gravity and offsets."""

    def begin(pose: int, poses: int) -> None:
        progress(f"move to pose {pose} of {poses}")

    run = static_poses(space, POSES, model, wishes.start, begin=begin)
    return run.trajectory, run.notes


def single_joint(
    model: Model, wishes: Wishes, space: Workspace, joints: Sequence[int], progress: Progress
) -> Run:
    """One joint at a time, fast and slow: its dynamics without coupling to the others."""
    return _joint_by_joint(single_joint_runs, model, wishes, space, joints, progress)


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


def _joint_by_joint(
    make: Callable[[Workspace, Sequence[int], np.ndarray, Callable[[int], None]], Trajectory],
    model: Model,
    wishes: Wishes,
    space: Workspace,
    joints: Sequence[int],
    progress: Progress,
) -> Run:
    """A run of one joint after another from the pose at which the others rest."""

    def begin(joint: int) -> None:
        progress(f"move {model.robot.joints[joint]}, {list(joints).index(joint) + 1} of {len(joints)} joints")

    return make(space, joints, _rest_pose(model, wishes, space.limits), begin), ()


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
    margins, details, assumed = vars(wishes.margins), {"kind": kind}, (*assumed, *notes)
    return Plan.of(run, model, margins=margins, tick=wishes.tick, assumed=assumed, details=details)


LOW = 1.0
"""Lowest frequency of a chirp [Hz]: half an octave above the frequencies of identification runs."""
HIGH = 20.0
"""Highest frequency of a chirp [Hz], if the sampling period allows: the first resonances of arms are at 5 to
20 Hz, and the usual measurement filter ends there."""
LEAST = 4.0
"""Least ratio of the highest to the lowest frequency: two octaves, below which a chirp reveals no slope."""
SAMPLES = 6
"""Least samples per period, a third of the Nyquist frequency: a controller that interpolates linearly still
moves by 91 % of the amplitude."""
SHARE = 0.5
"""Share of the room that the base motion leaves: a joint at resonance swings further than commanded."""
RESOLUTION = 1e-6
"""Resolution of an encoder before a gear with ratio 100 [rad]: 16 bit per motor turn."""
STEPS = 10
"""Least amplitude in encoder steps: quantization is then 3 % of it."""
SMALLER = 0.8
"""Factor by which the amplitude shrinks until every stop ends inside the limits and there is no contact."""


def with_chirp(base: Trajectory, joints: Collection[int], space: Workspace) -> Chirp:
    """A motion with a chirp from beginning to end; the chirp is zero at both ends.

    It rises to 20 Hz, or less if a period would have fewer than six samples or the limits would leave too
    small an amplitude to measure. The amplitude shrinks until limits and clearances are kept. Ten seconds are
    a good duration of the base motion; joints are counted from 0.

    Raises:
        BadLimits: The sampling period is too long for a chirp.
        Infeasible: The base motion leaves no room, collides or cannot be stopped, or the amplitude is too
            small to measure.
    """
    space.require_clear("the motion under the chirp", base)
    tick = space.tick
    highest = min(HIGH, 1.0 / (SAMPLES * tick))
    if not LOW < highest:
        raise BadLimits(
            f"the chirp goes from {LOW:g} to {highest:g} Hz; it must rise, and a sampling period of {tick:g} "
            f"s allows up to {highest:.4g} Hz, {SAMPLES} samples per period. Try a shorter sampling period"
        )
    largest = SHARE * _room(base, tuple(joints), space.limits)
    while True:
        # envelope, rising frequency and falling amplitude reach more than a plain sine
        trial = Chirp(base, tuple(joints), largest, LOW, highest, 0.0, base.duration, 1.0 / LOW)
        chirp = trial.scaled(1.0 / max(1.0, float(np.max(trial.reached / largest))))
        try:
            return _safe(chirp, space)
        except Infeasible:
            highest *= SMALLER
            if highest < LEAST * LOW:
                raise


def _room(base: Trajectory, joints: tuple[int, ...], limits: Limits) -> np.ndarray:
    """Room of position, velocity, acceleration and jerk between a motion and its limits, shape (k, 4)."""
    room = np.empty((len(joints), 4))
    bounds = zip(ranges(limits).items(), base.extremes(), strict=True)
    for order, ((name, (lower, upper)), reached) in enumerate(bounds):
        remaining = np.minimum(upper - reached.upper, reached.lower - lower)
        for place, joint in enumerate(joints):
            room[place, order] = remaining[joint]
            if not remaining[joint] > 0.0:
                raise Infeasible(
                    f"joint {joint + 1}: the {name} of the base motion, {reached.lower[joint]:g} to "
                    f"{reached.upper[joint]:g}, leaves no room for a chirp within {lower[joint]:g} to "
                    f"{upper[joint]:g}. Try a slower motion, or rest in the middle of the range"
                )
    return room


def _safe(chirp: Chirp, space: Workspace) -> Chirp:
    """The chirp, scaled down until every stop ends inside the limits and there is no contact."""
    while True:
        _require_measurable(chirp)
        clear = all(clearance.worst(chirp).allowed for clearance in space.clearances)
        if clear and np.all(stoppable(chirp.every(space.tick), space.limits)):
            return chirp
        chirp = chirp.scaled(SMALLER)


def _require_measurable(chirp: Chirp) -> None:
    frequency = np.geomspace(chirp.low, chirp.high, 100)
    steps = chirp.amplitude(frequency) / RESOLUTION
    for place, joint in enumerate(chirp.joints):
        small = steps[:, place] < STEPS
        if np.any(small):
            first = frequency[np.argmax(small)]
            raise Infeasible(
                f"joint {joint + 1}: at {chirp.high:g} Hz the limits allow an amplitude of "
                f"{steps[-1, place] * RESOLUTION:.3g} rad, {steps[-1, place]:.2g} encoder steps of "
                f"{RESOLUTION:g} rad; at least {STEPS} are needed, from {first:.3g} Hz on it has fewer. "
                "Try a lower frequency, a larger share, or a slower base motion"
            )
