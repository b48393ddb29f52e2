"""What a person reads before the arm moves, and after."""

from collections.abc import Mapping

from exidyn.drivers import StopLevel
from exidyn.identify.text_table import paragraph
from exidyn.trajectories.plans.plan_summary import use_table
from exidyn.trajectories.plans.plan_use import limit_use

from ..run.before import Checked
from ..run.loop import percentiles
from ..run.perform import Outcome

NOT_RATED = (
    "This is software and not safety-rated. Clear the cell, know where the emergency stop is and keep a hand "
    "on it"
)
BEGIN_SLOWLY = "; begin with --speed 10 on an arm that has not run this motion."


def before(checked: Checked, facts: Mapping[str, str]) -> str:
    """Robot, controller and motion against the limits."""
    plan = checked.plan
    lines = [f"{plan.robot}: {plan.trajectory.duration:.1f} s of motion"]
    width = max(map(len, facts), default=0) + 2
    for name, words in facts.items():
        lines += paragraph(words, " " * (width + 2), f"  {name + ':':<{width}}")
    return "\n".join(
        [*lines, "", *(f"  {line}" for line in use_table(plan, [*limit_use(plan), checked.torque.use]))]
    )


def end(outcome: Outcome) -> dict[str, object]:
    """How the run ended and whether the arm stands, for the recording."""
    stands = {} if outcome.standstill is None else outcome.standstill.details()
    if outcome.stop is None:
        return {"stop": "none", "text": "the motion came to its end", **stands}
    return {**stands, **outcome.stop.details(), "text": _why(outcome), "level": _hardest(outcome).name}


def _why(outcome: Outcome) -> str:
    """Why it was stopped, and what followed because the stop did not work."""
    assert outcome.stop is not None
    harder = (f"then {stop.level.name.lower()}: {stop.text}" for stop in outcome.escalated)
    return "; ".join([outcome.stop.text, *harder])


def _hardest(outcome: Outcome) -> StopLevel:
    assert outcome.stop is not None
    return max(stop.level for stop in (outcome.stop, *outcome.escalated))


def table(outcome: Outcome) -> dict[str, object]:
    """How the run went, in numbers, for JSON; times in [s]."""
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
        "warnings": list(outcome.info.warnings),
    }


def after(outcome: Outcome) -> str:
    """How the run went, in a few lines."""
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
    if work:
        median, most = 1e3 * work["work_p50"], 1e3 * work["work_max"]
        by_driver = 1e3 * percentiles("work", counts.driver_work)["work_p50"]
        lines += paragraph(
            f"processor time per cycle: median {median:.3f} ({by_driver:.3f} in the driver), "
            f"99 % {1e3 * work['work_p99']:.3f}, largest {most:.3f} ms"
        )
    if outcome.unsafe:
        lines += paragraph(outcome.unsafe)
    return "\n".join(lines)
