"""Recordings prepared for the check: positions and efforts at the same samples."""

from collections.abc import Sequence

import numpy as np

from ..arm.robot import Robot
from ..recordings.recording import EFFORT, Recording
from .samples import Sampled, sampled

FEWEST = 100
"""Minimum number of samples of a recording."""


def sampled_torques(runs: Sequence[Recording], robot: Robot) -> tuple[list[Recording], list[Sampled], bool]:
    """Usable recordings, their logs, and whether the efforts are torques according to the stated gains."""
    usable = [(run, log) for run, log in ((run, sampled_run(run)) for run in runs) if log is not None]
    torques = {"torque" in run.signals for run, _ in usable}
    gain = robot.drive_gain
    stated = len(torques) == 1 and (torques == {True} or not np.all(gain == 1.0))
    factor = gain if stated and torques == {False} else np.ones(robot.dof)
    logs = [log._replace(effort=log.effort * factor) for _, log in usable]
    return [run for run, _ in usable], logs, stated


def sampled_run(run: Recording) -> Sampled | None:
    """Positions and efforts of a recording at the same samples; None if there are too few."""
    name = next((name for name in EFFORT if name in run.signals), "")
    if not name or min(len(run.signals["position"]), len(run.signals[name])) < FEWEST:
        return None
    position, effort = run.signals["position"], run.signals[name]
    known = np.isfinite(position.values).all(axis=1)
    time = position.time[known]
    efforts = np.column_stack([np.interp(time, effort.time, values) for values in effort.values.T])
    if not np.isfinite(efforts).all() or np.any(np.diff(time) <= 0.0):
        return None
    return sampled(time, position.values[known], efforts)
