"""Whether a model fits a log as correct models fit correct logs, from left-out errors.

A probability among listed hypotheses says nothing if none of them is right. Two numbers do: P, what is left
of all joints together, and X, what is left of a joint with shared parameters over what is left with its own.
If P is large, nothing of this kind fits; if X is, each joint fits by itself but not with the others.
"""

import numpy as np

UNFITTED = 0.125
"""P above which nothing of this kind fits [-]. With findings of a diagnosis it is at most .11 in correct
recordings (a small servo), and at least .14 in wrong ones."""
APART = 2.5
"""X above which a joint fits only alone [-]: it is .9 to 2.5 in 28 of 30 correct recordings. With findings of
a diagnosis, both limits fail about one in ten."""
LOST = 0.5
"""Left-out residual of a joint over its effort above which the effort is not explained [-]. It is at most .49
in 29 of 30 correct recordings; a tilt of 2 degrees exceeds it on a joint without weight."""


def pooled_share(errors: np.ndarray, power: np.ndarray, revolute: np.ndarray) -> float:
    """P: residual over torque of all joints together, the larger of those of N m and of N [-]."""
    units = [joints for joints in (revolute, ~revolute) if power[joints].any()]
    return max((float(np.sqrt(errors[j].sum() / power[j].sum())) for j in units), default=0.0)


def failing_joints(
    together: np.ndarray, alone: np.ndarray, power: np.ndarray, revolute: np.ndarray
) -> tuple[int, ...]:
    """Joints without a fit, or with a fit only alone, and the fewest without which the others fit together.

    Squared errors with shared and with separate parameters, and squared torques, are (n,) [(N m)^2].
    """
    failing = (together > APART**2 * alone) | (together > LOST**2 * power)
    for unit in (revolute, ~revolute):
        order = sorted(np.flatnonzero(unit), key=lambda joint: -together[joint])
        while order and together[order].sum() > UNFITTED**2 * power[unit].sum():
            failing[order.pop(0)] = True
    return tuple(map(int, np.flatnonzero(failing & (power > 0.0))))
