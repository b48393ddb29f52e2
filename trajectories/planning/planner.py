"""Planning: from a model and what is wished to a plan that a recorder can run."""

from collections.abc import Callable
from concurrent.futures import Executor

import numpy as np

from exidyn.identify.arm.robot import Limits
from exidyn.identify.model import Model

from ..families.fourier import Fourier
from ..joint_names_in_errors import in_words_of
from ..limits.usable_limits import usable
from ..plans.plan import Plan
from ..search.bounds.torque_bound import TorqueBound
from ..search.excite import Found, Setting, excite
from ..search.information.criteria import name_of
from ..search.information.goals import Goal, Identify
from .identification_goal import identification_goal
from .run_with_leads import whole_run
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
        starts: Of the search.
        seed: Of the first start.
        seconds: For the search [s].
        executor: Where the starts run.
        progress: Called with sentences.

    Raises:
        BadLimits: Limits that are not given, or that nothing can move within.
        Infeasible: No motion keeps to all limits.
        NothingToIdentify: The model has no parameter that motion could show.
        UnknownChoice: A criterion that there is not.
    """
    limits, assumed = usable(model.robot, wishes.margins, wishes.window, wishes.start)
    assumed += unstated(model, limits)
    goal = goal or identification_goal(model, wishes, limits)
    periods = periods_of(wishes, limits)
    setting = Setting(limits, wishes.harmonics, periods, wishes.clearances, wishes.series, wishes.tick)
    with in_words_of(model.robot):
        found = excite(
            goal, setting, starts=starts, seed=seed, seconds=seconds, executor=executor, progress=progress
        )
        return [_plan(model, wishes, goal, found, series, limits, assumed) for series in found.series]


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
    series: Fourier,
    limits: Limits,
    assumed: tuple[str, ...],
) -> Plan:
    """One trajectory as a whole run."""
    bound = TorqueBound(goal.model, limits.torque, goal.payloads)
    run = whole_run(
        series,
        limits,
        wishes.tick,
        repeats=max(1, int(np.ceil(wishes.seconds / series.period - 1e-9))),
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
        details={"period": series.period, "harmonics": series.harmonics, "goal": goal.words(found.value)},
        seed=found.seed,
        tick=wishes.tick,
        payload_pair=wishes.payload is not None,
        assumed=assumed,
    )


def _criterion(goal: Goal, wishes: Wishes) -> str:
    """What was minimised, in a word or two."""
    if not isinstance(goal, Identify):
        return type(goal).__name__.lower()
    name = name_of(goal.criterion)
    return f"focus on {' '.join(wishes.focus)}" if name == "focus" else name
