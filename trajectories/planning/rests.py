"""Rests and moves between them: the parts of motions that stop now and then."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np

from exidyn.identification.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..errors import Infeasible
from ..families.phases import Phases
from ..families.sequence import Sequence
from ..limits.moves import move
from ..trajectory import State, Trajectory, whole_ticks

STEPS = 240
"""Samples of a joint's range in the search for its clear part: over a full turn, 1 m from the axis, the
proven clearance is 1.3 cm less than the true one."""


@dataclass(frozen=True, eq=False)
class Workspace:
    """What a motion keeps to."""

    limits: Limits  # limits, finite except for torque
    tick: float  # sampling period of the controller [s]
    clearances: Collection[Clearance] = ()  # clearances to keep

    def pause(self, pose: np.ndarray, duration: float) -> Phases:
        """Rest at a pose, shape (n,) [rad], for a duration [s] rounded up to a sampling period."""
        return Phases.hold(pose, whole_ticks(duration, self.tick))

    def move(self, start: np.ndarray, target: np.ndarray) -> Phases:
        """The fastest move from rest to rest, both of shape (n,) [rad]; no joint overshoots either pose."""
        return move(State.at_rest(start), State.at_rest(target), self.limits, self.tick)

    def move_clear(self, start: np.ndarray, target: np.ndarray) -> Phases:
        """The move; raises `Infeasible` if it collides, with the obstacle and the distance."""
        motion = self.move(start, target)
        self.require_clear("the move between two poses", motion)
        return motion

    def require_clear(self, motion_name: str, motion: Trajectory) -> None:
        """Raise `Infeasible` unless a motion keeps every clearance at all times."""
        for clearance in self.clearances:
            nearest = clearance.worst(motion)
            if not nearest.allowed:
                raise Infeasible(
                    f"{motion_name}: {nearest.name} misses its safety margin by {-nearest.bound:.4g} m after "
                    f"{nearest.time:.3g} s. Try other poses, a smaller range, or a smaller safety margin"
                )

    def require_clear_pose(self, pose: np.ndarray) -> None:
        """Raise `Infeasible` unless a pose, shape (n,) [rad], keeps every clearance."""
        self.require_clear("the pose", Phases.hold(pose, 0.0))

    def clear_range(self, pose: np.ndarray, joint: int) -> tuple[float, float]:
        """Range of one joint around a pose without contact while the other joints rest [rad].

        The range is proven between samples too. Over a step s a margin falls by at most reach times s. So no
        margin is negative between two samples if all margins at both are at least half of that.

        Raises:
            Infeasible: The pose itself does not keep a clearance.
        """
        self.require_clear_pose(pose)
        bounds = self.limits.position_lower[joint], self.limits.position_upper[joint]
        lower, upper = (self._clear_until(pose, joint, bound) for bound in bounds)
        return lower, upper

    def _clear_until(self, pose: np.ndarray, joint: int, bound: float) -> float:
        """The position closest to a bound up to which the range is proven clear."""
        positions = np.tile(pose, (STEPS + 1, 1))
        positions[:, joint] = np.linspace(pose[joint], bound, STEPS + 1)
        step = abs(bound - pose[joint]) / STEPS
        travel = np.maximum(np.abs(self.limits.position_lower), np.abs(self.limits.position_upper))
        clear = np.ones(STEPS + 1, bool)
        for clearance in self.clearances:
            needed = 0.5 * step * clearance.reach(travel)[:, joint]
            clear &= np.all(clearance.margins(positions) >= needed, axis=1)
        last = STEPS if np.all(clear) else int(np.argmin(clear)) - 1
        return float(positions[max(last, 0), joint])


def joined(parts: Iterable[Trajectory]) -> Sequence:
    """The parts that take time, one after another."""
    return Sequence(tuple(part for part in parts if part.duration > 0.0))
