"""Residual by cause: plot of the budget of a diagnosis."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..diagnosis.findings.diagnosis import Diagnosis
from ..diagnosis.findings.residuals import Budget
from ..diagnosis.results.budget import NOISE, OTHER
from ..diagnosis.words.naming import finding_names
from ..document.document import Block, Figure, Paragraph, Section
from ..text_table import digits
from .shown import Shown
from .svg import picture, rect, text

UNDECIDED = " (name undecided)"
SHOWN = 5e-4
"""Smallest share that the legend names: 0.1 %, rounded."""
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
NOTE = (
    "Each bar is 100 % of the squared baseline residual of a joint. The baseline has no findings; its "
    "parameters and drive gains are fitted within their tolerances. Findings have cold colors. Parts that "
    "depend on a recorded quantity but have no name have warm colors. All else is gray."
)
CONTAINED = f' Sensor noise was not measured at rest: it is part of "{OTHER}".'


class Part(NamedTuple):
    """A share of the squared residual."""

    name: str  # finding with its joints, quantity on which the part depends, or sensor noise
    is_finding: bool  # whether a finding explains it
    shares: np.ndarray  # share of the squared residual of each joint, shape (n,) [-]


def budget_section(shown: Shown) -> Section:
    """Empty for a diagnosis without a budget."""
    diagnosis = shown.diagnosis
    if (budget := diagnosis.budget) is None:
        return Section("budget", "Residual by cause", ())
    source = ", ".join(budget.held_out) or "blocks of the fitted runs that the others predict"
    note = NOTE + ("" if diagnosis.noise_measured_at_rest else CONTAINED)
    drawing = budget_plot(budget, parts_of(diagnosis), shown.names, diagnosis.torque_units)
    remark = f"{source}; root mean square on the right"
    blocks: list[Block] = [Paragraph(note, "plot"), Figure("Residual by joint", remark, drawing)]
    return Section("budget", "Residual by cause", blocks)


def parts_of(diagnosis: Diagnosis) -> list[Part]:
    """Named shares of a diagnosis."""
    assert diagnosis.budget is not None
    names, decided, parts = finding_names(diagnosis), len(diagnosis.findings), []
    for share in diagnosis.budget.shares:
        name = share.kind if share.kind in (NOISE, OTHER) else f"depends on {share.kind}"
        if share.finding is not None:
            name = names[share.finding] + (UNDECIDED if share.finding >= decided else "")
        parts.append(Part(name, share.finding is not None, share.percent / 100.0))
    return parts


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
