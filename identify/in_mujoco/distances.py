"""Distance between simulation and recording, some time after a common start and over whole runs.

Two simulations are compared by it, at the tool point or at the joints.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

from ..arm.newton_euler import flange_position
from ..arm.robot import Robot
from .replay import Run, Simulator

SURE = 1.64
"""Number of standard errors by which a mean has changed with 95 % confidence (one-sided)."""
MATERIAL = 0.05
"""Share of the rms error below which a change makes no difference in practice."""
ON_AXIS = 1e-9
"""Distance of tool points that is only rounding [m]."""
TOOL, JOINTS = "tool", "joints"
"""What a simulation is judged by."""
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
    for (run, first, _), simulated in zip(windows, simulator.roll(windows), strict=True):
        offsets = [_before(run, run.time[first] + horizon) - first for horizon in horizons]
        rows = np.maximum(offsets, 1) - 1
        real = run.position[first + 1 + rows]
        ends.append(simulated[rows] - real)
        tools.append(_tool_distance(robot, simulated[rows], real))
        moves.append(real - run.position[first])
    whole = simulator.roll([(run, 0, len(run.time) - 1) for run in runs])
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


class Gain(Enum):
    """Change of a simulation relative to the recordings."""

    BETTER = "better"
    SAME = "same"
    WORSE = "worse"


@dataclass(frozen=True)
class Judge:
    """Comparison of simulations."""

    by: str = TOOL  # `TOOL` or `JOINTS`; the joints also judge if the tool point lies on all of their axes

    def compared(self, first: Distances, second: Distances) -> Gain:
        """Whether the second simulation is nearer to the recordings than the first.

        It is nearer, or farther, if its mean squared error over all starts has changed with 95 % confidence,
        and its rms error by more than `MATERIAL`.
        """
        before, after = self._squares(first, first), self._squares(second, first)
        converged = [bool(np.all(np.isfinite(squares))) for squares in (before, after)]
        if not any(converged):
            return Gain.SAME
        if not all(converged):
            return Gain.WORSE if converged[0] else Gain.BETTER
        growth = after - before
        spread = float(np.std(growth)) / np.sqrt(len(growth))
        ratio = np.sqrt(float(np.mean(after)) / max(float(np.mean(before)), np.finfo(float).tiny))
        if abs(float(np.mean(growth))) <= SURE * spread or abs(ratio - 1.0) < MATERIAL:
            return Gain.SAME
        return Gain.BETTER if ratio < 1.0 else Gain.WORSE

    def _squares(self, distances: Distances, reference: Distances) -> np.ndarray:
        """Mean squared error of each start, relative to that of the reference, shape (w,)."""
        if self.by == TOOL and np.any(reference.tools > ON_AXIS):
            return np.asarray(np.mean((distances.tools / _scale(reference.tools)) ** 2, axis=1))
        joints = np.arange(distances.ends.shape[2])
        errors, scale = (of.ends[:, reference.telling, joints] for of in (distances, reference))
        return np.asarray(np.mean((errors / _scale(scale)) ** 2, axis=1))


def _scale(errors: np.ndarray) -> np.ndarray:
    """Rms of errors (w, k) over the starts, shape (k,); 1 where it is zero or infinite."""
    with np.errstate(over="ignore", invalid="ignore"):
        rms = np.sqrt(np.mean(errors**2, axis=0))
    return np.where(np.isfinite(rms) & (rms > 0.0), rms, 1.0)
