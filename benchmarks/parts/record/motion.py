"""The arm that benchmarks record, and its motion."""

from functools import cache

import numpy as np

from exidyn.acquire.run.perform import Job
from exidyn.identify.robot_files.robot_file import read_model
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.usable_limits import Margins, usable
from exidyn.trajectories.planning.planner import plan
from exidyn.trajectories.planning.run_with_leads import whole_run
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.search.shrink import inside_kinematics
from exidyn.trajectories.trajectory import Trajectory

ROBOT = "cobot"
MODEL = read_model(ROBOT)
JOINTS = MODEL.robot.dof
LIMITS = usable(MODEL.robot, Margins(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)).limits
START = 0.5 * (
    np.maximum(MODEL.robot.limits.position_lower, -np.pi)
    + np.minimum(MODEL.robot.limits.position_upper, np.pi)
)
"""Where the peers' arms stand, shape (n,) [rad]."""
TICK = 0.02
"""Of the motions [s]: a whole number of every controller's cycles."""
PLANNED = 8.0
"""Motions as long as this are planned to identify the parameters; shorter ones are random [s]."""
SHARE = 0.35
"""Of the limits, in a short motion [-]: full speed would leave no time but for getting there."""
REST = 0.5
"""At both ends [s]: rest shows the noise."""


@cache
def motion(seconds: float, search: float = 5.0) -> Trajectory:
    """A motion of some `seconds`, from the middle of the range and back, inside all limits.

    Args:
        seconds: About how long it lasts [s].
        search: How long a better one is looked for, where it is planned [s].
    """
    if seconds < PLANNED:
        return _random(seconds)
    period = min(10.0, 0.5 * TICK * round(seconds / TICK))
    exciting = max(seconds - 4.0, period)  # the rest is rest, and the ways there and back
    wishes = Wishes(seconds=exciting, period=period, start=START, tick=TICK, rest=REST)
    return plan(MODEL, wishes, starts=1, seconds=search)[0].trajectory


def _random(seconds: float) -> Trajectory:
    period = TICK * max(round((seconds - 2.0) / TICK), 50)
    sine, cosine = np.random.default_rng(0).normal(size=(2, JOINTS, 2)) / [1.0, 2.0]
    series = inside_kinematics(Fourier(period, START, sine, cosine), LIMITS, SHARE)
    return whole_run(series, LIMITS, TICK, start=START, rest=0.1)


def job(seconds: float, **other: object) -> Job:
    """To play that motion; `other` as in `Job`."""
    return Job(MODEL.robot, motion(seconds), LIMITS, **other)  # type: ignore[arg-type]
