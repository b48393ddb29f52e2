"""Kept: the cycles of a run in memory, for use when it is over."""

from dataclasses import dataclass

import numpy as np

from ..run.frames import SAMPLE, Unframed, read_cycle
from ..run.player import BRAKING, RUNNING


@dataclass(frozen=True)
class Course:
    """What was commanded and measured while the motion was played, up to the end of a stop.

    Attributes:
        commanded: Positions, shape (t, n) [rad] or [m].
        speed: Commanded velocities, shape (t, n) [rad/s] or [m/s].
        position: Measured, shape (t, n); NaN where a joint was silent.
        velocity: Likewise; NaN where it is not measured.
        current: Shape (t, n) [A].
        torque: Shape (t, n) [N m].
    """

    commanded: np.ndarray
    speed: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    current: np.ndarray
    torque: np.ndarray


class Kept:
    """A sink that keeps every cycle; a jog is short."""

    failure = ""

    def __init__(self) -> None:
        self._frames: list[bytes] = []

    def put(self, frame: bytes) -> None:
        """Keep a frame, and look at it later: the loop has no time."""
        self._frames.append(frame)

    def close(self) -> None:
        """Nothing to do."""

    def course(self) -> Course:
        """What was kept; without cycles where nothing was commanded."""
        frames = Unframed()
        cycles = [read_cycle(body) for kind, body in frames.add(b"".join(self._frames)) if kind == SAMPLE]
        moved = [one for one in cycles if one.stage in (RUNNING, BRAKING)]
        sent = [one for one in moved if np.isfinite(one.array("command_position")).all()]
        names = ("command_position", "command_velocity", "position", "velocity", "current", "torque")
        return Course(*(np.array([one.array(name) for one in sent]) for name in names))
