r"""Law of position servos: the torque that a joint's servo exerts for a command.

.. math:: \tau = \mathrm{clip}\left(k_p (c(t - d) - q) - k_v \dot q + k_f \dot c(t - d)
    + k_i \int (c(t - d) - q)\, dt,\; \pm L\right)
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class ServoLaw:
    """Position servos of n joints.

    Attributes:
        stiffness: Torque per position error k_p, shape (n,) [N m/rad].
        damping: Torque against the joint's velocity k_v, shape (n,) [N m s/rad].
        limit: Largest torque L, shape (n,) [N m]; infinite if there is none.
        delay: Time d from a command to its effect, shape (n,) [s].
        feed_forward: Torque per commanded velocity k_f, shape (n,) [N m s/rad].
        integral: Torque per integrated position error k_i, shape (n,) [N m/(rad s)].
    """

    stiffness: np.ndarray
    damping: np.ndarray
    limit: np.ndarray
    delay: np.ndarray
    feed_forward: np.ndarray
    integral: np.ndarray

    @classmethod
    def of(
        cls, stiffness: np.ndarray, damping: np.ndarray, limit: np.ndarray, delay: np.ndarray
    ) -> "ServoLaw":
        """Servos without feed-forward and integral."""
        return cls(stiffness, damping, limit, delay, *np.zeros((2, len(stiffness))))
