"""Phases: a motion of piecewise constant jerk, as a jerk-limited controller produces it."""

from dataclasses import dataclass

import numpy as np

from ..errors import BadLimits
from ..trajectory import Extremes, Range, State, States, Trajectory, lowest_and_highest


@dataclass(frozen=True, eq=False)
class Phases(Trajectory):
    """A motion of k pieces of constant jerk."""

    start: np.ndarray  # time at which each piece begins, the first at zero, shape (k,) [s]
    end: float  # time at which the last piece ends [s]
    position: np.ndarray  # position at the start of each piece, shape (k, n) [rad]
    velocity: np.ndarray  # velocity at the start of each piece, shape (k, n) [rad/s]
    acceleration: np.ndarray  # acceleration at the start of each piece, shape (k, n) [rad/s^2]
    jerk: np.ndarray  # jerk during each piece, shape (k, n) [rad/s^3]

    def __post_init__(self) -> None:
        states = (self.position, self.velocity, self.acceleration, self.jerk)
        shapes = sorted({np.shape(part) for part in states})
        if shapes != [(len(self.start), self.dof)] or len(self.start) == 0:
            raise BadLimits(f"Phases: {len(self.start)} starts, states of shapes {shapes}; expected (k, n)")
        times = np.append(self.start, self.end)
        if times[0] != 0.0 or not np.all(np.diff(times) >= 0.0) or not np.isfinite(self.end):
            raise BadLimits(
                f"Phases: pieces begin at {self.start} s and end at {self.end:g} s; "
                "times must start at 0 and not decrease"
            )

    @classmethod
    def hold(cls, position: np.ndarray, duration: float) -> "Phases":
        """Rest at a position, shape (n,) [rad]."""
        return cls.of_jerks(State.at_rest(position), np.array([duration]), np.zeros((1, len(position))))

    @classmethod
    def of_jerks(cls, start_state: State, durations: np.ndarray, jerks: np.ndarray) -> "Phases":
        """Motion from a state with the duration of each piece, (k,) [s], and its jerk, (k, n) [rad/s^3]."""
        durations = np.asarray(durations, float)
        state, states = start_state, []
        for duration, jerk in zip(durations, jerks, strict=True):
            states.append(state)
            state = State(*integrated(duration, *state, jerk))
        position, velocity, acceleration = np.moveaxis(np.array(states, float), 0, 1)
        switches = np.concatenate([[0.0], np.cumsum(durations)])
        return cls(
            switches[:-1], float(switches[-1]), position, velocity, acceleration, np.asarray(jerks, float)
        )

    @property
    def duration(self) -> float:
        return self.end

    @property
    def dof(self) -> int:
        return int(np.shape(self.position)[-1])

    @property
    def end_state(self) -> State:
        """State at the end."""
        return self.state_at(self.end)

    def at(self, time: np.ndarray) -> States:
        """States at times of shape (t,) [s]; at a switch the jerk is that of the piece that begins there."""
        time = self.inside(time)
        piece = np.searchsorted(self.start, time, side="right") - 1
        jerk = self.jerk[piece]
        since = (time - self.start[piece])[:, None]
        states = integrated(since, self.position[piece], self.velocity[piece], self.acceleration[piece], jerk)
        return States(time, *states, jerk)

    def extremes(self) -> Extremes:
        durations = np.diff(np.append(self.start, self.end))[:, None] + np.zeros((1, self.dof))
        begin = np.zeros_like(durations)
        turns = np.stack(
            [begin, durations, *_quadratic_roots(0.5 * self.jerk, self.acceleration, self.velocity)]
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            peak = np.stack([begin, durations, -self.acceleration / self.jerk])
        turns, peak = (
            np.where((0.0 < candidate) & (candidate < durations), candidate, durations)
            for candidate in (turns, peak)
        )
        turns[0] = peak[0] = 0.0  # the start of a piece is a candidate even if its duration is zero
        ends = np.stack([begin, durations])
        state = (self.position, self.velocity, self.acceleration, self.jerk)
        return Extremes(
            self._range(turns, integrated(turns, *state)[0]),
            self._range(peak, integrated(peak, *state)[1]),
            self._range(ends, integrated(ends, *state)[2]),
            self._range(begin[None], self.jerk[None]),
        )

    def _range(self, since: np.ndarray, value: np.ndarray) -> Range:
        """Smallest and largest of candidates `since` the start of each piece, both (candidates, k, n)."""
        time = (since + self.start[:, None]).reshape(-1, self.dof)
        value = value.reshape(-1, self.dof)
        return lowest_and_highest(value, value, time, time)


def integrated(
    since: np.ndarray | float,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    jerk: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration a time `since` a state, under constant jerk; shapes broadcast."""
    return (
        position + since * (velocity + since * (acceleration / 2 + since * jerk / 6)),
        velocity + since * (acceleration + since * jerk / 2),
        acceleration + since * jerk,
    )


def _quadratic_roots(square: np.ndarray, linear: np.ndarray, constant: np.ndarray) -> np.ndarray:
    """Both roots of square x^2 + linear x + constant, shape (2, ...); NaN or infinite if there is none.

    The formula adds two numbers of the same sign, so that nothing cancels if `square` is small or zero.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        discriminant = np.sqrt(linear**2 - 4 * square * constant)
        half = -0.5 * (linear + np.where(linear < 0, -discriminant, discriminant))
        return np.stack([half / square, constant / half])
