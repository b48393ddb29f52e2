"""Command path: where the drives go between one command and the next."""

from typing import NamedTuple

import numpy as np


class Cut(NamedTuple):
    """How a tick is cut, and what position and velocity are there out of both ends'.

    Attributes:
        seconds: Of the tick [s].
        step: [s].
        steps: Steps a block.
        blocks: Blocks a tick.
        position: Shape (rows, 4): means of both ends of each step, so that the torque at those ends is what
            acted in between; then middles of the blocks; then their ends. Out of position and velocity at
            the start, and at the end.
        velocity: Shape (rows, 4).
    """

    seconds: float
    step: float
    steps: int
    blocks: int
    position: np.ndarray
    velocity: np.ndarray

    @classmethod
    def of(cls, seconds: float, longest_step: float, longest_block: float) -> "Cut":
        """The fewest equal blocks and steps of a tick that are short enough."""
        blocks = _fewest(seconds, longest_block)
        steps = _fewest(seconds / blocks, longest_step)
        s = np.linspace(0.0, 1.0, blocks * steps + 1)
        position = [2 * s**3 - 3 * s**2 + 1, seconds * (s**3 - 2 * s**2 + s), 3 * s**2 - 2 * s**3]
        velocity = [6 * (s**2 - s) / seconds, 3 * s**2 - 4 * s + 1, 6 * (s - s**2) / seconds]
        position += [seconds * (s**3 - s**2)]
        velocity += [3 * s**2 - 2 * s]
        rows = []
        for curves in (position, velocity):
            ends = np.stack(curves, axis=1)
            means = 0.5 * (ends[:-1] + ends[1:])
            middles = 0.5 * (means[(steps - 1) // 2 :: steps] + means[steps // 2 :: steps])
            rows.append(np.concatenate([means, middles, ends[steps::steps]]))
        return cls(seconds, seconds / (blocks * steps), steps, blocks, *rows)

    def split(self, block: int) -> tuple[slice, slice, int]:
        """Rows of a block: its steps, its middle as a piece of one, its end."""
        first, middle = block * self.steps, self.blocks * self.steps + block
        return slice(first, first + self.steps), slice(middle, middle + 1), middle + self.blocks


def _fewest(length: float, longest: float) -> int:
    return max(int(np.ceil(length / longest - 1e-6)), 1)


class CommandPath:
    """Cubics from command to command, along which position and velocity are continuous.

    Args:
        start: Where the arm stands, shape (n,) [rad].
    """

    def __init__(self, start: np.ndarray) -> None:
        self._before = self._position = start
        self._velocity = np.zeros(len(start))

    def along(
        self, position: np.ndarray, velocity: np.ndarray | None, cut: Cut
    ) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities on the way to the next commands (t, n), each (t, rows of the cut, n).

        Without velocities they are taken from the last three positions, as drives do that get positions only.
        """
        if velocity is None:
            places = np.concatenate([[self._before, self._position], position])
            velocity = (1.5 * places[2:] - 2.0 * places[1:-1] + 0.5 * places[:-2]) / cut.seconds
        ends = np.empty((len(position), 4, position.shape[1]))
        ends[0, 0], ends[1:, 0] = self._position, position[:-1]
        ends[0, 1], ends[1:, 1] = self._velocity, velocity[:-1]
        ends[:, 2], ends[:, 3] = position, velocity
        self._before, _, self._position, self._velocity = ends[-1]
        return cut.position @ ends, cut.velocity @ ends
