"""The page of a fleet: what changed, arms by joints, and each arm's values over time with the temperature."""

from collections.abc import Iterator, Mapping, Sequence

from markupsafe import Markup

from ...diagnosis.words.naming import named
from ...fleet.drift import LEAST, ArmDrift
from ...fleet.report import KindReport, amount_words, change_words, date_words
from ...notebook import counted
from ..report_html import NAMELESS, listing, paragraph, section, table
from ..report_page import page
from .trends import trends


def fleet_page(
    reports: Sequence[KindReport],
    left_out: Sequence[tuple[str, str]],
    links: Mapping[str, Mapping[str, str]],
    rate: float,
) -> str:
    """The page.

    Args:
        reports: Of each type of arm.
        left_out: Files that could not be identified, and why.
        links: Arm -> what there is of it, in words, -> its address.
        rate: False alarms an arm and year that were allowed.
    """
    arms = sum(len(one.drifts) for one in reports)
    runs = sum(len(own.runs) for one in reports for own in one.learned.arms.values())
    changed = [arm for one in reports for arm, found in one.drifts.items() if found.found]
    note = (
        f"{counted(arms, 'arm')}, {counted(runs, 'run')}; changed: {len(changed)}; false alarms allowed: "
        f"{rate:g} an arm and year"
    )
    body = [section("changes", "What changed", _changes(reports))]
    body += [
        section(f"map-{one.key}", f"Arms of {one.learned.frame.kind.model.robot.name}", _map(one))
        for one in reports
    ]
    for one in reports:
        body += [_arm(one, arm, links.get(arm, {})) for arm in one.drifts]
    if left_out:
        rows = [[file, why] for file, why in left_out]
        body.append(section("left-out", "Left out", table(["recording", "why"], rows, words=(0, 1))))
    return page("exidyn: fleet", "Fleet", note, "".join(body))


def anchor_of(arm: str) -> str:
    """What a link to an arm's section names."""
    return "arm-" + "".join(one if one.isalnum() or one == "-" else f"_{ord(one):x}" for one in arm)


def _changes(reports: Sequence[KindReport]) -> Markup:
    rows = [
        [_link(arm), change_words(one.learned, found), date_words(found.alarmed)]
        for one in reports
        for arm, own in one.drifts.items()
        for found in own.found
    ]
    if not rows:
        return paragraph("Nothing changed beyond what differs from run to run.")
    return table(["arm", "what changed", "first seen"], rows, words=(0, 1, 2))


def _link(arm: str) -> Markup:
    return Markup('<td class="words"><a href="#{}">{}</a></td>').format(anchor_of(arm), arm)


def _map(report: KindReport) -> Markup:
    """A row an arm, a column a joint; in a cell its surest change."""
    joints = report.learned.frame.kind.model.robot.joints
    rows = [[_link(arm), *_cells(report, own)] for arm, own in report.drifts.items()]
    return table(["arm", *joints], rows, words=range(len(joints) + 1))


def _cells(report: KindReport, own: ArmDrift) -> Iterator[str]:
    frame = report.learned.frame
    joints = frame.kind.model.robot.joints
    for joint in range(frame.kind.model.robot.dof):
        here = [one for one in own.found if frame.causes[one.cause].joint == joint]
        if not here:
            yield NAMELESS
            continue
        surest = max(here, key=lambda one: one.deviations)
        cause = frame.causes[surest.cause]
        amount = amount_words(surest.amount, surest.std, surest.usual, cause.unit)
        yield Markup('<td class="words bad">{}: {}</td>').format(named(cause.effect, [], joints), amount)


def _arm(report: KindReport, arm: str, links: Mapping[str, str]) -> Markup:
    own, runs = report.drifts[arm], report.learned.arms[arm]
    said = [change_words(report.learned, one) for one in own.found]
    withdrawn = len(own.alarms) - len(own.found)
    enough = len(runs.runs) >= LEAST
    note = f"{counted(len(runs.runs), 'run')}, {date_words(runs.days[0])} to {date_words(runs.days[-1])}"
    note += f"; a change is believed from {own.threshold:.1f} standard deviations. " if enough else "."
    if withdrawn > 0:
        note += f"Alarms that later runs did not confirm: {withdrawn}. "
    none = "Nothing changed." if enough else f"Too few runs for a change: {LEAST} at least."
    parts = [listing(said, "verdict") if said else paragraph(none), paragraph(note)]
    if links:
        addresses = [Markup('<a href="{}">{}</a>').format(address, words) for words, address in links.items()]
        parts.append(Markup('<p class="note">{}</p>').format(Markup(", ").join(addresses)))
    return section(anchor_of(arm), arm, *parts, trends(report, arm))
