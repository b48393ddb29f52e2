"""Use of the robot's limits by a plan, violations, and jumps between samples."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.model import Model

from ..families.sequence import JOIN
from ..limits.check import ROUNDING, beyond, check, torque_peaks
from ..limits.usable_limits import LIMIT_FIELDS, ranges
from ..search.torque_bound import TorqueBound
from ..trajectory import Range, Trajectory, unit_of, widest
from .plan import Plan

COARSEST = 0.004
"""Largest spacing of the samples at which stops and torques are checked [s]: a period at 10 Hz, the usual
cutoff of identification filters, has at least 25 samples for any sampling period of the plan."""
FINEST = 0.0005
"""Smallest spacing of these samples [s]: half the cycle of the fastest controllers."""
FEW = 0.25
"""Spacing of samples as a share of the acceleration's build-up time [-]: 25 per period of a sine."""
MOST = 2e6
"""Maximum number of samples: half a gigabyte of states."""


class Use(NamedTuple):
    """One quantity of all joints and its limits, which are infinite if unknown."""

    name: str  # "position", "velocity", "acceleration", "jerk" or "torque"
    reached: Range  # smallest and largest value and when, each of shape (n,)
    lower: np.ndarray  # lower limits, shape (n,)
    upper: np.ndarray  # upper limits, shape (n,)

    def shares(self, values: np.ndarray) -> np.ndarray:
        """Values relative to the limits, -1 at the lower and 1 at the upper, NaN if unknown; (..., n) [-].

        Zero is the middle of the position limits, and zero for all other quantities.
        """
        known = np.isfinite(self.lower) & np.isfinite(self.upper)
        lower, upper = np.where(known, self.lower, -1.0), np.where(known, self.upper, 1.0)
        middle = 0.5 * (lower + upper) if self.name == "position" else np.zeros(len(known))
        away = values - middle
        return np.where(known, np.where(away > 0, away / (upper - middle), -away / (lower - middle)), np.nan)

    @property
    def share(self) -> np.ndarray:
        """Largest share of the limits that is used, 1 at a limit, NaN if unknown; shape (n,) [-]."""
        return np.maximum(self.shares(self.reached.upper), -self.shares(self.reached.lower))

    @property
    def violated(self) -> np.ndarray:
        """Which joints exceed a limit, bool of shape (n,)."""
        return self.beyond(self.reached.upper) | self.beyond(self.reached.lower)

    def beyond(self, values: np.ndarray, joint: int | slice = slice(None)) -> np.ndarray:
        """Which values, of shape (..., n) or of one joint, exceed the limits by more than rounding."""
        lower, upper = self.lower[joint], self.upper[joint]
        slack = ROUNDING * np.where(np.isfinite(upper - lower), upper - lower, 1.0)
        return (values > upper + slack) | (values < lower - slack)


def limit_use(plan: Plan) -> list[Use]:
    """Use of the limits of position, velocity, acceleration and jerk, between samples too."""
    bounds, extremes = ranges(plan.limits), plan.trajectory.extremes()
    return [Use(name, reached, *bounds[name]) for name, reached in extremes._asdict().items()]


def percent(share: float, unknown: str) -> str:
    """The used share of a limit in percent, or the text `unknown` if it is not known."""
    return f"{100.0 * abs(share):.1f}" if np.isfinite(share) else unknown


UNLOADED = "unloaded"


class Curve(NamedTuple):
    """One quantity of all joints over time."""

    time: np.ndarray  # sample times, shape (t,) [s]
    runs: tuple[tuple[str, np.ndarray], ...]  # name and values of each run, shape (t, n)
    use: Use  # use of the limits by all runs, between samples too


def nominal_torque(plan: Plan, model: Model) -> Curve:
    """Torque of the motion by the nominal model; for a payload pair also with the model's payload.

    There are two runs for a payload pair with a known payload. The limits are the narrower ones of plan and
    model.
    """
    payloads = ("", *model.payloads) if plan.payload_pair else ("",)
    limit = np.minimum(plan.limits.torque, model.robot.limits.torque)
    bound = TorqueBound(model, limit, payloads)
    states = plan.trajectory.every(plan.tick)
    peaks = [torque_peaks(plan.trajectory, bound.of(load), spacing(plan)) for load in payloads]
    runs = tuple((load or UNLOADED, bound.torque(states, load)) for load in payloads)
    return Curve(states.time, runs, Use("torque", widest(peaks), -limit, limit))


def violations(plan: Plan, torque: Curve | None = None) -> list[str]:
    """Sentences on violations of the plan's limits, after `within`, by the motion, with stops and jumps."""
    limit_violations = check(plan.trajectory, _known_or_used(plan), spacing(plan))
    if torque is not None:
        limit_violations += beyond("torque", *torque.use[1:])
    sliding = [joint for joint, unit in enumerate(plan.units) if unit == "m"]
    sentences = [violation.sentence(plan.joints, sliding) for violation in limit_violations]
    return sentences + jumps(plan, spacing(plan))


def spacing(plan: Plan) -> float:
    """Spacing of samples that resolves the motion for any sampling period of the plan [s]."""
    *_, acceleration, jerk = (reached.largest for reached in plan.trajectory.extremes())
    moving = jerk > 0.0
    build_up = float(np.min(acceleration[moving] / jerk[moving], initial=np.inf))
    finest = max(FINEST, plan.trajectory.duration / MOST)
    return min(plan.tick, max(min(FEW * build_up, COARSEST), finest))


def _known_or_used(plan: Plan) -> Limits:
    """The limits, where missing rate limits are what the motion uses, so that stops can be computed."""
    extremes, known_or_used = plan.trajectory.extremes(), {}
    for quantity in ("velocity", "acceleration", "jerk"):
        size = getattr(extremes, quantity).largest
        used = np.where(size > 0.0, size, 1.0)  # a joint at rest needs some limit
        for name in LIMIT_FIELDS[quantity]:
            planned = getattr(plan.limits, name)
            known_or_used[name] = np.where(np.isfinite(planned), planned, np.copysign(used, planned))
    return replace(plan.limits, **known_or_used)


JOINS = 4
"""Maximum number of joins of a sequence between two samples; each may be off by `JOIN`."""


def jumps(plan: Plan, spacing: float) -> list[str]:
    """Sentences on the largest jump of each joint in position, velocity and acceleration.

    Pieces of a motion are stored with the state at which each begins, so a number changed by hand leaves a
    motion that keeps every limit before and after a jump. Between two samples a time h apart, a motion
    without jumps moves as its velocity and acceleration predict, within J h^3 / 6, where J is its largest
    jerk; velocity and acceleration change accordingly. The spacing of the samples is in [s].
    """
    sentences = []
    for name, size, time in _unexplained(plan.trajectory, spacing):
        for joint in np.flatnonzero(np.max(size, axis=0) > 0.0):
            row = int(np.argmax(size[:, joint]))
            sentences.append(
                f"{plan.joints[joint]}: {name} jumps by more than {size[row, joint]:.3g} "
                f"{unit_of(name, plan.units[joint])} at {time[row]:.3f} s"
            )
    return sentences


def _unexplained(trajectory: Trajectory, spacing: float) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Name of a quantity, its changes beyond what jerk explains, shape (t, n), and times, shape (t,) [s]."""
    time = trajectory.every(spacing).time
    states = trajectory.at(np.append(time, trajectory.duration))
    step = np.diff(states.time)[:, None]
    velocity, acceleration = states.velocity[:-1], states.acceleration[:-1]
    expected = {
        "position": step * (velocity + 0.5 * step * acceleration),
        "velocity": step * acceleration,
        "acceleration": 0.0 * step,
    }
    jerk = trajectory.extremes().jerk.largest
    allowed = (jerk * step**3 / 6.0, jerk * step**2 / 2.0, jerk * step)
    for (name, change), most in zip(expected.items(), allowed, strict=True):
        excess = np.abs(np.diff(getattr(states, name), axis=0) - change)
        # NaN is reported by the check of the limits
        yield name, excess - (1.0 + 1e-9) * most - JOINS * JOIN, states.time[:-1]
