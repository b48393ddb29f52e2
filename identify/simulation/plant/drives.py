"""Drives: the cascade that nearly every industrial drive has, and the arm's motion under it.

A position loop with proportional gain gives a velocity, to which the command's is added; a velocity loop with
proportional and integral gain gives the torque. The current loop and the drive's own cycle, some hundred
microseconds, are much faster than both and left out. The equations of motion go on by a fraction of a
millisecond at a time.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...errors import RobotError
from . import steps
from .steps import Cascade, Elastic, Forces, Moved, compiled, solve


@dataclass(frozen=True, eq=False)
class DriveControl:
    """Gains of each motor's cascade, and what its amplifier can do; motors are seen from the joints.

    Attributes:
        position_gain: Velocity per position error, shape (n,) [1/s].
        velocity_gain: Torque per velocity error, shape (n,) [N m s/rad].
        integral_gain: Of the velocity loop, the reciprocal of its reset time, shape (n,) [1/s].
        feed_forward: Share of the commanded velocity that is added to the position loop's [-].
        current_limit: Largest current, shape (n,) [A].
        saturation: Current at which iron is so saturated that the torque per current has fallen to 71 %,
            shape (n,) [A]; infinite for a constant gain.
    """

    position_gain: np.ndarray
    velocity_gain: np.ndarray
    integral_gain: np.ndarray
    feed_forward: float
    current_limit: np.ndarray
    saturation: np.ndarray

    def __post_init__(self) -> None:
        for name in ("position_gain", "velocity_gain", "integral_gain", "current_limit", "saturation"):
            value = np.asarray(getattr(self, name), float)
            if value.shape != np.shape(self.position_gain) or not np.all(value > 0.0):
                raise RobotError(
                    f"drive control: {name} is {value}; expected one number a joint, all above 0"
                )
            object.__setattr__(self, name, value)

    @classmethod
    def tuned(
        cls,
        inertia: np.ndarray,
        bandwidth: float,
        current_limit: np.ndarray,
        feed_forward: float = 0.95,
        saturation: np.ndarray | None = None,
    ) -> "DriveControl":
        """A cascade for joints of given inertia, each loop five times as fast as the one around it.

        Args:
            inertia: That each motor moves, seen from its joint, shape (n,) [kg m^2].
            bandwidth: Of the velocity loop [Hz].
            current_limit: Shape (n,) [A].
            feed_forward: Share of the commanded velocity [-].
            saturation: Shape (n,) [A]; none by default.
        """
        speed = np.full(len(inertia), 2 * np.pi * bandwidth)
        saturation = np.full(len(inertia), np.inf) if saturation is None else saturation
        return cls(speed / 5, inertia * speed, speed / 5, feed_forward, current_limit, saturation)

    @cached_property
    def _saturates(self) -> bool:
        return bool(np.any(np.isfinite(self.saturation)))

    def torque_limit(self, gain: np.ndarray) -> np.ndarray:
        """Largest torque of each motor, seen from its joint, shape (n,) [N m]."""
        tightness = np.hypot(1.0 / self.current_limit, 1.0 / self.saturation)
        return np.abs(gain) / np.maximum(tightness, 1e-200)  # no limit at all is a very large one

    def current(self, torque: np.ndarray, gain: np.ndarray) -> np.ndarray:
        r"""Current that makes a torque, :math:`\tau = K i / \sqrt{1 + (i / i_s)^2}`, shape (n,) [A]."""
        linear = torque / gain
        if not self._saturates:
            return linear
        return linear / np.sqrt(1.0 - (linear / self.saturation) ** 2)


class Servo:
    """Linear in position, velocity and integral up to the torque limit, so that a step can be implicit in it.

    Args:
        control: Gains.
        gain: Torque per current, shape (n,) [N m/A].
        coupling: Motors' motion out of the joints', shape (n, n) [-].
        motors: Joint positions, as the motors have them, out of the plant's coordinates, shape (n, x).
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
        """What it is to a step of some length [s]."""
        stiff = self.velocity_gain * (1.0 + 0.5 * step * self.integral_gain)
        lag = 0.5 * step + 0.25 * step**2 * self.position_gain
        back = self.turns.T.copy()
        return Cascade(
            turns=self.turns,
            back=back,
            by_position=self.position_gain[:, None] * self.turns,
            stiff=stiff,
            kept=self.velocity_gain * self.integral_gain,
            lag=lag,
            held=(back * (stiff * lag)) @ self.turns,
            limit=self.limit,
        )

    def release(self) -> None:
        """Take the torque away."""
        self.velocity_gain = np.zeros_like(self.velocity_gain)
        self._now = tuple(self.over(0.0))

    def reference(self, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """What the loops are to follow, in one number a motor, for commands (t, n); shape (t, n) [rad/s]."""
        return velocity @ self._by_velocity + position @ self._by_position

    def torque(self, reference: np.ndarray, moved: Moved) -> np.ndarray:
        """Torque of each motor at one instant, seen from its joint, shape (n,) [N m]."""
        torque: np.ndarray = self._torque(self._now, reference, tuple(moved))
        return torque

    def integral_for(self, torque: np.ndarray) -> np.ndarray:
        """The integral with which the motors hold a torque (n,) [N m] when nothing is in error."""
        return torque / (self.velocity_gain * self.integral_gain)


class State(NamedTuple):
    """Of the arm and its servo.

    Attributes:
        position: In the plant's coordinates, shape (x,) [rad].
        velocity: Shape (x,) [rad/s].
        acceleration: Over the last step, shape (x,) [rad/s^2].
        integral: Of each motor's velocity error, shape (n,) [rad].
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    integral: np.ndarray


class Stepping:
    """Steps of one length, servo and transmission.

    Args:
        servo: Its control.
        springs: Its elastic gears.
        step: [s].
    """

    def __init__(self, servo: Servo, springs: Elastic, step: float) -> None:
        self._through = compiled(steps.through)
        self._constants = step, tuple(servo.over(step)), tuple(springs)

    def through(
        self, state: State, inertia: np.ndarray, start: Forces, end: Forces, reference: np.ndarray
    ) -> State:
        """The state after some steps.

        Args:
            state: That they begin with.
            inertia: Shape (x, x) [kg m^2].
            start: Forces around that state.
            end: Forces around another, which was foreseen; they change evenly from one to the other.
            reference: Of the servo, in the middle of each step, shape (k, n) [rad/s].

        Raises:
            RobotError: An arm without inertia.
        """
        known = tuple(state), inertia, tuple(start), tuple(end), reference
        return State(*self._through(*self._constants, *known))


def require_inertia(inertia: np.ndarray) -> None:
    """Raise where an arm of this inertia (x, x) would have nothing to be accelerated.

    Raises:
        RobotError: It is not positive definite.
    """
    solve(inertia, np.zeros(len(inertia)))
