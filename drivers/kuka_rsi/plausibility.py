"""Plausibility: detects measurements that cannot belong to the cycle of their time stamp.

A telegram may repeat the previous measurement under a new stamp. An arm at rest also repeats positions, so a
repetition counts only where it cannot be true: an axis was moving, and all positions and all motor currents,
which are noisy, repeat to the last digit. A position may also leap further than any axis can move.

A single position that repeats while its axis should move is no proof, because a brake or an obstacle can hold
the axis. The tracking error reveals this case.
"""

from collections.abc import Sequence

import numpy as np

FASTEST = 3000.0
"""Velocity that no axis reaches [deg/s]: three times that of the last axis of KUKA's smallest arms."""
STEPS = 10
"""Motion in a cycle above which an axis is moving, in steps of the sent positions: at rest, rounding causes
one step, and noise some more."""
ALIVE = 100
"""Number of consecutive measurements in which a current must have changed; then less than 1 % of its values
repeat by chance."""
WITNESSES = 3
"""Number of such currents that must all repeat: by chance, this happens in less than one telegram in a
million. A current of zero does not count, because a drive that is off repeats it."""


class Plausibility:
    """Finds the axes whose measurement in a telegram cannot belong to its cycle [s].

    `effort` are the columns of the currents and of the torques, None if they are not sent, and `step` is the
    resolution of the positions [deg].
    """

    def __init__(
        self,
        axes: Sequence[str],
        position: slice,
        effort: tuple[slice | None, slice | None],
        step: float,
        cycle: float,
    ) -> None:
        self._axes, self._step, self._cycle = axes, step, cycle
        current, torque = effort
        self._position, self._current = position, current or slice(0, 0)
        self._columns = [columns for columns in (position, current, torque) if columns is not None]
        self._before = np.zeros(0)  # the whole measurement
        self._moving, self._changes = False, np.zeros(0)
        self._last, self._since = np.zeros(0), np.zeros(len(axes))  # plausible positions, cycles since
        self._leapt = np.zeros(len(axes), bool)
        self._repeats, self._reported = 0, 1
        self._messages: list[str] = []

    def implausible(self, numbers: np.ndarray, cycles: int) -> np.ndarray:
        """Axes whose measurement is implausible, shape (n,), `cycles` after the previous telegram."""
        position, current = numbers[self._position], numbers[self._current]
        measured = np.concatenate([numbers[columns] for columns in self._columns])
        if self._before.size == 0:
            self._before, self._last, self._changes = measured, position, np.zeros(len(current))
            return self._leapt
        changed, self._before = measured != self._before, measured
        self._since = self._since + cycles
        if changed.any():
            changed_current = changed[len(position) : len(position) + len(current)]
            self._changes = np.where(changed_current, self._changes + 1.0, 0.0)
        elif self._repeated(current):
            return np.ones(len(position), bool)
        return self._leaps(position)

    def events(self) -> tuple[str, ...]:
        """Events since the last call, a sentence each."""
        messages, self._messages = tuple(self._messages), []
        return messages

    def _repeated(self, current: np.ndarray) -> bool:
        """Whether a measurement that repeats the previous telegram cannot be true."""
        witnesses = np.count_nonzero((self._changes >= ALIVE) & (current != 0.0))
        if not self._moving or witnesses < WITNESSES:
            return False
        self._repeats += 1
        if self._repeats == self._reported:
            self._reported *= 10
            self._messages.append(
                f"the controller sent an old measurement under a new time stamp ({self._repeats} so far): "
                "positions and motor currents repeat to the last digit while the arm moves"
            )
        return True

    def _leaps(self, position: np.ndarray) -> np.ndarray:
        """Axes that are further from their last plausible position than they can move, shape (n,)."""
        distance = np.abs(position - self._last)
        leapt = distance > FASTEST * self._cycle * self._since + self._step
        self._moving = bool((distance[~leapt] >= STEPS * self._step).any())
        for axis in map(int, np.flatnonzero(leapt & ~self._leapt)):
            self._messages.append(
                f"{self._axes[axis]} is {distance[axis]:.3g} degrees from where it was "
                f"{1e3 * self._cycle * self._since[axis]:.3g} ms before, which no axis moves: its values are "
                "not used until it is back"
            )
        self._last = np.where(leapt, self._last, position)
        self._since = np.where(leapt, self._since, 0.0)
        self._leapt = leapt
        return leapt
