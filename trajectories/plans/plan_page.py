"""A plan as one HTML page that needs nothing else: no script, no network, light and dark, fit to print."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from exidyn.identify.pages.report_html import (
    NAMELESS,
    figure,
    grid,
    listing,
    paragraph,
    rounded,
    section,
    table,
)
from exidyn.identify.pages.report_page import page

from ..trajectory import unit_of
from .plan import Plan
from .plan_check import Torque
from .plan_plots import STYLE, joint_plot, plan_curves
from .plan_summary import plan_facts, span
from .plan_use import Use, percent

NEAR = 0.9
"""Share of a limit from which a number is coloured as one that is near it."""


def plan_page(plan: Plan, beyond: Sequence[str] = (), torque: Torque | None = None) -> str:
    """The page as text.

    Args:
        plan: What to show.
        beyond: Sentences of what its robot's limits forbid.
        torque: By prior; plotted too if it is known.
    """
    curves = plan_curves(plan, torque)
    uses = [curve.use for curve in curves]
    figures = [
        figure(name, _remark(plan, uses, joint), joint_plot(plan, joint, curves))
        for joint, name in enumerate(plan.joints)
    ]
    legend = (
        "Commands at every tick. Dashed: the robot's limits, before any margin; shaded: beyond them. "
        "Percentages are of the extremes, between ticks too"
        + ("; torque is that of the nominal model." if torque else ".")
    )
    body = (
        section("verdict", "Verdict", listing(_verdict(plan, uses, beyond, torque), "verdict"))
        + section("limits", "Use of the limits", _use_table(plan, uses))
        + section("motion", "Motion", paragraph(legend), grid(*figures, kind="two alike"))
        + section("plan", "How it was planned", _facts(plan))
    )
    title = f"{plan.robot}: planned motion"
    note = f"{plan.trajectory.duration:g} s, {len(plan.joints)} joints, every {1e3 * plan.tick:g} ms"
    return page(title, title, note, body, style=STYLE)


def _verdict(plan: Plan, uses: Sequence[Use], beyond: Sequence[str], torque: Torque | None) -> list[str]:
    """What to think of the plan: its worst first, and last what was not checked."""
    unlimited = [
        f"No {use.name} limit is known of "
        + ", ".join(plan.joints[j] for j in np.flatnonzero(np.isnan(use.share)))
        + "."
        for use in uses
        if np.any(np.isnan(use.share))
    ]
    stops = "a stop begun at any tick ends inside them"
    head = "Goes beyond limits: do not run it." if beyond else f"Keeps all limits that are known; {stops}."
    return [head, *beyond, *unlimited, f"Not looked at here: {'; '.join(_unseen(plan, torque))}."]


def _unseen(plan: Plan, torque: Torque | None) -> list[str]:
    """What this page cannot show."""
    unseen = ["collisions"]
    if torque is None:
        unseen.append("torque, which needs the robot")
    elif plan.payload_pair and len(torque.runs) == 1:
        unseen.append("torque of the loaded run, since the robot file names no payload")
    return unseen


def _use_table(plan: Plan, uses: Sequence[Use]) -> str:
    head = ["joint", "unit", "position", "of limits", *(f"{use.name} [%]" for use in uses[1:])]
    place = uses[0]
    rows = [
        [
            name,
            plan.units[j],
            _cell(span(place.reached.lower[j], place.reached.upper[j]), place, j),
            span(place.lower[j], place.upper[j]),
            *(_cell(percent(use.share[j], NAMELESS), use, j) for use in uses[1:]),
        ]
        for j, name in enumerate(plan.joints)
    ]
    return table(head, rows, words=(0, 1))


def _cell(words: str, use: Use, joint: int) -> Markup:
    share = use.share[joint]
    style = "bad" if use.violated[joint] else "middling" if share >= NEAR else "good"
    opening = "<td>" if np.isnan(share) else f'<td class="{style}">'
    return Markup(opening + "{}</td>").format(words)


def _remark(plan: Plan, uses: Sequence[Use], joint: int) -> str:
    """The largest velocity and torque in numbers."""
    chosen = [use for use in uses if use.name in ("velocity", "torque")]
    return "; ".join(
        f"{use.name} up to {rounded(max(-use.reached.lower[joint], use.reached.upper[joint]), 3)} "
        f"{unit_of(use.name, plan.units[joint])}"
        for use in chosen
    )


def _facts(plan: Plan) -> str:
    rows = [[name, words] for name, words in plan_facts(plan).items()]
    rows += [["assumed", sentence] for sentence in plan.assumed]
    return table(["", ""], rows, words=(0, 1))
