"""Joints whose effort has the wrong sign: rotor and friction come out negative, and reversal fits as well."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .equations import Equations
from .estimators.compressed import Compressed
from .estimators.least_squares import weighted_solution

AS_WELL = 1e-3
"""Relative increase of the residual's geometric mean over joints that counts as none: reversal does not
change the residual of a joint that shares no body with others, or of all joints together."""
BETTER = 0.1
"""Relative decrease that shows a wrong sign even if only one parameter is negative."""


def reversed_joints(equations: Equations, gain: np.ndarray, negative: Sequence[int]) -> list[int]:
    """Joints whose effort, at drive gains (n,), fits as well or better if it is reversed.

    `negative` is the number of parameters of each joint that oppose its motion and are negative, shape (n,).
    They alone do not show a wrong sign: a missing effect, such as a tilted base, causes them too, and the
    joints that share a body contradict each other if only one of them is reversed.
    """
    doubtful = [joint for joint, count in enumerate(negative) if count]
    several = [joint for joint in doubtful if negative[joint] > 1]
    if not doubtful:
        return []
    compressed = Compressed.of(equations)

    def misfit(joints: Sequence[int]) -> float:
        """Logarithm of the geometric mean over joints of the residual with some efforts reversed."""
        sign = np.ones(len(gain))
        sign[list(joints)] = -1.0
        noise = weighted_solution(replace(equations, gain=sign * gain), compressed)[1]
        return float(np.mean(np.log(np.maximum(noise, np.finfo(float).tiny))))

    plain = misfit([])
    if several and misfit(several) <= plain + AS_WELL:
        return several
    limit = {joint: plain + AS_WELL if joint in several else plain - BETTER for joint in doubtful}
    return [joint for joint in doubtful if misfit([joint]) <= limit[joint]]
