"""Page of a fleet: changes, arms by joint, and the parameters of each arm over time with the temperature."""

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
from ..fleet.drift import LEAST, ArmDrift, DetectedChange
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
"""Size of a plot, and height of its temperature panel [pixels]."""
WEEK = 7.0


def fleet_page(
    reports: Sequence[KindReport],
    left_out: Sequence[tuple[str, str]],
    links: Mapping[str, Mapping[str, str]],
    rate: float,
    marked: Sequence[tuple[str, str]] = (),
) -> str:
    """HTML page of a fleet.

    Args:
        reports: One report for each type of arm.
        left_out: Files that could not be identified, each with the reason.
        links: Text and address of each link, by arm.
        rate: Accepted false alarms per arm and year.
        marked: Incomplete files of which the readable part was used, each with what is missing.
    """
    arms = sum(len(report.drifts) for report in reports)
    runs = sum(len(arm.runs) for report in reports for arm in report.learned.arms.values())
    changed = [arm for report in reports for arm, drift in report.drifts.items() if drift.changes]
    note = (
        f"{counted(arms, 'arm')}, {counted(runs, 'run')}; changed: {len(changed)}; "
        f"{bound_words(reports, rate)}"
    )
    sections = [Section("changes", "What changed", [_changes(reports)])]
    if odd := _odd(reports):
        sections.append(Section("odd", "Outlying runs", [odd]))
    sections += [
        Section(
            f"map-{report.key}", f"Arms of type {report.learned.frame.kind.model.robot.name}", [_map(report)]
        )
        for report in reports
    ]
    for report in reports:
        sections += [_arm(report, arm, links.get(arm, {})) for arm in report.drifts]
    for key, title, files in (
        ("left-out", "Recordings left out", left_out),
        ("marked", "Incomplete recordings", marked),
    ):
        if files:
            sections.append(Section(key, title, [Table(["recording", "reason"], files, words=(1,))]))
    return html(Document("Fleet", note, sections))


def anchor_of(arm: str) -> str:
    """Anchor of an arm's section."""
    return "arm-" + "".join(char if char.isalnum() or char == "-" else f"_{ord(char):x}" for char in arm)


def _changes(reports: Sequence[KindReport]) -> Block:
    rows: list[list[Cell]] = [
        [_link(arm), change_words(report.learned, change), date_words(change.alarmed)]
        for report in reports
        for arm, drift in report.drifts.items()
        for change in drift.changes
    ]
    if not rows:
        return Paragraph("No change exceeds the scatter between runs.")
    return Table(["arm", "what changed", "first seen"], rows, words=(1, 2))


def _odd(reports: Sequence[KindReport]) -> Block | None:
    rows: list[list[Cell]] = [
        [_link(arm), odd_words(report.learned, odd)]
        for report in reports
        for arm, drift in report.drifts.items()
        for odd in drift.odd
    ]
    return Table(["arm", "run and deviation"], rows, words=(1,)) if rows else None


def _link(arm: str) -> Link:
    return Link(arm, f"#{anchor_of(arm)}")


def _map(report: KindReport) -> Table:
    """One row per arm and one column per joint, each cell with the most certain change."""
    joints = report.learned.frame.kind.model.robot.joints
    rows: list[list[Cell]] = [[_link(arm), *_cells(report, drift)] for arm, drift in report.drifts.items()]
    return Table(["arm", *joints], rows, words=range(1, len(joints) + 1))


def _cells(report: KindReport, drift: ArmDrift) -> Iterator[Cell]:
    causes, robot = report.learned.frame.causes, report.learned.frame.kind.model.robot
    for joint in range(robot.dof):
        changes = [
            change
            for change in drift.changes
            if change.suspect.name == EXCHANGE or any(causes[k].joint == joint for k in change.suspect.causes)
        ]
        if not changes:
            yield "-"
            continue
        surest = max(changes, key=lambda change: change.evidence)
        yield Marked(_brief(report, surest), "bad")


def _brief(report: KindReport, change: DetectedChange) -> str:
    """A change in a few words, with the amount of its most certain consequence."""
    joints, suspect = report.learned.frame.kind.model.robot.joints, change.suspect
    if suspect.name in (EXCHANGE, TOOL):
        return suspect_words(report.learned, suspect, joints)
    k = change.surest
    cause = report.learned.frame.causes[suspect.causes[k]]
    amount = amount_words(change.amounts[k], change.stds[k], change.usual[k], cause.unit)
    return f"{named(cause.effect, [], joints)}: {amount}"


def _arm(report: KindReport, arm: str, links: Mapping[str, str]) -> Section:
    drift, runs = report.drifts[arm], report.learned.arms[arm]
    statements = [change_words(report.learned, change) for change in drift.changes]
    statements += [odd_words(report.learned, odd) for odd in drift.odd]
    withdrawn = len(drift.alarms) - len(drift.changes)
    enough = len(runs.runs) >= LEAST
    note = f"{counted(len(runs.runs), 'run')}, {date_words(runs.days[0])} to {date_words(runs.days[-1])}"
    note += f"; a change is reported if its odds exceed {_odds_words(drift.price)}. " if enough else "."
    if withdrawn > 0:
        note += f"Alarms not confirmed by later runs: {withdrawn}. "
    none = "Nothing changed." if enough else f"Too few runs to detect a change: at least {LEAST} are needed."
    blocks: list[Block] = [
        Statements(statements, "verdict") if statements else Paragraph(none),
        Paragraph(note),
    ]
    if links:
        blocks.append(Links([Link(words, address) for words, address in links.items()]))
    return Section(anchor_of(arm), arm, [*blocks, _trends(report, arm)])


def _odds_words(logarithm: float) -> str:
    """Odds rounded to one digit, such as "40,000 to 1"."""
    return f"{float(f'{np.exp(logarithm):.1g}'):,.0f} to 1"


def _trends(report: KindReport, arm: str) -> Grid:
    """Plots of all parameters that changed; without a change, of the Coulomb friction of every joint."""
    drift, causes = report.drifts[arm], report.learned.frame.causes
    places = {(cause.effect, cause.joint, cause.parameter): k for k, cause in enumerate(report.wearing)}
    changes = {
        places[name]: change
        for change in drift.changes
        for k in change.suspect.causes
        if (name := (causes[k].effect, causes[k].joint, causes[k].parameter)) in places
    }
    usual = [k for k, cause in enumerate(report.wearing) if cause.effect == "coulomb_friction"]
    return Grid([_trend(report, arm, k, changes.get(k)) for k in sorted(changes) or usual])


def _trend(report: KindReport, arm: str, place: int, change: DetectedChange | None) -> Figure:
    runs, cause = report.learned.arms[arm], report.wearing[place]
    values, stds = (columns[:, place] for columns in report.values(arm))
    weeks, warm = (runs.days - runs.days[0]) / WEEK, temperature_of(runs)
    known = bool(np.all(np.isfinite(warm)))
    low, high = values - NORMAL_95 * stds, values + NORMAL_95 * stds
    across, height = Span.around(weeks), HEIGHT - (WARMTH if known else 0.0)
    upper = Panel(across, Span.around(low, high), 62.0, 8.0, WIDTH - 70.0, height - 16.0)
    unit = cause.unit or "ln(gain / nominal)"
    first = f"weeks since {date_words(runs.days[0])}"
    parts = [upper.axes("" if known else first, f"[{unit}]", x_ticks=not known)]
    if change is not None:
        begin, end = ((day - runs.days[0]) / WEEK for day in change.interval)
        parts.append(upper.stripe(begin, end, "moment"))
    parts += [upper.band(weeks, low, high, "band"), upper.dots(weeks, values, "runs")]
    if known:
        lower = Panel(across, Span.around(warm), 62.0, height, WIDTH - 70.0, WARMTH - 8.0)
        parts += [lower.axes(first, "[degC]"), lower.line(weeks, warm, "residual")]
    words = subject(cause, report.learned.frame.kind.model.robot.joints)
    remark = "at the reference temperature" if cause.thermal and known else ""
    return Figure(words, remark, picture(WIDTH, HEIGHT + 34.0, f"{arm}: {words}", "".join(parts)))
