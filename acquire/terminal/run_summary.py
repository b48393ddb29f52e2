"""Summary and confirmation before an arm moves, summary after it; motion and run as plain tables for JSON."""

import os
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from exidyn.drivers import StopLevel
from exidyn.identification.document.text import blocks_lines, fact_lines
from exidyn.identification.text_table import paragraph
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_check import Use, limit_use
from exidyn.trajectories.plans.plan_summary import use_table
from exidyn.trajectories.trajectory import unit_of

from ..run.before import CheckedPlan
from ..run.errors import NotAllowed, NotConfirmed
from ..run.loop import percentiles
from ..run.perform import Outcome

UNATTENDED = "EXIDYN_UNATTENDED"
"""Environment variable whose value `yes` lets arms move unconfirmed: for test stands."""
NOT_RATED = (
    "This is software and not safety-rated. Clear the cell, know where the emergency stop is and keep a hand "
    "on it"
)
BEGIN_SLOWLY = "; begin with --speed 10 on an arm that has not run this motion."


def before(checked: CheckedPlan, facts: Mapping[str, str]) -> str:
    """Robot, controller and motion against the limits."""
    plan = checked.plan
    lines = [f"{plan.robot}: {plan.trajectory.duration:.1f} s of motion"]
    lines += fact_lines(facts.items())
    table = use_table(plan, [*limit_use(plan), checked.torque.use])
    return "\n".join([*lines, "", *blocks_lines([table])])


def require_attended(simulated: bool, yes: bool) -> None:
    """Raise `NotAllowed` if --yes comes for a real arm without the environment variable.

    A reused script may have --yes by oversight.
    """
    if yes and not simulated and os.environ.get(UNATTENDED) != "yes":
        raise NotAllowed(
            f"--yes moves a real arm without confirmation only if {UNATTENDED}=yes is in the environment. "
            "Omit --yes to be asked"
        )


def confirm_reading(risk: str) -> None:
    """Return if a person confirmed the risk of reading, what it may do to the arm; there may be none.

    Raises:
        NotConfirmed: If the answer is not "yes", or there is no terminal.
    """
    if risk:
        print("\n" + "\n".join(paragraph(risk)) + "\n", file=sys.stderr)
        _ask("Support the arm. Type yes to read it: ", "nothing was sent")


def confirm(simulated: bool, yes: bool, advice: str = BEGIN_SLOWLY) -> None:
    """Return if a person or --yes confirmed the motion, or if the arm is simulated.

    Raises:
        NotAllowed: See `require_attended`.
        NotConfirmed: If the answer is not "yes", or there is no terminal.
    """
    require_attended(simulated, yes)
    if simulated:
        return
    print("\n" + "\n".join(paragraph(NOT_RATED + advice)) + "\n", file=sys.stderr)
    if yes:
        return
    _ask("Type yes to move the arm: ", "nothing was moved")


def _ask(question: str, nothing: str) -> None:
    """Return if the answer is "yes"."""
    print(question, end="", file=sys.stderr, flush=True)
    try:
        answer = input()
    except EOFError:
        print(file=sys.stderr)
        raise NotConfirmed(f"there is no terminal to type yes in, {nothing}. Run it in a terminal") from None
    if answer.strip() != "yes":
        raise NotConfirmed(f"not confirmed, {nothing}; the answer must be the word yes")


def end(outcome: Outcome) -> dict[str, object]:
    """How the run ended and whether the arm stands, for the recording."""
    stands = {} if outcome.standstill is None else outcome.standstill.details()
    if outcome.stop is None:
        return {"stop": "none", "text": "the motion came to its end", **stands}
    return {**stands, **outcome.stop.details(), "text": _why(outcome), "level": _hardest(outcome).name}


def _why(outcome: Outcome) -> str:
    """Reason of the stop, and the harder stops that followed because it did not work."""
    assert outcome.stop is not None
    harder = (f"then {stop.level.name.lower()}: {stop.text}" for stop in outcome.escalated)
    return "; ".join([outcome.stop.text, *harder])


def _hardest(outcome: Outcome) -> StopLevel:
    assert outcome.stop is not None
    return max(stop.level for stop in (outcome.stop, *outcome.escalated))


def table(outcome: Outcome) -> dict[str, object]:
    """Numbers of the run for JSON; times in [s]."""
    counts = outcome.counts
    return {
        "exidyn_run": 1,
        **end(outcome),
        "cycle": outcome.info.cycle,
        "cycles": counts.cycles,
        "skipped": counts.skipped,
        "stale": counts.stale,
        **percentiles("lateness", counts.lateness),
        **percentiles("work", counts.work),
        **percentiles("driver_work", counts.driver_work),
        "longest_block": counts.block,
        "warnings": list(outcome.info.warnings),
    }


def after(outcome: Outcome, full: bool) -> str:
    """A few lines on how the run went; in full with the processor time."""
    counts, cycle, stop = outcome.counts, outcome.info.cycle, outcome.stop
    late, work = percentiles("lateness", counts.lateness), percentiles("work", counts.work)
    lines = [
        *paragraph(
            "finished" if stop is None else f"STOPPED ({_hardest(outcome).name.lower()}): {_why(outcome)}"
        ),
        f"{counts.cycles} cycles of {1e3 * cycle:g} ms, {counts.skipped} missed, {counts.stale} in which a "
        "joint was silent",
    ]
    if late.get("lateness_max"):
        lines.append(
            f"lateness median {1e3 * late['lateness_p50']:.3f}, 99 % {1e3 * late['lateness_p99']:.3f}, "
            f"largest {1e3 * late['lateness_max']:.3f} ms"
        )
    if work and full:
        median, largest = 1e3 * work["work_p50"], 1e3 * work["work_max"]
        by_driver = 1e3 * percentiles("work", counts.driver_work)["work_p50"]
        lines += paragraph(
            f"processor time per cycle: median {median:.3f} ({by_driver:.3f} in the driver), "
            f"99 % {1e3 * work['work_p99']:.3f}, largest {largest:.3f} ms"
        )
    if outcome.notice:
        lines += paragraph(outcome.notice)
    return "\n".join(lines)


def plan_table(plan: Plan, uses: Sequence[Use], beyond: Sequence[str]) -> dict[str, Any]:
    """The plan, its use of each limit, and what is beyond the limits, for JSON."""
    return {
        "robot": plan.robot,
        "joints": plan.joints,
        "duration": plan.trajectory.duration,
        "tick": plan.tick,
        "payload_pair": plan.payload_pair,
        "criterion": plan.criterion or None,
        "reached": plan.reached,
        "details": dict(plan.details),
        "margins": dict(plan.margins),
        "seed": plan.seed,
        "robot_hash": plan.robot_hash,
        "model_hash": plan.model_hash,
        "use": {
            use.name: {
                "units": [unit_of(use.name, unit) for unit in plan.units],
                "lower": use.reached.lower,
                "upper": use.reached.upper,
                "share": abs(use.share),  # of the limit: 1 at the limit, None without one
            }
            for use in uses
        },
        "beyond": beyond,
        "assumed": plan.assumed,
    }
