"""Servo: the cascade at work on all motors, in the plant's coordinates."""

import numpy as np

from . import compiled
from .drive_control import DriveControl
from .steps import Cascade, Moved


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
        self._torque, self._now = compiled.torque(), tuple(self.over(0.0))

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
