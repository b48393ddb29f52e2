"""Residual by quantity: a table; and by cause: table, sentences and plot of the budget of a diagnosis."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.finding import Hypothesis
from ..diagnosis.findings.residuals import Budget, Located
from ..diagnosis.results.budget import NOISE, OTHER
from ..diagnosis.words.naming import effect_words, finding_names, joined, lower, named
from ..diagnosis.words.sentences import possible
from ..document.document import Block, Cell, Figure, Number, Numbers, Paragraph, Section, Statements, Table
from ..text_table import digits, percent
from .shown import Shown
from .svg import picture, rect, text

SMALL = 0.01
"""Share of the squared residual below which, on every joint, a kind is combined with other kinds."""
LUMPED = "other kinds, less than 1 % each"
UNDECIDED = " (name undecided)"
CONTAINED = f'Sensor noise was not measured at rest: it is part of "{OTHER}".'
MOST = 3
"""Number of parts that a sentence names; the table has all parts."""
SHOWN = 5e-4
"""Smallest share that the table shows: 0.1 %, rounded."""
FOUND = ("#0067a5", "#00765a", "#8a4a9c", "#007f8c", "#3f5f9f", "#5a7d1e", "#6a5acd", "#2f6b4f")
"""Cold colors of findings, which a model could contain."""
KINDS = ("#c44e00", "#a8571c", "#b0413e", "#b26a00", "#9c4f6d", "#8f5a2b", "#a33a5b", "#946200")
"""Warm colors, as those of residuals, of parts that depend on a quantity but have no name."""
PLAIN = {NOISE: "#7a838d", OTHER: "#59616b"}
"""Grays of parts that depend on nothing. White figures are legible on all of these colors."""
LEFT, WIDTH, STEP = 110.0, 760.0, 30.0
"""Left end of the bars, their length, and their vertical spacing [pixels]."""
KEYS = 400.0
"""Distance between the two columns of the legend [pixels]."""
LEGIBLE = 0.045
"""Smallest share of a bar whose percentage fits into it."""
DEPENDS = (
    "Share: part of the joint's squared baseline residual in the held-out runs (without such runs: in fitted "
    "blocks that the others predict). Probability: that the torque depends on this quantity, whatever the "
    "formula. Name: the effect if one is certain, or the family of effects if several fit about equally well."
)
OPEN = "formula open"
"""Words for a certain family whose member is not certain."""


def located_section(shown: Shown) -> Section:
    """The section with the table; empty for a diagnosis without a budget."""
    rows: list[list[Cell]] = [
        [
            shown.names[row.joint],
            row.depends_on.replace("_", " "),
            percent(row.share),
            "" if row.probability is None else percent(row.probability, 3),
            _name(row, shown.diagnosis),
        ]
        for row in shown.diagnosis.located
    ]
    head = ["joint", "depends on", "share", "probability", "name"]
    blocks: list[Block] = [Paragraph(DEPENDS), Table(head, rows, words=(1, 4))] if rows else []
    return Section("located", "Residual by quantity", blocks)


def _name(row: Located, diagnosis: Diagnosis) -> str:
    """The effect, its family, or "undecided"; empty if no finding explains the row."""
    if row.finding is None:
        return ""
    finding = diagnosis.all_findings[row.finding]
    if row.finding < len(diagnosis.findings):
        return effect_words(finding.effect)
    if not finding.family:
        return "undecided"
    return OPEN if finding.family == row.depends_on else f"{finding.family}, {OPEN}"


class Part(NamedTuple):
    """A share of the squared residual in plot and table."""

    name: str  # finding with its joints, quantity on which the part depends, or sensor noise
    effect: str  # name of the effect; empty if the part is not a finding
    joints: tuple[int, ...]  # joints of the finding, from 0
    is_finding: bool  # whether a finding explains it
    shares: np.ndarray  # share of the squared residual of each joint, shape (n,) [-]


def budget_section(shown: Shown) -> Section:
    """Plot, one sentence per joint, and table; empty for a diagnosis without a budget."""
    diagnosis, joints = shown.diagnosis, shown.names
    if (budget := diagnosis.budget) is None:
        return Section("budget", TITLE, ())
    parts, units = lumped(parts_of(diagnosis)), diagnosis.torque_units
    fitted = "fitted runs, each block predicted by the others"
    source = f"held out: {', '.join(budget.held_out)}" if budget.held_out else fitted
    note = (
        "The baseline is the model without findings, fitted within its tolerances, with drive gains only if "
        f"there is a known payload ({source}; root mean square). The square of its residual is divided among "
        "its causes."
    )
    plot = (
        "Each bar is 100 % of the squared baseline residual of a joint. Findings have cold colors. Parts "
        "that depend on a recorded quantity but have no name have warm colors. All else is gray."
    )
    drawing = budget_plot(budget, parts, joints, units)
    blocks: list[Block] = [
        Paragraph(note),
        Paragraph(plot, "plot"),
        Figure("Residual by joint", f"{source}; root mean square on the right", drawing),
        Statements(sentences(budget, parts, joints, units)),
        *([] if diagnosis.noise_measured_at_rest else [Paragraph(CONTAINED)]),
        _table(budget, parts, joints, units),
    ]
    return Section("budget", TITLE, blocks)


TITLE = "Residual by cause"


def parts_of(diagnosis: Diagnosis) -> list[Part]:
    """Named shares of a diagnosis; an undecided finding has the name of its most probable hypothesis."""
    assert diagnosis.budget is not None
    names, findings = finding_names(diagnosis), diagnosis.all_findings
    parts = []
    for share in diagnosis.budget.shares:
        shares = share.percent / 100.0
        if share.finding is None:
            name = share.kind if share.kind in (NOISE, OTHER) else f"depends on {share.kind}"
            parts.append(Part(name, "", (), False, shares))
            continue
        finding, mark = findings[share.finding], ""
        likeliest: Hypothesis = finding
        name = names[share.finding]
        if share.finding >= len(diagnosis.findings):
            likeliest, mark = possible(finding)[0], UNDECIDED
        if likeliest is not finding:
            name = named(likeliest.effect, likeliest.joints, diagnosis.joints)
        parts.append(Part(name + mark, effect_words(likeliest.effect) + mark, likeliest.joints, True, shares))
    return parts


def lumped(parts: Sequence[Part]) -> list[Part]:
    """The parts, with small kinds combined."""
    small = [part for part in parts if _small(part)]
    if len(small) < 2:
        return list(parts)
    large = [part for part in parts if not _small(part)]
    last = [part for part in large if part.name in (NOISE, OTHER)]
    first = [part for part in large if part.name not in (NOISE, OTHER)]
    return [*first, Part(LUMPED, "", (), False, np.sum([part.shares for part in small], axis=0)), *last]


def _small(part: Part) -> bool:
    unnamed = not part.is_finding and part.name not in (NOISE, OTHER)
    return unnamed and bool(np.all(part.shares < SMALL))


def percents(shares: np.ndarray) -> np.ndarray:
    """Shares of parts (s, n) as integer percentages that add up to 100 on every joint; 0 if unknown.

    All shares are rounded down; the parts that lost most are then rounded up.
    """
    exact = 100.0 * np.nan_to_num(shares, posinf=0.0, neginf=0.0)
    rounded = np.floor(exact)
    for joint in range(exact.shape[1]):
        lacking = round(float(exact[:, joint].sum())) - int(rounded[:, joint].sum())
        first = np.argsort(rounded[:, joint] - exact[:, joint], kind="stable")
        rounded[first[: max(lacking, 0)], joint] += 1.0
    return rounded.astype(int)


def sentences(
    budget: Budget, parts: Sequence[Part], joints: Sequence[str], units: Sequence[str]
) -> list[str]:
    """One sentence for each joint that a finding explains in part, and one for all other joints."""
    percentages = percents(np.array([part.shares for part in parts]))
    sizes = [f"{digits(rms, 3)} {unit}" for rms, unit in zip(budget.before_rms, units, strict=True)]
    lines = [
        _sentence(parts, joint, name, sizes[joint], percentages[:, joint])
        for joint, name in enumerate(joints)
    ]
    unexplained = [lower(name) for name, text in zip(joints, lines, strict=True) if not text]
    explained = [text for text in lines if text]
    if not unexplained:
        return explained
    return [*explained, f"No finding explains any residual of {joined(unexplained)}."]


def _sentence(parts: Sequence[Part], joint: int, name: str, size: str, percentages: np.ndarray) -> str:
    pairs = [(part, int(share)) for part, share in zip(parts, percentages, strict=True) if share]
    explaining = sorted((pair for pair in pairs if pair[0].is_finding), key=lambda pair: -pair[1])
    unnamed = [part for part in parts if not part.is_finding and part.shares[joint] > 0.0]
    if not explaining:
        return ""
    (first, share), *others = explaining[:MOST]
    sentence = f"{name}: {_here(first, joint)} explains {share} % of the squared residual ({size} rms)"
    if others:
        sentence += f", besides {joined([f'{_here(part, joint)} ({percent} %)' for part, percent in others])}"
    return f"{sentence}{_most(unnamed, joint, '; of the rest, ')}."


def _here(part: Part, joint: int) -> str:
    """Name of a finding, with its joint if that is another one."""
    return lower(part.effect if part.joints in ((joint,), ()) else part.name)


def _most(parts: Sequence[Part], joint: int, opening: str) -> str:
    total = sum(float(part.shares[joint]) for part in parts)
    if total < SMALL:
        return ""
    largest = max(parts, key=lambda part: float(part.shares[joint]))
    share = float(largest.shares[joint]) / total
    amount = "most" if share > 0.5 else f"the largest part ({percent(share)})"
    if largest.name == NOISE:
        return f"{opening}{amount} is {NOISE}"
    depends = "depends on " if largest.name in (OTHER, LUMPED) else ""
    return f"{opening}{amount} {depends}{largest.name}"


def _table(budget: Budget, parts: Sequence[Part], joints: Sequence[str], units: Sequence[str]) -> Table:
    """Residuals before and after, and each part as a share and as root mean square torque."""
    shared_unit = f" [{units[0]}]" if len(set(units)) == 1 else ""
    cell_units = [""] * len(joints) if shared_unit else list(units)
    rows: list[list[Cell]] = [
        [
            name + shared_unit,
            *(Number(value, 3, unit) for value, unit in zip(values, cell_units, strict=True)),
        ]
        for name, values in (("baseline residual", budget.before_rms), ("with findings", budget.after_rms))
    ]
    for part, percentage in zip(parts, percents(np.array([part.shares for part in parts])), strict=True):
        if np.any(part.shares > SHOWN):
            rows.append([part.name, *map(_cell, part.shares, percentage, budget.before_rms)])
    return Table(["", *(name.partition(" (")[0].lower() for name in joints)], rows)


def _cell(share: float, percentage: int, before: float) -> Cell:
    if not share > SHOWN:
        return "-"
    return Numbers(f"{percentage or '< 1'} % ({{}})", (Number(np.sqrt(share) * before, 2),))


def budget_plot(budget: Budget, parts: Sequence[Part], joints: Sequence[str], units: Sequence[str]) -> str:
    """Stacked bars of 100 % each, with the residuals before and after on the right and a legend below."""
    colors = _colors(parts)
    drawn = [text(LEFT + WIDTH + 8, 12, "baseline → with findings", "tick")]
    for joint, (name, unit) in enumerate(zip(joints, units, strict=True)):
        before, after = budget.before_rms[joint], budget.after_rms[joint]
        drawn += [
            text(LEFT - 8, 35 + STEP * joint, name, "name end"),
            *_bar(parts, colors, joint, before, unit),
        ]
        sizes = f"{digits(before, 3)} → {digits(after, 3)} {unit}"
        drawn.append(text(LEFT + WIDTH + 8, 35 + STEP * joint, sizes, "name"))
    bottom = 28 + STEP * len(joints)
    pairs = [pair for pair in zip(parts, colors, strict=True) if np.any(pair[0].shares > SHOWN)]
    sides = [[pair for pair in pairs if pair[0].is_finding == is_finding] for is_finding in (True, False)]
    sides = [side for side in sides if side]
    for column, side in enumerate(sides):
        for row, (part, color) in enumerate(side):
            x, y = LEFT + KEYS * column, bottom + 18 * row
            drawn += [rect(f'fill="{color}"', x, y - 9, 18, 10), text(x + 24, y, part.name, "key")]
    height = bottom + 18 * max(map(len, sides), default=0)
    return picture(LEFT + WIDTH + 190, height, "residual by cause", "".join(drawn))


def _colors(parts: Sequence[Part]) -> list[str]:
    colors, count = [], [0, 0]
    for part in parts:
        palette = (FOUND, KINDS)[not part.is_finding]
        colors.append(PLAIN.get(part.name) or palette[count[part.is_finding] % len(palette)])
        count[part.is_finding] += part.name not in PLAIN
    return colors


def _bar(parts: Sequence[Part], colors: Sequence[str], joint: int, before: float, unit: str) -> list[str]:
    """Bar of one joint: a rectangle for each part, with its share if that fits."""
    top, x, drawn = 20 + STEP * joint, LEFT, list[str]()
    for part, color in zip(parts, colors, strict=True):
        share = float(np.nan_to_num(part.shares[joint]))
        if share <= 0.0:
            continue
        width, size = WIDTH * share, f"{digits(np.sqrt(share) * before, 3)} {unit}"
        title = f"{part.name}: {digits(100 * share, 3)} %, {size}"
        drawn.append(rect(f'fill="{color}"', x, top, width, 20, title))
        if share >= LEGIBLE:
            place = f'x="{x + width / 2:.1f}" y="{top + 14:g}"'
            drawn.append(f'<text {place} class="middle" style="fill:#fff">{100 * share:.0f} %</text>')
        x += width
    return drawn
