"""Servo: the cascade at work on all motors, in the plant's coordinates."""

import numpy as np

from .drive_control import DriveControl


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
        self._coupling, self._feed = coupling.T.copy(), control.feed_forward
        self.turns = coupling @ motors
        self.position_gain, self.integral_gain = control.position_gain, control.integral_gain
        self.velocity_gain = control.velocity_gain
        self.limit = control.torque_limit(gain)

    def release(self) -> None:
        """Take the torque away."""
        self.velocity_gain = np.zeros_like(self.velocity_gain)

    def reference(self, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """What the loops are to follow, in one number a motor, for commands (t, n); shape (t, n) [rad/s]."""
        wanted = self._feed * velocity
        return wanted @ self._coupling + self.position_gain * (position @ self._coupling)

    def error(self, reference: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Velocity error of each motor, shape (n,) [rad/s]."""
        return reference - self.turns @ velocity - self.position_gain * (self.turns @ position)

    def torque(
        self, reference: np.ndarray, position: np.ndarray, velocity: np.ndarray, integral: np.ndarray
    ) -> np.ndarray:
        """Torque of each motor at one instant, seen from its joint, shape (n,) [N m]."""
        error = self.error(reference, position, velocity)
        torque = self.velocity_gain * (error + self.integral_gain * integral)
        return np.minimum(np.maximum(torque, -self.limit), self.limit)

    def integral_for(self, torque: np.ndarray) -> np.ndarray:
        """The integral with which the motors hold a torque (n,) [N m] when nothing is in error."""
        return torque / (self.velocity_gain * self.integral_gain)
