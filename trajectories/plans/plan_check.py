"""How much of the robot's limits a plan uses, and what it does that they forbid."""

from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.model import Model

from ..limits.check import ROUNDING, Violation, check, torque_peaks
from ..limits.usable_limits import ranges
from ..search.torque_bound import TorqueBound
from ..trajectory import Range, widest
from .plan import Plan
from .plan_jumps import jumps

COARSEST = 0.004
"""Spacing of the samples at which stops and torques are looked at, at most [s]: a swing of 10 Hz, beyond
which filters of identification end, has 25 of them whatever cycle the plan states."""
FINEST = 0.0005
"""The same, at least [s]: half the cycle of the fastest controllers."""
FEW = 0.25
"""Share of the time in which the acceleration builds up, between two samples [-]: 25 a period of a sine."""
MOST = 2e6
"""Samples, from which on they are not made finer: half a gigabyte of states."""


class Use(NamedTuple):
    """One quantity of all joints against its limits; the limits infinite where not given.

    Attributes:
        name: "position", "velocity", "acceleration", "jerk" or "torque".
        reached: Smallest and largest value and when, each shape (n,).
        lower: Shape (n,).
        upper: Shape (n,).
    """

    name: str
    reached: Range
    lower: np.ndarray
    upper: np.ndarray

    def shares(self, values: np.ndarray) -> np.ndarray:
        """Way from the middle to the limits, from -1 to 1, NaN where one is unknown; shape (..., n) [-].

        The middle is between the position limits; of everything else it is zero.
        """
        known = np.isfinite(self.lower) & np.isfinite(self.upper)
        lower, upper = np.where(known, self.lower, -1.0), np.where(known, self.upper, 1.0)
        middle = 0.5 * (lower + upper) if self.name == "position" else np.zeros(len(known))
        away = values - middle
        return np.where(known, np.where(away > 0, away / (upper - middle), -away / (lower - middle)), np.nan)

    @property
    def share(self) -> np.ndarray:
        """Largest share that is used, 1 at the limit, NaN where it is unknown; shape (n,) [-]."""
        return np.maximum(self.shares(self.reached.upper), -self.shares(self.reached.lower))

    @property
    def violated(self) -> np.ndarray:
        """Which joints go beyond a limit, shape (n,), bool."""
        return self.beyond(self.reached.upper) | self.beyond(self.reached.lower)

    def beyond(self, values: np.ndarray, joint: int | slice = slice(None)) -> np.ndarray:
        """Which values, (..., n) or of one joint, are beyond the limits by more than rounding."""
        lower, upper = self.lower[joint], self.upper[joint]
        slack = ROUNDING * np.where(np.isfinite(upper - lower), upper - lower, 1.0)
        return (values > upper + slack) | (values < lower - slack)


def limit_use(plan: Plan) -> list[Use]:
    """Position, velocity, acceleration and jerk against the limits, between samples too."""
    bounds, extremes = ranges(plan.limits), plan.trajectory.extremes()
    return [Use(name, reached, *bounds[name]) for name, reached in extremes._asdict().items()]


def percent(share: float, unknown: str) -> str:
    """The share of a limit that is used in per cent, or what stands for one that is not known."""
    return f"{100.0 * abs(share):.1f}" if np.isfinite(share) else unknown


UNLOADED = "unloaded"


class Torque(NamedTuple):
    """Torque of the motion by the nominal model.

    Attributes:
        time: Every tick, shape (t,) [s].
        runs: Name of a run and its torque, shape (t, n) [N m]; two of a payload pair whose body is known.
        use: Against the limits, between ticks too, of all runs.
    """

    time: np.ndarray
    runs: tuple[tuple[str, np.ndarray], ...]
    use: Use


def nominal_torque(plan: Plan, model: Model) -> Torque:
    """Torque of the motion by the model's priors, of a payload pair with the model's payload too.

    Its limits are the narrower of the plan's and the model's.
    """
    payloads = ("", *model.payloads) if plan.payload_pair else ("",)
    limit = np.minimum(plan.limits.torque, model.robot.limits.torque)
    bound = TorqueBound(model, limit, payloads)
    states = plan.trajectory.every(plan.tick)
    peaks = [torque_peaks(plan.trajectory, bound.of(load), spacing(plan)) for load in payloads]
    runs = tuple((load or UNLOADED, bound.torque(states, load)) for load in payloads)
    reached = widest([Range(*peak[:4]) for peak in peaks])
    return Torque(states.time, runs, Use("torque", reached, -limit, limit))


def violations(plan: Plan, torque: Torque | None = None) -> list[str]:
    """What the motion does that the plan's limits forbid, a sentence each; stops and jumps too.

    Args:
        plan: With its limits cut to those of the robot at hand by `plan_limits.within`.
        torque: Torque of the same plan, if the model is known.
    """
    found = check(plan.trajectory, _said_or_used(plan), spacing(plan))
    if torque is not None:
        found += _beyond(torque.use)
    sliding = [joint for joint, unit in enumerate(plan.units) if unit == "m"]
    sentences = [violation.sentence(plan.joints, sliding) for violation in found]
    return sentences + jumps(plan, spacing(plan))


def spacing(plan: Plan) -> float:
    """Spacing of samples that shows a motion between its ticks too, whatever tick the plan states [s]."""
    extremes = plan.trajectory.extremes()
    acceleration, jerk = (
        np.maximum(np.abs(reached.lower), np.abs(reached.upper))
        for reached in (extremes.acceleration, extremes.jerk)
    )
    moving = jerk > 0.0
    build_up = float(np.min(acceleration[moving] / jerk[moving], initial=np.inf))
    finest = max(FINEST, plan.trajectory.duration / MOST)
    return min(plan.tick, max(min(FEW * build_up, COARSEST), finest))


def _said_or_used(plan: Plan) -> Limits:
    """The limits, and where a rate has none, what the motion itself uses of it, so that stops can be had."""
    extremes = plan.trajectory.extremes()
    used: dict[str, np.ndarray] = {}
    for name in ("velocity", "acceleration", "jerk"):
        reached = getattr(extremes, name)
        size = np.maximum(np.abs(reached.lower), np.abs(reached.upper))
        used[name] = np.where(size > 0.0, size, 1.0)  # a joint that stands needs some limit
        used[f"{name}_lower"] = -used[name]
    given = {f.name: getattr(plan.limits, f.name) for f in fields(Limits) if f.name in used}
    return replace(plan.limits, **{n: np.where(np.isfinite(v), v, used[n]) for n, v in given.items()})


def _beyond(use: Use) -> list[Violation]:
    """Where a quantity is beyond its limits, each joint once."""
    found = []
    for joint in np.flatnonzero(use.violated):
        above = use.reached.upper[joint] - use.upper[joint] > use.lower[joint] - use.reached.lower[joint]
        side = "upper" if above else "lower"
        time = getattr(use.reached, f"{side}_time")[joint]
        value, limit = getattr(use.reached, side)[joint], getattr(use, side)[joint]
        found.append(Violation(use.name, int(joint), float(time), float(value), float(limit)))
    return found
