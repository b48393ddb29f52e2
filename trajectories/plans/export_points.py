"""Points of a plan at a rate, and their numbers as text, as every export needs them."""

import numpy as np

from ..trajectory import States
from .plan import Plan


def points(plan: Plan, rate: float, end: bool = True) -> States:
    """States at a rate [Hz], with the end of the motion as the last one if it is asked for."""
    states = plan.trajectory.every(1.0 / rate)
    left = plan.trajectory.duration - states.time[-1]
    # under a thousandth of a step the end is the last sample, but for rounding
    if not end or left < 1e-3 / rate:
        return states
    return plan.trajectory.at(np.append(states.time, plan.trajectory.duration))


def fixed(value: float, digits: int) -> str:
    """Digits behind a point and no exponent, which YAML 1.1 and KRL read alike; no minus before zero."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}"
