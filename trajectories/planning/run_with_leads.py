"""Whole run: a periodic motion with rests and leads, begun where its period joins best."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from exidyn.identify.arm.robot import Limits

from ..clearances.clearance import Clearance
from ..errors import Infeasible
from ..families.fourier import Fourier
from ..families.sequence import Sequence as Run
from ..limits.check import check
from ..limits.leads import with_leads
from ..trajectory import States

PHASES = 40
"""Moments of the period at which it is tried to begin: the state changes by little from one to the next."""
TRIED = 6
"""Of these, how many of the shortest are checked in full before gentler leads are tried."""
ENOUGH = 1.001
"""Of the acceleration that is to be reached, so that rounding does not put it out of reach."""
GENTLER = (1.0, 0.5, 0.25, 0.1)
"""Share of acceleration and jerk that leads take: the drives may be too weak for all of it at once."""


def whole_run(
    series: Fourier,
    limits: Limits,
    tick: float,
    *,
    repeats: int = 1,
    start: np.ndarray | None = None,
    rest: float = 1.0,
    clearances: Sequence[Clearance] = (),
    torques: Sequence[Callable[[States], np.ndarray]] = (),
) -> Run:
    """Rest, lead-in, `repeats` periods, lead-out, rest: with the shortest leads that keep to everything.

    Args:
        series: A whole number of ticks long.
        limits: For the leads too.
        tick: Cycle of the controller [s].
        repeats: How often the period is run.
        start: Pose of the rests, shape (n,) [rad]; chosen unless given.
        rest: Duration of each rest [s].
        clearances: Collisions and regions.
        torques: Nominal torque of each run, for the check.

    Raises:
        Infeasible: From no moment of the period.
    """
    reason = "no phase was tried"
    for share in GENTLER:
        runs: list[Run] = []
        for shift in np.unique(np.round(np.linspace(0.0, series.period, PHASES, endpoint=False) / tick)):
            core = replace(series.shifted(float(shift * tick)), periods=repeats)
            try:
                runs.append(with_leads(core, _gentler(limits, core, share), tick, start, rest))
            except Infeasible as error:
                reason = str(error)
        for run in sorted(runs, key=lambda run: run.duration)[:TRIED]:
            reason = _why_not(run, limits, tick, clearances, torques)
            if not reason:
                return run
    raise Infeasible(f"no lead into the motion keeps to the limits: {reason}")


def _gentler(limits: Limits, core: Fourier, share: float) -> Limits:
    """Less acceleration and jerk, but enough for the state in which the core begins and ends."""
    begins = core.at(np.zeros(1)).acceleration[0]
    return replace(
        limits,
        acceleration=np.clip(begins * ENOUGH, share * limits.acceleration, limits.acceleration),
        acceleration_lower=np.clip(
            begins * ENOUGH, limits.acceleration_lower, share * limits.acceleration_lower
        ),
        jerk=np.maximum(share, 0.5) * limits.jerk,
    )


def _why_not(
    run: Run,
    limits: Limits,
    tick: float,
    clearances: Sequence[Clearance],
    torques: Sequence[Callable[[States], np.ndarray]],
) -> str:
    """What a run violates, in words; empty if nothing."""
    names = [f"joint {joint + 1}" for joint in range(run.dof)]
    for torque in torques or (None,):
        for violation in check(run, limits, tick, torque):
            return violation.sentence(names)
    for clearance in clearances:
        nearest = clearance.worst(run)
        if not nearest.allowed:
            return f"{nearest.name}: {1e3 * nearest.margin:.0f} mm of room at {nearest.time:.2f} s"
    return ""
