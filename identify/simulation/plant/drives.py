"""Drives: the path between commands, the usual cascade of control loops, and the arm's motion under it.

A proportional position loop outputs a velocity, to which the commanded velocity is added; a velocity loop
with proportional and integral gain outputs the torque. The current loop and the drive's own cycle of some
hundred microseconds are much faster than both, and are left out. The equations of motion are integrated in
steps of a fraction of a millisecond.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...errors import RobotError
from . import steps
from .steps import Cascade, Elastic, Forces, Moved, compiled

FEED_FORWARD = 0.95
"""Share of the commanded velocity that usual drives add to the output of the position loop [-]."""
SERVO_LAG = 1e-4
"""Lag of a cascade that represents a servo without damping [s]: a tenth of a step, so that the velocity loop
has hardly any effect."""


class Cut(NamedTuple):
    """Division of a command period into blocks and steps, with the interpolation between its two ends."""

    seconds: float  # command period [s]
    step: float  # duration of a step [s]
    steps: int  # number of steps per block
    blocks: int  # number of blocks per period
    # Matrix, shape (rows, 4), that maps position and velocity at the start and at the end of the period to
    # positions. Its rows are the steps, each the mean of both its ends, so that it matches the torque in
    # between; then the middles of the blocks; then their ends.
    position: np.ndarray
    velocity: np.ndarray  # matrix of shape (rows, 4) for velocities at the same times

    @classmethod
    def of(cls, seconds: float, longest_step: float, longest_block: float) -> "Cut":
        """The division into the smallest number of equal blocks and steps that are short enough."""
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
        """Rows of a block: its steps, its middle as a slice of one row, and its end."""
        first, middle = block * self.steps, self.blocks * self.steps + block
        return slice(first, first + self.steps), slice(middle, middle + 1), middle + self.blocks


def _fewest(duration: float, longest: float) -> int:
    return max(int(np.ceil(duration / longest - 1e-6)), 1)


class CommandPath:
    """Cubic polynomials between commands, from rest at a start (n,) [rad], continuous up to velocity."""

    def __init__(self, start: np.ndarray) -> None:
        self._before = self._position = start
        self._velocity = np.zeros(len(start))

    def along(
        self, position: np.ndarray, velocity: np.ndarray | None, cut: Cut
    ) -> tuple[np.ndarray, np.ndarray]:
        """Positions and velocities on the path to the next commands (t, n), each (t, rows of the cut, n).

        Without commanded velocities, they are differentiated from the last three positions, as in drives that
        receive only positions.
        """
        if velocity is None:
            positions = np.concatenate([[self._before, self._position], position])
            velocity = (1.5 * positions[2:] - 2.0 * positions[1:-1] + 0.5 * positions[:-2]) / cut.seconds
        ends = np.empty((len(position), 4, position.shape[1]))
        ends[0, 0], ends[1:, 0] = self._position, position[:-1]
        ends[0, 1], ends[1:, 1] = self._velocity, velocity[:-1]
        ends[:, 2], ends[:, 3] = position, velocity
        self._before, _, self._position, self._velocity = ends[-1]
        return cut.position @ ends, cut.velocity @ ends


@dataclass(frozen=True, eq=False)
class DriveControl:
    """Gains of each motor's cascade and limits of its amplifier, all on the joint side."""

    position_gain: np.ndarray  # velocity per position error, shape (n,) [1/s]
    velocity_gain: np.ndarray  # torque per velocity error, shape (n,) [N m s/rad]
    # Integral gain of the velocity loop, the reciprocal of its reset time, shape (n,) [1/s]; zero for none.
    integral_gain: np.ndarray
    # Share of the commanded velocity that is added to the output of the position loop [-].
    feed_forward: float
    current_limit: np.ndarray  # maximum current, shape (n,) [A]
    # Current at which magnetic saturation has reduced the torque per current to 71 %, shape (n,) [A];
    # infinite for a constant gain.
    saturation: np.ndarray

    def __post_init__(self) -> None:
        for name in ("position_gain", "velocity_gain", "integral_gain", "current_limit", "saturation"):
            value = np.asarray(getattr(self, name), float)
            valid = np.all(value >= 0.0) if name == "integral_gain" else np.all(value > 0.0)
            if value.shape != np.shape(self.position_gain) or not valid:
                raise RobotError(
                    f"drive control: {name} is {value}; expected one number per joint, all above 0"
                )
            object.__setattr__(self, name, value)

    @classmethod
    def tuned(cls, inertia: np.ndarray, bandwidth: float, current_limit: np.ndarray) -> "DriveControl":
        """A cascade for joints of some inertia, each loop five times as fast as the one around it.

        The inertia is what each motor moves, on the joint side, shape (n,) [kg m^2]. The bandwidth is that of
        the velocity loop [Hz]. The current limit is (n,) [A]; there is no saturation.
        """
        speed = np.full(len(inertia), 2 * np.pi * bandwidth)
        unsaturated = np.full(len(inertia), np.inf)
        return cls(speed / 5, inertia * speed, speed / 5, FEED_FORWARD, current_limit, unsaturated)

    @classmethod
    def position_servo(cls, stiffness: np.ndarray, current_limit: np.ndarray) -> "DriveControl":
        """A servo with stiffness (n,) [N m/rad] against position errors, up to a current limit (n,) [A].

        Any damping of such a servo is part of the joint's viscous friction.
        """
        none, position_gain = np.zeros(len(stiffness)), np.full(len(stiffness), 1.0 / SERVO_LAG)
        return cls(position_gain, stiffness * SERVO_LAG, none, 0.0, current_limit, none + np.inf)

    @cached_property
    def _saturates(self) -> bool:
        return bool(np.any(np.isfinite(self.saturation)))

    def torque_limit(self, gain: np.ndarray) -> np.ndarray:
        """Maximum torque of each motor, on the joint side, shape (n,) [N m]."""
        tightness = np.hypot(1.0 / self.current_limit, 1.0 / self.saturation)
        return np.abs(gain) / np.maximum(tightness, 1e-200)  # no limit is represented by a very large one

    def current(self, torque: np.ndarray, gain: np.ndarray) -> np.ndarray:
        r"""Current that produces a torque, :math:`\tau = K i / \sqrt{1 + (i / i_s)^2}`, shape (n,) [A]."""
        linear = torque / gain
        if not self._saturates:
            return linear
        return linear / np.sqrt(1.0 - (linear / self.saturation) ** 2)


class Servo:
    """The cascade, linear in position, velocity and integral up to its torque limit, for implicit steps.

    `gain` is the torque per current (n,) [N m/A]. The coupling (n, n) maps joint motion to motor motion, and
    `motors` (n, x) the plant's coordinates to motor positions on the joint side.
    """

    def __init__(
        self, control: DriveControl, gain: np.ndarray, coupling: np.ndarray, motors: np.ndarray
    ) -> None:
        self._by_position = coupling.T * control.position_gain
        self._by_velocity = coupling.T * control.feed_forward
        self.turns = coupling @ motors
        self.position_gain, self.integral_gain = control.position_gain, control.integral_gain
        self.velocity_gain = control.velocity_gain
        self.limit = control.torque_limit(gain)
        self._torque, self._now = compiled(steps.torque), tuple(self.over(0.0))

    def over(self, step: float) -> Cascade:
        """The cascade over a step of some duration [s]."""
        stiff = self.velocity_gain * (1.0 + 0.5 * step * self.integral_gain)
        lag = 0.5 * step + 0.25 * step**2 * self.position_gain
        transposed = self.turns.T.copy()
        return Cascade(
            turns=self.turns,
            transposed=transposed,
            by_position=self.position_gain[:, None] * self.turns,
            stiff=stiff,
            integral_stiffness=self.velocity_gain * self.integral_gain,
            lag=lag,
            added_inertia=(transposed * (stiff * lag)) @ self.turns,
            limit=self.limit,
        )

    def release(self) -> None:
        """Switch off the torque."""
        self.velocity_gain = np.zeros_like(self.velocity_gain)
        self._now = tuple(self.over(0.0))

    def reference(self, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Reference of the loops, one number per motor, for commands (t, n), shape (t, n) [rad/s]."""
        return velocity @ self._by_velocity + position @ self._by_position

    def torque(self, reference: np.ndarray, moved: Moved) -> np.ndarray:
        """Torque of each motor at one instant, on the joint side, shape (n,) [N m]."""
        torque: np.ndarray = self._torque(self._now, reference, tuple(moved))
        return torque

    def integral_for(self, torque: np.ndarray) -> np.ndarray:
        """Integral at which the motors hold a torque (n,) [N m] without position or velocity error."""
        gain = self.velocity_gain * self.integral_gain
        return np.divide(torque, gain, out=np.zeros_like(torque), where=gain > 0.0)

    def error_for(self, torque: np.ndarray) -> np.ndarray:
        """Position error (n,) [rad] at which motors without integral gain hold a torque (n,) [N m]."""
        stiffness = self.velocity_gain * self.position_gain
        return np.where(self.integral_gain > 0.0, 0.0, torque / stiffness)


class State(NamedTuple):
    """State of the arm in the plant's coordinates, and of its servo.

    It holds position (x,) [rad], velocity (x,) [rad/s], acceleration over the last step (x,) [rad/s^2], and
    the integral of each motor's velocity error (n,) [rad].
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    integral: np.ndarray


Steps = Callable[[State, np.ndarray, Forces, Forces, np.ndarray], State]


def stepping(servo: Servo, springs: Elastic, step: float) -> Steps:
    """Function that makes steps of some duration [s] and returns the state after them.

    Its arguments are the initial state, the inertia (x, x) [kg m^2], the forces around that state and around
    a predicted final state, between which they are interpolated, and the servo's reference in the middle of
    each step, shape (k, n) [rad/s]. It raises `RobotError` for an arm without inertia.
    """
    through, constants = compiled(steps.through), (step, tuple(servo.over(step)), tuple(springs))

    def make(state: State, inertia: np.ndarray, start: Forces, end: Forces, reference: np.ndarray) -> State:
        return State(*through(*constants, tuple(state), inertia, tuple(start), tuple(end), reference))

    return make
