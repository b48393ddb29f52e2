"""History: recent samples and commands of a run, from which all safety rules are computed.

Averages over 50 ms suppress noise and encoder steps. Three quarters of a second distinguish joints that creep
from those that swing around their commanded position.
"""

import numpy as np

from exidyn.drivers import Command, Sample
from exidyn.drivers.values import any_of

MEAN = 0.05
"""Averaging window of positions [s]."""
PIECE = 0.25
"""Duration of a piece [s]. A joint that moves in one direction in all pieces has not turned back for more
than half a period at 1 Hz, and no drive's position loop is slower than that."""
PIECES = 3
"""Number of pieces in which a joint must move in the same direction."""
AT_END = 0.5
"""Duration of the straight line whose slope is the residual speed [s]."""


class History:
    """Samples of the last second, and the commands that may still take effect.

    Args:
        joints: Number of joints n.
        cycle: Sampling period [s].
        memory: Number of cycles within which a command may take effect.
    """

    sample: Sample  # last sample

    def __init__(self, joints: int, cycle: float, memory: int) -> None:
        self.sent: Command | None = None  # command sent in the cycle of the last sample
        self.last_command: Command | None = None  # last command of all cycles; None before the first
        # Distance of the measured position from all recent commands, since a delay of the drive is not an
        # error, shape (n,) [rad] or [m]; NaN without commands.
        self.tracking_error = self._unknown = np.full(joints, np.nan)
        self._commands, self._next_command = np.zeros((max(memory, 1), joints)), 0
        self._mean = max(round(MEAN / cycle), 1)
        self._piece = max(round(PIECE / cycle), 1)
        self._end = max(round(AT_END / cycle), 3)
        self._size = max(PIECES * self._piece + self._mean, self._end)
        # Every row of these is stored twice, so that the latest rows are always contiguous.
        self._time, self._filled = np.zeros(2 * self._size), np.zeros((2 * self._size, joints))
        self._measured: list[tuple[int, np.ndarray]] = [(0, self._unknown)] * self._size
        self._count, self._next = 0, 0
        self._silent, self._all_heard = np.zeros(joints), True
        self._known = self._unknown

    @property
    def time(self) -> float:
        """Time of the last sample by the host's clock [s since 1970]."""
        return 1e-9 * self.sample.host_time

    def add(self, sample: Sample, sent: Command | None) -> None:
        """Add a sample and the command sent in its cycle; a pair that was added already is ignored.

        Several rules add the same cycle. A driver that hands out one sample twice hides no command.
        """
        if self._count and sample is self.sample and sent is self.sent:
            return
        self.sample, self.sent = sample, sent
        self._add_position(sample.position)
        self.tracking_error = self._unknown if sent is None else self._distance(sent, sample.position)
        self.last_command = sent or self.last_command

    def _add_position(self, position: np.ndarray) -> None:
        """Store a position (n,); silent joints (NaN) keep their last position in averages."""
        self._measured[self._next] = self.sample.host_time, position
        unheard = np.isnan(position)
        if any_of(unheard):
            position = np.where(unheard, self._known, position)
            self._silent, self._all_heard = np.where(unheard, self._silent + 1, 0), False
        elif not self._all_heard:
            self._silent, self._all_heard = np.zeros(len(position)), True
        self._known = position
        for row in (self._next, self._next + self._size):
            self._time[row], self._filled[row] = self.time, position
        self._next = (self._next + 1) % self._size
        self._count += 1

    def _distance(self, sent: Command, position: np.ndarray) -> np.ndarray:
        if not self._next_command:
            self._commands[:] = sent.position
        self._commands[self._next_command % len(self._commands)] = sent.position
        self._next_command += 1
        below = self._commands.min(axis=0) - position
        return np.maximum(np.maximum(below, position - self._commands.max(axis=0)), 0.0)

    def before(self, cycles: int) -> tuple[int, np.ndarray] | None:
        """Host's time [ns] and measured position (n,) a number of cycles ago; None if there was no sample."""
        if self._count <= cycles:
            return None
        return self._measured[(self._next - 1 - cycles) % self._size]

    def silent(self, cycles: int) -> np.ndarray:
        """Whether each joint has been silent for this number of cycles, shape (n,)."""
        return (self._silent >= cycles) | np.isnan(self._known)

    def directed(self) -> np.ndarray:
        """Whether each joint has moved in the same direction in all of the last pieces, shape (n,)."""
        if self._count < self._size:
            return np.zeros(len(self._known), bool)
        positions = np.array([self.mean(k * self._piece) for k in range(PIECES + 1)])
        direction = np.sign(np.diff(positions, axis=0))
        return (direction != 0.0).all(axis=0) & (direction == direction[0]).all(axis=0)

    def residual_speed(self) -> np.ndarray:
        """Slope of a line fitted to the last positions, shape (n,) [rad/s] or [m/s]; NaN with too few."""
        if self._count < self._end:
            return self._unknown
        rows = self._rows(0, self._end)
        time = self._time[rows] - self._time[rows].mean()
        slope: np.ndarray = time @ self._filled[rows] / max(time @ time, np.finfo(float).tiny)
        return slope

    def mean(self, cycles: int = 0) -> np.ndarray:
        """Averaged position now, or a number of cycles ago, shape (n,) [rad] or [m]."""
        count = min(self._mean, max(self._count - cycles, 1))
        mean: np.ndarray = self._filled[self._rows(cycles, count)].mean(axis=0)
        return mean

    def _rows(self, before: int, count: int) -> slice:
        """Slice of `count` rows, the last of them `before` cycles ago."""
        last = self._next + self._size - before
        return slice(last - count, last)


class Excess:
    """How long each joint has exceeded a limit without interruption; unknown values do not interrupt it."""

    def __init__(self, joints: int) -> None:
        self.count = np.zeros(joints, int)  # number of cycles beyond the limit, shape (n,)
        self.since = np.zeros(joints)  # time of the first of them, shape (n,) [s]
        self.counting = False  # whether any joint exceeds its limit

    def add(self, value: np.ndarray, limit: np.ndarray, time: float, cycles: np.ndarray | int = 1) -> bool:
        """Add the values of a cycle, shape (n,); returns whether a joint exceeds its limit or did until now.

        `cycles` is the number of cycles since the last known value of a joint that exceeds its limit already.
        """
        beyond = value > limit
        if not self.counting and not any_of(beyond):  # the case in nearly all cycles
            return False
        begins = beyond & (self.count == 0)
        self.since = np.where(begins, time, self.since)
        counted = self.count + np.where(begins, 1, cycles)
        self.count = np.where(beyond, counted, np.where(np.isnan(value), self.count, 0))
        self.counting = bool(self.count.any())
        return True
