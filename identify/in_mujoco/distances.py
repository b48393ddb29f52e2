"""How far simulation and recording part: after some time from where both were alike, and in the whole run."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arm.newton_euler import flange_position
from ..arm.robot import Robot
from .replay import Run, Simulator

HORIZONS = (0.1, 0.5, 2.0)
"""After which both are compared [s]."""
MOST = 40
"""Starts in all runs together: of rms errors, which vary by their size, they leave a tenth open."""


class Distances(NamedTuple):
    """Between simulation and recordings; n joints, h horizons, w starts.

    Attributes:
        ends: Simulated less recorded position after each horizon, shape (w, h, n) [rad]; infinite where
            the simulation has diverged.
        tools: Distance of the tool points then, shape (w, h) [m].
        whole: Root mean square over whole runs, shape (n,) [rad].
        whole_tool: Of the tool points, [m].
        traces: What each whole run did in simulation, (t, n) each [rad].
        moved: How far the real joints have moved after each horizon, root mean square, shape (h, n) [rad].
    """

    ends: np.ndarray
    tools: np.ndarray
    whole: np.ndarray
    whole_tool: float
    traces: tuple[np.ndarray, ...]
    moved: np.ndarray

    @property
    def telling(self) -> np.ndarray:
        """The longest horizon, by place, after which each joint is still told from one at rest, shape (n,).

        Once a simulation is farther off than a joint that had stayed where it was, how far says nothing: so
        it is with torque as the command, which holds no arm anywhere. The shortest, where none is.
        """
        told = self.joints < self.moved
        return np.where(told, np.arange(len(told))[:, None], 0).max(axis=0)

    @property
    def joints(self) -> np.ndarray:
        """Root mean square after each horizon, shape (h, n) [rad]."""
        return _rms(self.ends)

    @property
    def tool(self) -> np.ndarray:
        """The same of the tool point, shape (h,) [m]."""
        return _rms(self.tools)


def horizons_of(runs: Sequence[Run]) -> tuple[float, ...]:
    """Those that the shortest run has room for; its length where it has for none."""
    shortest = min(float(run.time[-1] - run.time[0]) for run in runs)
    return tuple(one for one in HORIZONS if one <= shortest) or (shortest,)


def distances(simulator: Simulator, robot: Robot, runs: Sequence[Run]) -> Distances:
    """Simulate runs from starts evenly in them, and as a whole."""
    horizons, ends, tools, moves = horizons_of(runs), [], [], []
    for run, first in _starts(runs, horizons[-1]):
        last = int(np.searchsorted(run.time, run.time[first] + horizons[-1], side="right")) - 1
        seen = simulator.roll(run, first, last)
        rows = [
            int(np.searchsorted(run.time, run.time[first] + one, side="right")) - 1 - first
            for one in horizons
        ]
        places = np.maximum(rows, 1) - 1
        real = run.position[first + 1 + places]
        ends.append(seen[places] - real)
        tools.append(_apart(robot, seen[places], real))
        moves.append(real - run.position[first])
    traces = tuple(np.vstack([run.position[:1], simulator.roll(run, 0, len(run.time) - 1)]) for run in runs)
    missed = np.concatenate([trace - run.position for trace, run in zip(traces, runs, strict=True)])
    far = [
        _apart(robot, trace[::STRIDE], run.position[::STRIDE])
        for trace, run in zip(traces, runs, strict=True)
    ]
    return Distances(
        np.array(ends), np.array(tools), _rms(missed), float(_rms(np.concatenate(far))), traces,
        _rms(np.array(moves)),
    )  # fmt: skip


STRIDE = 10
"""Samples from one to the next at which the tool point of a whole run is compared."""


def _starts(runs: Sequence[Run], longest: float) -> list[tuple[Run, int]]:
    """Runs and samples from which to simulate, no closer than a quarter of the longest horizon."""
    total = sum(float(run.time[-1] - run.time[0]) - longest for run in runs)
    each = max(total / MOST, 0.25 * longest)
    found = []
    for run in runs:
        moments = np.arange(run.time[0], run.time[-1] - longest + 1e-9, each)
        found += [(run, int(np.searchsorted(run.time, moment))) for moment in moments]
    return found


def _apart(robot: Robot, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Distance of the tool points at two positions (k, n), shape (k,) [m]."""
    data = robot.kinematics.createData()
    return np.array(
        [
            np.linalg.norm(
                flange_position(robot.kinematics, robot.flange, a, data)
                - flange_position(robot.kinematics, robot.flange, b, data)
            )
            if np.all(np.isfinite(a))
            else np.inf
            for a, b in zip(one, other, strict=True)
        ]
    )


def _rms(values: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):
        return np.asarray(np.sqrt(np.mean(values**2, axis=0)))
