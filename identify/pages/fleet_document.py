"""The page of a fleet: what changed, arms by joints, and each arm's values over time with the temperature."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..diagnosis.words.naming import named
from ..document.document import (
    Block,
    Cell,
    Document,
    Figure,
    Grid,
    Link,
    Links,
    Marked,
    Paragraph,
    Section,
    Statements,
    Table,
)
from ..document.html import html
from ..fleet.drift import LEAST, ArmDrift, Found
from ..fleet.report import (
    KindReport,
    amount_words,
    bound_words,
    change_words,
    date_words,
    odd_words,
    subject,
    suspect_words,
    temperature_of,
)
from ..fleet.suspects import EXCHANGE, TOOL
from ..notebook import counted
from ..text_table import NORMAL_95
from .svg import Panel, Span, picture

WIDTH, HEIGHT, WARMTH = 560.0, 190.0, 60.0
"""Of a plot, and of the temperature's part of it [pixels]."""
WEEK = 7.0


def fleet_page(
    reports: Sequence[KindReport],
    left_out: Sequence[tuple[str, str]],
    links: Mapping[str, Mapping[str, str]],
    rate: float,
    marked: Sequence[tuple[str, str]] = (),
) -> str:
    """The page.

    Args:
        reports: Reports of each type of arm.
        left_out: Files that could not be identified, and why.
        links: Arm -> what there is of it, in words, -> its address.
        rate: False alarms an arm and year that were allowed.
        marked: Files that are not whole but were used as far as they go, and what is missing.
    """
    arms = sum(len(one.drifts) for one in reports)
    runs = sum(len(own.runs) for one in reports for own in one.learned.arms.values())
    changed = [arm for one in reports for arm, found in one.drifts.items() if found.found]
    note = (
        f"{counted(arms, 'arm')}, {counted(runs, 'run')}; changed: {len(changed)}; "
        f"{bound_words(reports, rate)}"
    )
    sections = [Section("changes", "What changed", [_changes(reports)])]
    if odd := _odd(reports):
        sections.append(Section("odd", "Runs out of line", [odd]))
    sections += [
        Section(f"map-{one.key}", f"Arms of {one.learned.frame.kind.model.robot.name}", [_map(one)])
        for one in reports
    ]
    for one in reports:
        sections += [_arm(one, arm, links.get(arm, {})) for arm in one.drifts]
    for key, title, files in (("left-out", "Left out", left_out), ("marked", "Not whole", marked)):
        if files:
            sections.append(Section(key, title, [Table(["recording", "why"], files, words=(1,))]))
    return html(Document("Fleet", note, sections))


def anchor_of(arm: str) -> str:
    """What a link to an arm's section names."""
    return "arm-" + "".join(one if one.isalnum() or one == "-" else f"_{ord(one):x}" for one in arm)


def _changes(reports: Sequence[KindReport]) -> Block:
    rows: list[list[Cell]] = [
        [_link(arm), change_words(one.learned, found), date_words(found.alarmed)]
        for one in reports
        for arm, own in one.drifts.items()
        for found in own.found
    ]
    if not rows:
        return Paragraph("Nothing changed beyond what differs from run to run.")
    return Table(["arm", "what changed", "first seen"], rows, words=(1, 2))


def _odd(reports: Sequence[KindReport]) -> Block | None:
    rows: list[list[Cell]] = [
        [_link(arm), odd_words(one.learned, odd)]
        for one in reports
        for arm, own in one.drifts.items()
        for odd in own.odd
    ]
    return Table(["arm", "which run, and what it is"], rows, words=(1,)) if rows else None


def _link(arm: str) -> Link:
    return Link(arm, f"#{anchor_of(arm)}")


def _map(report: KindReport) -> Table:
    """A row an arm, a column a joint; in a cell its surest change."""
    joints = report.learned.frame.kind.model.robot.joints
    rows: list[list[Cell]] = [[_link(arm), *_cells(report, own)] for arm, own in report.drifts.items()]
    return Table(["arm", *joints], rows, words=range(1, len(joints) + 1))


def _cells(report: KindReport, own: ArmDrift) -> Iterator[Cell]:
    causes, robot = report.learned.frame.causes, report.learned.frame.kind.model.robot
    for joint in range(robot.dof):
        here = [
            one
            for one in own.found
            if one.suspect.name == EXCHANGE or any(causes[k].joint == joint for k in one.suspect.causes)
        ]
        if not here:
            yield "-"
            continue
        surest = max(here, key=lambda one: one.evidence)
        yield Marked(_brief(report, surest), "bad")


def _brief(report: KindReport, found: Found) -> str:
    """A change in a cell: what, and how much of its surest consequence."""
    joints, suspect = report.learned.frame.kind.model.robot.joints, found.suspect
    if suspect.name in (EXCHANGE, TOOL):
        return suspect_words(report.learned, suspect, joints)
    k = found.surest
    cause = report.learned.frame.causes[suspect.causes[k]]
    amount = amount_words(found.amounts[k], found.stds[k], found.usual[k], cause.unit)
    return f"{named(cause.effect, [], joints)}: {amount}"


def _arm(report: KindReport, arm: str, links: Mapping[str, str]) -> Section:
    own, runs = report.drifts[arm], report.learned.arms[arm]
    said = [change_words(report.learned, one) for one in own.found]
    said += [odd_words(report.learned, one) for one in own.odd]
    withdrawn = len(own.alarms) - len(own.found)
    enough = len(runs.runs) >= LEAST
    note = f"{counted(len(runs.runs), 'run')}, {date_words(runs.days[0])} to {date_words(runs.days[-1])}"
    note += f"; a change is believed from odds of {_odds_words(own.price)} over none. " if enough else "."
    if withdrawn > 0:
        note += f"Alarms that later runs did not confirm: {withdrawn}. "
    none = "Nothing changed." if enough else f"Too few runs for a change: {LEAST} at least."
    blocks: list[Block] = [Statements(said, "verdict") if said else Paragraph(none), Paragraph(note)]
    if links:
        blocks.append(Links([Link(words, address) for words, address in links.items()]))
    return Section(anchor_of(arm), arm, [*blocks, _trends(report, arm)])


def _odds_words(logarithm: float) -> str:
    """Odds in round numbers: 40,000 to 1."""
    return f"{float(f'{np.exp(logarithm):.1g}'):,.0f} to 1"


def _trends(report: KindReport, arm: str) -> Grid:
    """A plot for each value that changed; where none did, for dry friction of every joint."""
    own, scattering = report.drifts[arm], report.scattering
    causes = report.learned.frame.causes
    places = {(one.effect, one.joint, one.parameter): k for k, one in enumerate(scattering)}
    found = {
        places[name]: one
        for one in own.found
        for k in one.suspect.causes
        if (name := (causes[k].effect, causes[k].joint, causes[k].parameter)) in places
    }
    usual = [k for k, one in enumerate(scattering) if one.effect == "coulomb_friction"]
    return Grid([_trend(report, arm, k, found.get(k)) for k in sorted(found) or usual])


def _trend(report: KindReport, arm: str, place: int, found: Found | None) -> Figure:
    runs, cause = report.learned.arms[arm], report.scattering[place]
    values, stds = (one[:, place] for one in report.values(arm))
    weeks, warm = (runs.days - runs.days[0]) / WEEK, temperature_of(runs)
    known = bool(np.all(np.isfinite(warm)))
    low, high = values - NORMAL_95 * stds, values + NORMAL_95 * stds
    across, height = Span.around(weeks), HEIGHT - (WARMTH if known else 0.0)
    upper = Panel(across, Span.around(low, high), 62.0, 8.0, WIDTH - 70.0, height - 16.0)
    unit = cause.unit or "ln(gain / nominal)"
    first = f"weeks since {date_words(runs.days[0])}"
    parts = [upper.axes("" if known else first, f"[{unit}]", x_ticks=not known)]
    if found is not None:
        begin, end = ((day - runs.days[0]) / WEEK for day in found.interval)
        edge = np.array([begin, end])
        ends = np.full(2, upper.y.low), np.full(2, upper.y.high)
        parts.append(upper.band(edge, *ends, "moment"))
    parts += [upper.band(weeks, low, high, "band"), upper.dots(weeks, values, "runs")]
    if known:
        lower = Panel(across, Span.around(warm), 62.0, height, WIDTH - 70.0, WARMTH - 8.0)
        parts += [lower.axes(first, "[degC]"), lower.line(weeks, warm, "residual")]
    words = subject(cause, report.learned.frame.kind.model.robot.joints)
    remark = "at the reference temperature" if cause.thermal and known else ""
    return Figure(words, remark, picture(WIDTH, HEIGHT + 34.0, f"{arm}: {words}", "".join(parts)))
