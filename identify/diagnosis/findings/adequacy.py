"""Adequacy: whether the model with all findings fits the runs as correct models fit correct data."""

from dataclasses import dataclass

import numpy as np

from ...schema import Real


@dataclass(frozen=True)
class Misfit:
    """A joint and a time interval in which the residual concentrates."""

    run: str  # name of the run
    start: Real  # beginning, in the run's time [s]
    end: Real  # end [s]
    joint: int  # index of the joint, from 0


@dataclass(frozen=True, eq=False)
class Adequacy:
    """Absolute fit of the model with all findings: no effect is named on a joint that fails it."""

    shares: np.ndarray  # left-out residual over torque of each joint, shape (n,) [-]
    # Left-out residual over torque with separate parameters for each joint, shape (n,) [-].
    shares_alone: np.ndarray
    pooled_share: Real  # left-out residual over torque of all joints together [-]
    # Joints that do not fit as correct data do, from 0; empty where the model is adequate.
    failing: tuple[int, ...]
    misfits: tuple[Misfit, ...] = ()  # where and when the residual of failing joints concentrates

    def fails(self, joints: tuple[int, ...]) -> bool:
        """Whether no effect is named on these joints, from 0; none for an effect on the whole arm.

        All joints share the bodies: if several joints fail, the bodies of no joint can be trusted.
        """
        return len(self.failing) > 1 or bool(self.failing and (not joints or set(joints) & set(self.failing)))
