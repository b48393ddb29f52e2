"""Planning: from a model and what is wished to a plan that a recorder can run, with rests and leads."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from exidyn.identification.arm.robot import Limits
from exidyn.identification.model import Model
from exidyn.identification.text_table import digits

from ..clearances.clearance import Clearance, nearest_words
from ..errors import Infeasible, in_words_of
from ..families.fourier import Fourier
from ..families.sequence import Sequence as Run
from ..limits.check import check
from ..limits.leads import with_leads
from ..limits.usable_limits import usable
from ..plans.plan import Plan
from ..search.criteria import condition, name_of
from ..search.delivery import fine_motion
from ..search.drawn_arms import with_own_factor
from ..search.excite import excite
from ..search.goals import Goal, Identify
from ..search.setting import Found, Setting
from ..search.torque_bound import TorqueBound
from ..search.torque_spread import DRAWS
from ..trajectory import States
from .goals import identification_goal, typical_states
from .torque_room import arms_beyond, torque_spread
from .wishes import Wishes, periods_of


def plan(
    model: Model,
    wishes: Wishes,
    *,
    goal: Goal | None = None,
    starts: int = 4,
    seed: int = 0,
    seconds: float = 60.0,
    executor: Executor | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> list[Plan]:
    """The best trajectories for a model, each with rests and leads, checked.

    Args:
        model: The nominal model of the arm.
        wishes: What is wanted.
        goal: Another goal than to identify the model, such as to distinguish two models.
        starts: Starts of the search.
        seed: Seed of the first start.
        seconds: For the search [s].
        executor: Where the starts run.
        progress: Called with sentences.

    Raises:
        BadLimits: Limits that are not given, or that nothing can move within.
        Infeasible: No motion keeps to all limits.
        NothingToIdentify: The model has no parameter that motion could show.
        UnknownChoice: A criterion that there is not.
    """
    goal, setting, assumed = goal_and_setting(model, wishes, goal)
    limits = setting.limits
    with in_words_of(model.robot):
        found = excite(
            goal, setting, starts=starts, seed=seed, seconds=seconds, executor=executor, progress=progress
        )
        goal = goal.with_spread(found.spread)
        return [_plan(model, wishes, goal, found, seed, series, limits, assumed) for series in found.series]


def goal_and_setting(
    model: Model, wishes: Wishes, goal: Goal | None = None
) -> tuple[Goal, Setting, tuple[str, ...]]:
    """What to search for and within what, and sentences about what is assumed; errors as of `plan`."""
    limits, assumed = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    assumed += unstated(model, limits)
    goal = goal or identification_goal(model, wishes, limits)
    spread = torque_spread(goal.model, limits, goal.payloads, wishes.sure, wishes.fit)
    goal = with_own_factor(goal.with_spread(spread), typical_states(limits), limits.torque)
    periods = periods_of(wishes, limits)
    setting = Setting(limits, wishes.harmonics, periods, wishes.clearances, wishes.series, wishes.tick)
    return goal, setting, assumed


def unstated(model: Model, limits: Limits) -> tuple[str, ...]:
    """A sentence about parameters of which nothing is stated, so that their torque cannot be counted."""
    priors = zip(model.names, model.priors, strict=True)
    open_ones = [name for name, prior in priors if prior.value == 0.0 and np.isinf(prior.std)]
    if not open_ones or not np.any(np.isfinite(limits.torque)):
        return ()
    return (f"{', '.join(open_ones)}: nothing is stated of them, so the torque limits count them as zero",)


def _plan(
    model: Model,
    wishes: Wishes,
    goal: Goal,
    found: Found,
    seed: int,
    series: Fourier,
    limits: Limits,
    assumed: tuple[str, ...],
) -> Plan:
    """One trajectory as a whole run."""
    bound = TorqueBound(goal.model, limits.torque, goal.payloads, goal.spread)
    run = whole_run(
        series,
        limits,
        wishes.tick,
        repeats=periods_in(wishes.seconds, series.period),
        start=wishes.start,
        rest=wishes.rest,
        clearances=wishes.clearances,
        torques=[bound.of(payload) for payload in goal.payloads],
    )
    return Plan.of(
        run,
        model,
        margins=vars(wishes.margins),
        criterion=_criterion(goal, wishes),
        reached=goal.reached(found.value),
        details={
            **_bodies(wishes),
            **_nearest(run, wishes),
            "length": length_words(wishes.seconds, series.period, run.duration),
            "period": series.period,
            "harmonics": series.harmonics,
            "goal": goal.words(found.value),
            **_condition(goal, found, limits, wishes),
            "start": f"that of seed {found.seed}",
            **_room(goal, run, model.robot.limits, wishes),
        },
        seed=seed,
        tick=wishes.tick,
        payload_pair=bool(wishes.bodies),
        assumed=assumed,
    )


def _condition(goal: Goal, found: Found, limits: Limits, wishes: Wishes) -> dict[str, float]:
    """Condition number of the regressor where it is not the criterion and no earlier fit adds to it."""
    if not isinstance(goal, Identify) or goal.criterion is condition or wishes.fit is not None:
        return {}
    return {"condition": goal.condition_number(fine_motion(found.series), limits)}


def _bodies(wishes: Wishes) -> dict[str, str]:
    """The bodies with which it is run, where there are several."""
    masses = [f"{dict(known)['M']:g} kg" for known in wishes.bodies]
    return {"bodies": ", ".join(masses)} if len(masses) > 1 else {}


def _nearest(run: Run, wishes: Wishes) -> dict[str, str]:
    """What the run comes nearest to."""
    words = nearest_words([clearance.worst(run) for clearance in wishes.clearances])
    return {"nearest": words} if words else {}


def _room(goal: Goal, run: Run, limits: Limits, wishes: Wishes) -> dict[str, str]:
    """For which arms there is room below the torque limits."""
    if goal.spread is None:
        return {}
    known = "the fit" if wishes.fit is not None else "the priors"
    beyond = 100 * arms_beyond(goal, run, limits.torque)
    return {
        "torque": f"within limits for {100 * wishes.sure:g} % of the arms that {known} allow"
        f"{'s' if wishes.fit is not None else ''}; {beyond:.2g} % of {DRAWS} drawn arms pass a limit"
    }


def _criterion(goal: Goal, wishes: Wishes) -> str:
    """What was minimised, in a word or two."""
    if not isinstance(goal, Identify):
        return type(goal).__name__.lower()
    name = name_of(goal.criterion)
    return f"focus on {' '.join(wishes.in_focus)}" if name == "focus" else name


PHASES = 40
"""Moments of the period at which it is tried to begin: the state changes by little from one to the next."""
TRIED = 6
"""Of these, how many of the shortest are checked in full before gentler leads are tried."""
ENOUGH = 1.001
"""Of the acceleration that is to be reached, so that rounding does not put it out of reach."""
SHARES = (0.5, 0.25, 0.1, 1.0)
"""Shares of acceleration and jerk that leads take, in the order in which they are tried: nothing is learnt of
them, so half; less where the drives are too weak for that at once, and all where the way is too short."""


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
    for share in SHARES:
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


def periods_in(seconds: float, period: float) -> int:
    """The least number of whole periods that fill a time [s]."""
    return max(1, int(np.ceil(seconds / period - 1e-9)))


def length_words(seconds: float, period: float, duration: float) -> str:
    """What was asked for, and of what the delivered duration consists [s]."""
    count = periods_in(seconds, period)
    periods = f"{count} whole periods fill" if count > 1 else "one whole period fills"
    return (
        f"asked {digits(seconds)} s, which {periods} in {digits(count * period)} s; moving to and from it "
        f"takes {digits(duration - count * period, 2)} s"
    )
