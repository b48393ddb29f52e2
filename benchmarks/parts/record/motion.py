"""The arms that benchmarks record, and their motion."""

from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np
import peer_process

from exidyn.acquire.run.perform import Job
from exidyn.identification.arm.robot import Limits
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.usable_limits import Margins, usable
from exidyn.trajectories.planning.planner import plan, whole_run
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.search.shrink import inside_kinematics
from exidyn.trajectories.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class BenchArm:
    """An arm that peers simulate."""

    file: str  # Of the robot, or its name

    @cached_property
    def model(self) -> Model:
        """Nominal, which is what it is too."""
        return read_model(self.file)

    @cached_property
    def limits(self) -> Limits:
        """Finite ones."""
        return usable(self.model.robot, Margins(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)).limits

    @cached_property
    def start(self) -> np.ndarray:
        """Where the peers' arms stand, shape (n,) [rad]."""
        limits = self.model.robot.limits
        middle: np.ndarray = 0.5 * (
            np.maximum(limits.position_lower, -np.pi) + np.minimum(limits.position_upper, np.pi)
        )
        return middle


COBOT = BenchArm("cobot")
FR3 = BenchArm(str(Path(peer_process.__file__).with_name("fr3.toml")))
"""Of a driver whose controller has seven joints."""
ROBOT, MODEL, START = COBOT.file, COBOT.model, COBOT.start
TICK = 0.02
"""Of the motions [s]: a whole number of every controller's cycles."""
PLANNED = 8.0
"""Motions as long as this are planned to identify the parameters; shorter ones are random [s]."""
SHARE = 0.35
"""Of the limits, in a short motion [-]: full speed would leave no time but for getting there."""
REST = 0.5
"""At both ends [s]: rest shows the noise."""


@cache
def motion(seconds: float, arm: BenchArm = COBOT) -> Trajectory:
    """A motion of about so many seconds, from the middle of the range and back, inside all limits."""
    if seconds < PLANNED:
        return _random(seconds, arm)
    period = min(10.0, 0.5 * TICK * round(seconds / TICK))
    exciting = max(seconds - 4.0, period)  # the rest is rest, and the ways there and back
    wishes = Wishes(seconds=exciting, period=period, start=arm.start, tick=TICK, rest=REST)
    return plan(arm.model, wishes, starts=1, seconds=5.0)[0].trajectory


def _random(seconds: float, arm: BenchArm) -> Trajectory:
    period = TICK * max(round((seconds - 2.0) / TICK), 50)
    sine, cosine = np.random.default_rng(0).normal(size=(2, len(arm.start), 2)) / [1.0, 2.0]
    series = inside_kinematics(Fourier(period, arm.start, sine, cosine), arm.limits, SHARE)
    wishes = Wishes(tick=TICK, seconds=period, start=arm.start, rest=0.1)
    return whole_run(series, arm.limits, wishes)


def job(seconds: float, arm: BenchArm = COBOT, **other: object) -> Job:
    """To play that motion; `other` as in `Job`."""
    return Job(arm.model.robot, motion(seconds, arm=arm), arm.limits, **other)  # type: ignore[arg-type]
