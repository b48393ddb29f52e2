"""What a plan does that its robot's limits forbid, and what it asks of the drives."""

from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np

from exidyn.identify.arm.robot import Limits
from exidyn.identify.model import Model

from ..limits.check import Violation, check
from ..limits.torque_peaks import torque_peaks
from ..search.bounds.torque_bound import TorqueBound
from ..trajectory import Range, widest
from .plan import Plan
from .plan_use import Use

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
    """Torque of the motion by the model's priors, of a payload pair with the model's payload too."""
    payloads = ("", *model.payloads) if plan.payload_pair else ("",)
    bound = TorqueBound(model, plan.limits.torque, payloads)
    states = plan.trajectory.every(plan.tick)
    peaks = [torque_peaks(plan.trajectory, bound.of(load), plan.tick) for load in payloads]
    runs = tuple((load or UNLOADED, bound.torque(states, load)) for load in payloads)
    reached = widest([Range(*peak[:4]) for peak in peaks])
    return Torque(states.time, runs, Use("torque", reached, -plan.limits.torque, plan.limits.torque))


def violations(plan: Plan, torque: Torque | None = None) -> list[str]:
    """What the motion does that the robot's limits forbid, a sentence each; stops from every tick too."""
    found = check(plan.trajectory, _said_or_used(plan), plan.tick)
    if torque is not None:
        found += _beyond(torque.use)
    sliding = [joint for joint, unit in enumerate(plan.units) if unit == "m"]
    return [violation.sentence(plan.joints, sliding) for violation in found]


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
