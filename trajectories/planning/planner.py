"""Planning: from a model and planning options to a plan that a recorder can run, with rests and leads."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.model import Model

from ..clearances.clearance import nearest_words
from ..errors import Infeasible, in_words_of
from ..families.fourier import Fourier
from ..families.sequence import Sequence as Run
from ..limits.check import check
from ..limits.leads import with_leads, with_rests
from ..limits.usable_limits import usable
from ..plans.plan import Plan
from ..search.delivery import FINE, SearchResult, Setting, fine_motion
from ..search.excite import excite
from ..search.goals import Goal, Identify, condition, name_of
from ..search.torque_bound import TorqueBound, share_beyond, with_own_factor
from ..search.torque_spread import DRAWS
from ..trajectory import States
from .goals import identification_goal, torque_spread, typical_states
from .wishes import ROUNDING, Wishes, beside_periods, periods_of


def plan(
    model: Model,
    wishes: Wishes,
    *,
    goal: Goal | None = None,
    starts: int = 4,
    seed: int = 0,
    seconds: float = 60.0,
    iterations: int | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> list[Plan]:
    """The best trajectories for a model, each with rests and leads, checked.

    Args:
        model: Nominal model of the arm.
        wishes: Planning options.
        goal: Goal other than to identify the model, such as to distinguish two models.
        starts: Maximum number of random starts, with seeds `seed`, `seed` + 1 and so on.
        seed: Seed of the first start.
        seconds: Duration of the search [s], without the startup of its processes.
        iterations: Iterations of each start. They replace `seconds`: the plan then does not depend on the
            speed, the load or the number of cores of the computer.
        progress: Called with a sentence when a start ends, and occasionally while they run.

    Raises:
        BadLimits: Limits are missing, or no joint can move within them.
        Infeasible: No motion keeps to all limits.
        NothingToIdentify: The model has no parameter that a motion could excite.
        UnknownChoice: The criterion is unknown.
    """
    goal, setting, assumed = goal_and_setting(model, wishes, goal)
    limits = setting.limits
    with in_words_of(model.robot):
        result = excite(
            goal, setting, starts=starts, seed=seed, seconds=seconds, iterations=iterations, progress=progress
        )
        goal = goal.with_spread(result.spread)
        return [_plan(model, wishes, goal, result, seed, series, limits, assumed) for series in result.series]


def goal_and_setting(
    model: Model, wishes: Wishes, goal: Goal | None = None
) -> tuple[Goal, Setting, tuple[str, ...]]:
    """Goal and setting of the search, and sentences on assumptions; raises the errors of `plan`."""
    limits, assumed = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    assumed += unstated(model, limits)
    goal = goal or identification_goal(model, wishes, limits)
    spread = torque_spread(goal.model, limits, goal.payloads, wishes.sure, wishes.fit)
    goal = with_own_factor(goal.with_spread(spread), typical_states(limits), limits.torque)
    periods = periods_of(wishes, limits)
    setting = Setting(limits, wishes.harmonics, periods, wishes.clearances, wishes.series, wishes.tick)
    return goal, setting, assumed


def unstated(model: Model, limits: Limits) -> tuple[str, ...]:
    """A sentence on parameters without a prior, whose torque is unknown."""
    priors = zip(model.names, model.priors, strict=True)
    without_prior = [name for name, prior in priors if prior.value == 0.0 and np.isinf(prior.std)]
    if not without_prior or not np.any(np.isfinite(limits.torque)):
        return ()
    return (f"{', '.join(without_prior)} have no prior, so the check of torque limits takes them as zero",)


def _plan(
    model: Model,
    wishes: Wishes,
    goal: Goal,
    result: SearchResult,
    seed: int,
    series: Fourier,
    limits: Limits,
    assumed: tuple[str, ...],
) -> Plan:
    """Plan of one trajectory with rests and leads."""
    bound = TorqueBound(goal.model, limits.torque, goal.payloads, goal.spread)
    run = whole_run(series, limits, wishes, [bound.of(payload) for payload in goal.payloads])
    details = {
        **_bodies(wishes),
        "nearest": nearest_words([clearance.worst(run) for clearance in wishes.clearances]),
        "period": series.period,
        "harmonics": series.harmonics,
        "goal": goal.words(result.value),
        "condition": _condition(goal, result, limits, wishes),
        "start": f"that of seed {result.seed}",
        "torque": _room(goal, run, model.robot.limits, wishes),
    }
    return Plan.of(
        run,
        model,
        margins=vars(wishes.margins),
        criterion=_criterion(goal, wishes),
        reached=goal.reached(result.value),
        details={name: value for name, value in details.items() if value},
        seed=seed,
        tick=wishes.tick,
        payload_pair=bool(wishes.bodies),
        assumed=assumed,
    )


def _condition(goal: Goal, result: SearchResult, limits: Limits, wishes: Wishes) -> float:
    """Condition number of the regressor; 0 if it is the criterion, or an earlier fit adds to it."""
    if not isinstance(goal, Identify) or goal.criterion is condition or wishes.fit is not None:
        return 0.0
    return goal.condition_number(fine_motion(result.series), limits)


def _bodies(wishes: Wishes) -> dict[str, str]:
    """The payloads of the runs, if there are several, and those whose center of mass is a guess."""
    masses = [f"{dict(known)['M']:g} kg" for known in wishes.bodies]
    guessed = [mass for mass, known in zip(masses, wishes.bodies, strict=True) if "MX" not in dict(known)]
    return {
        "bodies": ", ".join(masses) if len(masses) > 1 else "",
        "center": f"{GUESSED} for {' and '.join(guessed)}; {UNSAFE}" if guessed else "",
    }


def _room(goal: Goal, run: Run, limits: Limits, wishes: Wishes) -> str:
    """The share of arms that the torque limits leave room for; empty if they need none."""
    if goal.spread is None:
        return ""
    source = "the priors allow" if wishes.fit is None else "the fit allows"
    beyond = 100 * share_beyond(goal, run.every(FINE), limits.torque)
    return (
        f"within limits for {100 * wishes.sure:g} % of the arms that {source}; {beyond:.2g} % of {DRAWS:,} "
        "sampled arms exceed a limit"
    )


def _criterion(goal: Goal, wishes: Wishes) -> str:
    """Name of the minimized criterion."""
    if not isinstance(goal, Identify):
        return type(goal).__name__.lower()
    name = name_of(goal.criterion)
    return f"focus on {' '.join(wishes.in_focus)}" if name == "focus" else name


GUESSED = "guessed on the flange's z axis"
UNSAFE = "with another center of mass the torque can exceed its limits, so state it with --com"
"""Why a plan for a mass alone is not safe for every payload."""
PHASES = 40
"""Number of phases of the period at which to begin; the state changes little from one to the next."""
TRIED = 6
"""Number of the shortest runs that are fully checked before gentler leads are tried."""
ENOUGH = 1.001
"""Factor on the acceleration that must be reached, so that rounding does not put it out of reach."""
SHARES = (0.5, 0.25, 0.1, 1.0)
"""Shares of acceleration and jerk of the leads, in the order in which they are tried: leads give little
information, so half; less if the drives are too weak, and all if the distance is too short."""


def whole_run(
    series: Fourier, limits: Limits, wishes: Wishes, torques: Sequence[Callable[[States], np.ndarray]] = ()
) -> Run:
    """Rest, lead-in, whole periods, lead-out, rest, with the shortest leads that keep to all limits.

    The series has a period of whole sampling periods; rests fill the run to the wished duration.

    Raises:
        Infeasible: No phase of the period has feasible leads within the duration.
    """
    reason, tick = "no phase was tried", wishes.tick
    count = max(int((wishes.seconds - beside_periods(wishes, limits)) / series.period + ROUNDING), 1)
    for repeats, share in product(dict.fromkeys((count, max(count - 1, 1))), SHARES):
        runs: list[Run] = []
        for shift in np.unique(np.round(np.linspace(0.0, series.period, PHASES, endpoint=False) / tick)):
            core = replace(series.shifted(float(shift * tick)), periods=repeats)
            try:
                runs.append(with_leads(core, _gentler(limits, core, share), tick, wishes.start, wishes.rest))
            except Infeasible as error:
                reason = str(error)
        for run in sorted(runs, key=lambda run: run.duration)[:TRIED]:
            reason = _why_not(run, limits, wishes, torques)
            if not reason:
                return with_rests(run, wishes.seconds, tick)
    raise Infeasible(f"no lead into the motion keeps to the limits: {reason}")


def _gentler(limits: Limits, core: Fourier, share: float) -> Limits:
    """Limits with less acceleration and jerk, but enough for the state in which the core begins and ends."""
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
    run: Run, limits: Limits, wishes: Wishes, torques: Sequence[Callable[[States], np.ndarray]]
) -> str:
    """The first violation of a run in words; empty if there is none."""
    if run.duration > wishes.seconds + 0.5 * wishes.tick:
        return f"it takes {run.duration:.2f} s, longer than the {wishes.seconds:g} s that were asked for"
    names = [f"joint {joint + 1}" for joint in range(run.dof)]
    for torque in torques or (None,):
        for violation in check(run, limits, wishes.tick, torque):
            return violation.sentence(names)
    for clearance in wishes.clearances:
        nearest = clearance.worst(run)
        if not nearest.allowed:
            return f"{nearest.name}: {1e3 * nearest.margin:.0f} mm of room at {nearest.time:.2f} s"
    return ""
