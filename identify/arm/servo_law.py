r"""Law of position servos: the torque that a joint's servo exerts for a command.

.. math:: \tau = \mathrm{clip}\left(k_p (c(t - d) - q) - k_v \dot q + k_f \dot c(t - d)
    + k_i \int (c(t - d) - q)\, dt,\; \pm L\right)
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class ServoLaw:
    """Position servos of n joints."""

    stiffness: np.ndarray  # torque per position error k_p, shape (n,) [N m/rad]
    damping: np.ndarray  # torque against the joint's velocity k_v, shape (n,) [N m s/rad]
    limit: np.ndarray  # largest torque L, shape (n,) [N m]; infinite if there is none
    delay: np.ndarray  # time d from a command to its effect, shape (n,) [s]
    feed_forward: np.ndarray  # torque per commanded velocity k_f, shape (n,) [N m s/rad]
    integral: np.ndarray  # torque per integrated position error k_i, shape (n,) [N m/(rad s)]

    @classmethod
    def of(
        cls, stiffness: np.ndarray, damping: np.ndarray, limit: np.ndarray, delay: np.ndarray
    ) -> "ServoLaw":
        """Servos without feed-forward and integral."""
        return cls(stiffness, damping, limit, delay, *np.zeros((2, len(stiffness))))
