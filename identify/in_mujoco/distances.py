"""Distance between simulation and recording: some time after a common start, and over whole runs."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arm.newton_euler import flange_position
from ..arm.robot import Robot
from .replay import Run, Simulator

HORIZONS = (0.1, 0.5, 2.0)
"""Times after a start at which both are compared [s]."""
MOST = 40
"""Maximum number of starts in all runs together: it leaves rms errors uncertain by a tenth."""


class Distances(NamedTuple):
    """Distances between simulation and recordings; n joints, h horizons, w starts."""

    # Simulated minus recorded position after each horizon, shape (w, h, n) [rad]; infinite where the
    # simulation has diverged.
    ends: np.ndarray
    tools: np.ndarray  # distance between the tool points after each horizon, shape (w, h) [m]
    whole_run: np.ndarray  # RMS position error over whole runs, shape (n,) [rad]
    whole_tool: float  # RMS distance between the tool points over whole runs [m]
    traces: tuple[np.ndarray, ...]  # simulated positions of each whole run, (t, n) each [rad]
    moved: np.ndarray  # RMS motion of the real joints after each horizon, shape (h, n) [rad]

    @property
    def telling(self) -> np.ndarray:
        """Index of the longest horizon at which each joint's error is still informative, shape (n,).

        An error is informative while it is smaller than the motion of the real joint, which is the error of
        a simulation that stays at its start. Commanded torque, which holds no position, soon exceeds that.
        If no horizon is informative, the index is that of the shortest.
        """
        informative = self.joints < self.moved
        return np.where(informative, np.arange(len(informative))[:, None], 0).max(axis=0)

    @property
    def joints(self) -> np.ndarray:
        """RMS position error after each horizon, shape (h, n) [rad]."""
        return _rms(self.ends)

    @property
    def tool(self) -> np.ndarray:
        """RMS distance between the tool points after each horizon, shape (h,) [m]."""
        return _rms(self.tools)


def horizons_of(runs: Sequence[Run]) -> tuple[float, ...]:
    """The horizons that fit into the shortest run, or its duration if none fits."""
    shortest = min(float(run.time[-1] - run.time[0]) for run in runs)
    return tuple(horizon for horizon in HORIZONS if horizon <= shortest) or (shortest,)


def distances(simulator: Simulator, robot: Robot, runs: Sequence[Run]) -> Distances:
    """Simulate runs from evenly spaced starts, and as a whole."""
    horizons, ends, tools, moves = horizons_of(runs), [], [], []
    starts = list(_starts(runs, horizons[-1]))
    windows = [(run, first, _before(run, run.time[first] + horizons[-1])) for run, first in starts]
    for (run, first, _), simulated in zip(windows, simulator.roll_all(windows), strict=True):
        offsets = [_before(run, run.time[first] + horizon) - first for horizon in horizons]
        rows = np.maximum(offsets, 1) - 1
        real = run.position[first + 1 + rows]
        ends.append(simulated[rows] - real)
        tools.append(_tool_distance(robot, simulated[rows], real))
        moves.append(real - run.position[first])
    whole = simulator.roll_all([(run, 0, len(run.time) - 1) for run in runs])
    traces = tuple(np.vstack([run.position[:1], trace]) for run, trace in zip(runs, whole, strict=True))
    errors = np.concatenate([trace - run.position for trace, run in zip(traces, runs, strict=True)])
    tool_errors = [
        _tool_distance(robot, trace[::STRIDE], run.position[::STRIDE])
        for trace, run in zip(traces, runs, strict=True)
    ]
    return Distances(
        np.array(ends), np.array(tools), _rms(errors), float(_rms(np.concatenate(tool_errors))), traces,
        _rms(np.array(moves)),
    )  # fmt: skip


def _before(run: Run, moment: float) -> int:
    """Index of the last sample up to a moment [s]."""
    return int(np.searchsorted(run.time, moment, side="right")) - 1


STRIDE = 10
"""Spacing of the samples at which the tool point of a whole run is compared."""


def _starts(runs: Sequence[Run], longest: float) -> list[tuple[Run, int]]:
    """Runs and samples from which to simulate, at least a quarter of the longest horizon apart."""
    total = sum(float(run.time[-1] - run.time[0]) - longest for run in runs)
    spacing = max(total / MOST, 0.25 * longest)
    starts = []
    for run in runs:
        moments = np.arange(run.time[0], run.time[-1] - longest + 1e-9, spacing)
        starts += [(run, int(np.searchsorted(run.time, moment))) for moment in moments]
    return starts


def _tool_distance(robot: Robot, simulated: np.ndarray, recorded: np.ndarray) -> np.ndarray:
    """Distance between the tool points at two series of positions (k, n), shape (k,) [m].

    It is 0 for a robot with several chains, such as legs, which has no single tool point.
    """
    if len(set(robot.kinematics.parents)) < robot.dof:
        return np.zeros(len(simulated))
    data = robot.kinematics.createData()
    return np.array(
        [
            np.linalg.norm(
                flange_position(robot.kinematics, robot.flange, a, data)
                - flange_position(robot.kinematics, robot.flange, b, data)
            )
            if np.all(np.isfinite(a))
            else np.inf
            for a, b in zip(simulated, recorded, strict=True)
        ]
    )


def _rms(values: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):
        return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
