"""Drive control: the cascade that nearly every industrial drive has.

A position loop with proportional gain gives a velocity, to which the command's is added; a velocity loop with
proportional and integral gain gives the torque. The current loop and the drive's own cycle, some hundred
microseconds, are much faster than both and left out.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...errors import RobotError


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
