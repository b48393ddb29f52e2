"""A plan in lines for a terminal: what it is for, and how much of each limit it uses."""

from collections.abc import Sequence

from exidyn.identify.text_table import digits, paragraph, table

from .plan import Plan
from .plan_use import Use, percent
from .trajectory_rows import family_words

BYTES = 61.0
"""Of a recording for each joint and command, as measured on recordings of arms of six joints."""
LONG = 60.0
"""Duration from which on minutes are given as well [s]."""


def summary(plan: Plan, uses: Sequence[Use], beyond: Sequence[str] = ()) -> str:
    """Robot, duration, criterion and details; a table of the limits' use; `beyond` in sentences."""
    lines = [f"Motion for {plan.robot}: {plan.trajectory.duration:g} s, {family_words(plan.trajectory)}"]
    facts = plan_facts(plan)
    width = max(map(len, facts)) + 2
    for name, words in facts.items():
        lines += paragraph(words, " " * (width + 2), f"  {name + ':':<{width}}")
    lines += ["", *(f"  {line}" for line in use_table(plan, uses))]
    for heading, sentences in (("  BEYOND: ", beyond), ("  assumed: ", plan.assumed)):
        rows = [row for each in sentences for row in paragraph(each, " " * len(heading), heading)]
        lines += ["", *rows] if rows else []
    return "\n".join(lines).rstrip()


def plan_facts(plan: Plan) -> dict[str, str]:
    """What was planned and how, by name."""
    runs = "twice, unloaded and loaded" if plan.payload_pair else "once"
    facts = {
        "joints": ", ".join(plan.joints),
        "to be run": f"{runs}, a command every {1e3 * plan.tick:g} ms",
        "takes": run_cost(plan, plan.tick) + (" each" if plan.payload_pair else ""),
    }
    if plan.criterion:
        facts["criterion"] = f"{plan.criterion}, reached {digits(plan.reached)}"
    if plan.margins:
        facts["kept off"] = ", ".join(f"{name} {value:g}" for name, value in plan.margins.items())
    facts |= {n: digits(v) if isinstance(v, float) else str(v) for n, v in plan.details.items()}
    facts["seed"] = str(plan.seed)
    facts["hashes"] = f"robot {plan.robot_hash}, model {plan.model_hash}"
    return facts


def run_cost(plan: Plan, cycle: float) -> str:
    """How long a run of it takes, and how large its recording is.

    Args:
        plan: The motion.
        cycle: Between commands [s].
    """
    seconds = plan.trajectory.duration
    minutes = f" ({int(seconds) // 60} min {int(seconds) % 60} s)" if seconds >= LONG else ""
    size = 1e-6 * BYTES * len(plan.joints) * seconds / cycle
    return f"{seconds:.0f} s{minutes}, a recording of about {size:.2g} MB"


def use_table(plan: Plan, uses: Sequence[Use]) -> list[str]:
    """Lines of a table: each joint's range, and the share of its limits that it uses."""
    position, *others = uses
    head = ["joint", "position", "of limits", *(f"{use.name} %" for use in others)]
    rows = [
        [
            name,
            f"{span(position.reached.lower[j], position.reached.upper[j])} {plan.units[j]}",
            span(position.lower[j], position.upper[j]),
            *(percent(use.share[j], "no limit") for use in others),
        ]
        for j, name in enumerate(plan.joints)
    ]
    return table(head, rows)


def span(low: float, high: float) -> str:
    """A range with two digits behind the point."""
    return f"{low:.2f} .. {high:.2f}"
