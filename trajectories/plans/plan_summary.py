"""Summary of a plan for a terminal: its goal, and the used share of each limit."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from exidyn.identification.document.document import (
    Block,
    Cell,
    Document,
    Marked,
    Paragraph,
    Section,
    Statements,
    Table,
)  # fmt: skip
from exidyn.identification.text_table import UNKNOWN, digits, fixed

from ..families.phases import Phases
from ..trajectory import Trajectory
from .plan import Plan
from .plan_check import Use, limit_use, percent
from .plan_file import family_words

BYTES, POSE_BYTES, HEAD_BYTES = 55.0, 3000.0, 20e3
"""Bytes of a recording per joint and command, per joint and second of poses for viewers, and for robot and
plan, measured on recordings of arms with six joints at 2 and 8 ms."""
AT_REST = 0.65
"""Recorded time before and after the motion [s]."""
LONG = 60.0
"""Duration from which minutes are shown as well [s]."""
NEAR = 0.9
"""Share of a limit from which a number is colored as near the limit."""

SHARES = ("velocity", "acceleration", "jerk", "torque")
"""Limits whose safety margin is a share."""
LENGTHS = {"position": "rad", "slide": "m"}
"""Units of the safety margins of revolute and prismatic joints."""
SAFETY_DETAILS = ("bodies", "center", "payload", "nearest")
"""Details on which the safety of a run depends."""
DETAIL_UNITS = {"period": " s", "heaviest": " kg"}
"""Units of the details that are numbers with a unit."""


def plan_document(
    plan: Plan, uses: Sequence[Use], beyond: Sequence[str] = (), remarks: Sequence[str] = ()
) -> Document:
    """Facts on a plan, its use of limits, the sentences `beyond` on limits that it exceeds, and remarks."""
    facts, limits, apart = plan_facts(plan), use_table(plan, uses), leads_apart(plan)
    said, assumed = _verdict(plan, uses, beyond), [f"Assumed: {sentence}" for sentence in plan.assumed]
    run = [f"To be run {facts['to be run']}: {facts['takes']}"]
    if reached := facts.get("goal") or facts.get("criterion"):
        run.append(f"Reached: {reached}")
    run += [f"{name.capitalize()}: {facts[name]}" for name in SAFETY_DETAILS if name in facts]
    sections = [
        Section("verdict", "Verdict", [Statements([*said, *remarks, *assumed], "verdict")]),
        Section("limits", "Use of the limits", [limits, *([Paragraph(apart)] if apart else [])]),
    ]
    title = f"Motion for {plan.robot}: {plan.trajectory.duration:g} s, {family_words(plan.trajectory)}"
    brief: list[Block] = [Statements([*said, *remarks, *run, *assumed]), limits]
    return Document(title, "", sections, tuple(facts.items()), brief)


def _verdict(plan: Plan, uses: Sequence[Use], beyond: Sequence[str]) -> list[str]:
    """Limits that are exceeded, or else the largest use of one; and limits that are not known."""
    unknown = {use.name: [plan.joints[j] for j in np.flatnonzero(np.isnan(use.share))] for use in uses}
    unlimited = [
        f"No {name} limit is known for {', '.join(names)}." for name, names in unknown.items() if names
    ]
    if beyond:
        return ["Exceeds limits: do not run it.", *(f"BEYOND: {sentence}" for sentence in beyond), *unlimited]
    shares = np.nan_to_num([use.share for use in uses[1:]])
    most, joint = map(int, np.unravel_index(np.argmax(shares), shares.shape))
    used = f"at most {percent(shares[most, joint], '')} % of {uses[most + 1].name}, on {plan.joints[joint]}"
    return [f"Keeps to all known limits ({used}), and so does a stop that begins at any sample.", *unlimited]


def plan_facts(plan: Plan) -> dict[str, str]:
    """Facts on the plan by name."""
    runs = "twice, unloaded and loaded" if plan.payload_pair else "once"
    runs = "unloaded, and with each of the bodies" if "bodies" in plan.details else runs
    facts = {
        "joints": ", ".join(plan.joints),
        "to be run": f"{runs}, a command every {1e3 * plan.tick:g} ms",
        "takes": run_cost(plan, plan.tick) + (" each" if plan.payload_pair else ""),
    }
    if plan.criterion and "goal" not in plan.details:
        facts["criterion"] = f"{plan.criterion}, reached {digits(plan.reached)}"
    if plan.margins:
        facts["safety margins"] = ", ".join(_margins(plan))
    facts |= {
        name: (digits(value) if isinstance(value, float) else str(value)) + DETAIL_UNITS.get(name, "")
        for name, value in plan.details.items()
    }
    facts["seed"] = str(plan.seed)
    facts["hashes"] = f"robot {plan.robot_hash}, model {plan.model_hash}"
    return facts


def _margins(plan: Plan) -> Iterator[str]:
    """Safety margins to limits that the arm has."""
    for name, value in plan.margins.items():
        if name in SHARES:
            yield f"{name} {100 * value:.3g} %"
        elif LENGTHS.get(name, "") in ("", *plan.units):
            yield f"{name} {value:g} {LENGTHS.get(name, '')}".rstrip()


def run_cost(plan: Plan, cycle: float) -> str:
    """Duration of a run of the plan with this time between commands [s], and size of its recording."""
    seconds = plan.trajectory.duration
    by_joint = (BYTES / cycle + POSE_BYTES) * (seconds + AT_REST)
    size = 1e-6 * (HEAD_BYTES + len(plan.joints) * by_joint)
    return f"{duration_words(seconds)}, a recording of about {digits(size, 2)} MB"


def duration_words(seconds: float) -> str:
    """A duration [s], in minutes too if it is long."""
    minutes = f" ({int(seconds) // 60} min {int(seconds) % 60} s)" if seconds >= LONG else ""
    return f"{seconds:.0f} s{minutes}"


def use_table(plan: Plan, uses: Sequence[Use]) -> Table:
    """The range of each joint and the used shares of its limits."""
    position, *others = uses
    head = ["joint", "unit", "position", "of limits", *(f"{use.name} [%]" for use in others)]
    rows: list[list[Cell]] = [
        [
            name,
            plan.units[j],
            _cell(span(position.reached.lower[j], position.reached.upper[j]), position, j),
            span(position.lower[j], position.upper[j]),
            *(_cell(percent(use.share[j], UNKNOWN), use, j) for use in others),
        ]
        for j, name in enumerate(plan.joints)
    ]
    return Table(head, rows, words=(1,))


def _cell(words: str, use: Use, joint: int) -> Cell:
    share = use.share[joint]
    kind = "bad" if use.violated[joint] else "middling" if share >= NEAR else "good"
    return words if np.isnan(share) else Marked(words, kind)


def leads_apart(plan: Plan) -> str:
    """A sentence on the largest use of limits by the motion and by its leads; empty if there are no leads."""
    run = plan.trajectory
    leads = [part for part in getattr(run, "parts", ()) if isinstance(part, Phases)]
    motion = [part for part in getattr(run, "parts", ()) if not isinstance(part, Phases)]
    if not leads or not motion:
        return ""
    groups = (("motion", motion), ("leads", leads))
    uses = (f"{name} {_largest_uses(plan, parts)}" for name, parts in groups)
    return f"Largest use of the limits: {'; '.join(uses)}."


def _largest_uses(plan: Plan, parts: Iterable[Trajectory]) -> str:
    """Largest used share of velocity, acceleration and jerk limits of any joint in some parts."""
    uses = [limit_use(replace(plan, trajectory=part))[1:] for part in parts]
    words = []
    for part_uses in zip(*uses, strict=True):
        shares = np.abs([use.share for use in part_uses])
        if np.any(np.isfinite(shares)):
            words.append(f"{part_uses[0].name} {percent(float(np.nanmax(shares)), '')} %")
    return ", ".join(words)


def span(low: float, high: float) -> str:
    """A range with two decimals."""
    return f"{fixed(low, 2)} .. {fixed(high, 2)}"
