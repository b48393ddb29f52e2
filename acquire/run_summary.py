"""What a person reads before the arm moves, and after."""

from collections.abc import Mapping

import numpy as np
from exidyn.identify.text_table import paragraph, table
from exidyn.trajectories.plans.plan_use import limit_use, span, unit_of

from .run.before import Checked
from .run.loop import lateness
from .run.perform import Outcome

NOT_RATED = (
    "This is software and not safety-rated. Clear the cell, know where the emergency stop is and keep a hand "
    "on it; begin with --speed 10 on an arm that has not run this motion."
)


def before(checked: Checked, facts: Mapping[str, str]) -> str:
    """Robot, controller and motion against the limits."""
    plan = checked.plan
    lines = [f"{plan.robot}: {plan.trajectory.duration:.1f} s of motion"]
    width = max(map(len, facts), default=0) + 2
    for name, words in facts.items():
        lines += paragraph(words, " " * (width + 2), f"  {name + ':':<{width}}")
    return "\n".join([*lines, "", *(f"  {line}" for line in _use(checked))])


def _use(checked: Checked) -> list[str]:
    plan = checked.plan
    position, *rates = limit_use(plan)
    uses = [*rates, checked.torque.use]
    head = ["joint", "from .. to", "limits", *(f"peak {use.name}" for use in uses)]
    rows = [
        [
            name,
            f"{span(position.reached.lower[j], position.reached.upper[j])} {unit}",
            span(position.lower[j], position.upper[j]),
            *(
                _peak(np.maximum(use.reached.upper, -use.reached.lower)[j], use.share[j], use.name, unit)
                for use in uses
            ),
        ]
        for j, (name, unit) in enumerate(zip(plan.joints, plan.units, strict=True))
    ]
    return table(head, rows)


def _peak(value: float, share: float, name: str, unit: str) -> str:
    of = f" = {100 * abs(share):.0f} %" if np.isfinite(share) else ""
    return f"{value:.3g} {unit_of(name, unit)}{of}"


def after(outcome: Outcome) -> str:
    """How the run went, in a few lines."""
    counts, cycle, stop = outcome.counts, outcome.info.cycle, outcome.stop
    late = lateness(counts)
    lines = [
        "finished" if stop is None else f"STOPPED ({stop.level.name.lower()}): {stop.text}",
        f"{counts.cycles} cycles of {1e3 * cycle:g} ms, {counts.skipped} missed, {counts.stale} with a joint "
        "that was silent",
    ]
    if late.get("lateness_max"):
        lines.append(
            "lateness median {lateness_p50:.3f}, 99 % {lateness_p99:.3f}, largest {lateness_max:.3f} ms".format(
                **{name: 1e3 * value for name, value in late.items()}
            )
        )
    return "\n".join(lines)
