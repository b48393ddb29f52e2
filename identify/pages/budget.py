"""Misfit by cause: table, sentences and picture of a diagnosis's budget."""

from collections.abc import Sequence
from html import escape
from typing import NamedTuple

import numpy as np

from ..diagnosis.findings.diagnosis import Budget, Diagnosis
from ..diagnosis.findings.finding import Hypothesis
from ..diagnosis.results.budget import NOISE, OTHER
from ..diagnosis.words.naming import effect_words, finding_names, joined, lower, named
from ..diagnosis.words.sentences import possible
from ..document.document import Block, Cell, Figure, Number, Numbers, Paragraph, Section, Statements, Table
from ..text_table import digits, percent
from .shown import Shown
from .svg import picture, text

SMALL = 0.01
"""Share of the misfit below which a kind is put together with others, where it is that on every joint."""
LUMPED = "other kinds, less than 1 % each"
UNDECIDED = " (name undecided)"
CONTAINED = f'Sensor noise was not measured at rest: it is part of "{OTHER}".'
MOST = 3
"""Parts that a sentence names; the table has them all."""
SHOWN = 5e-4
"""Share from which on a part is in the table: a tenth of a per cent, rounded."""
FOUND = ("#0067a5", "#00765a", "#8a4a9c", "#007f8c", "#3f5f9f", "#5a7d1e", "#6a5acd", "#2f6b4f")
"""Of findings: cold colours, which are what the model could have."""
KINDS = ("#c44e00", "#a8571c", "#b0413e", "#b26a00", "#9c4f6d", "#8f5a2b", "#a33a5b", "#946200")
"""Of what depends on something and has no name: warm colours, as residuals have."""
PLAIN = {NOISE: "#7a838d", OTHER: "#59616b"}
"""Of what depends on nothing. White figures can be read on all of these, on light ground and on dark."""
LEFT, WIDTH, STEP = 110.0, 760.0, 30.0
"""Pixels: where bars begin, how long they are, and how far one is below the other."""
KEYS = 400.0
"""Pixels from what has a name to what has none, in the key."""
LEGIBLE = 0.045
"""Share of a bar from which on its per cent fit into it."""


class Part(NamedTuple):
    """A share of the misfit as it is drawn.

    Attributes:
        name: A finding and where it acts, what the misfit depends on, or that it is noise.
        effect: The effect alone; empty where it is no finding.
        joints: Joints of the finding, from 0.
        is_finding: Whether a finding explains it.
        shares: Share of the squared misfit of each joint, shape (n,) [-].
    """

    name: str
    effect: str
    joints: tuple[int, ...]
    is_finding: bool
    shares: np.ndarray


def budget_section(shown: Shown) -> Section:
    """The picture, a sentence a joint, and the table; empty for a diagnosis without."""
    diagnosis, joints = shown.diagnosis, shown.names
    if (budget := diagnosis.budget) is None:
        return Section("budget", TITLE, ())
    parts, units, source = lumped(parts_of(diagnosis)), diagnosis.torque_units, _source(budget)
    note = (
        "The misfit is the torque that the model misses with parameters and drive gains fitted within their "
        f"tolerances ({source}; root mean square). Its square is divided among what explains it."
    )
    plot = (
        "Each bar is 100 % of the squared misfit of a joint. Findings are drawn in cold colors, what depends "
        "on a recorded quantity but has no name in warm colors, and the rest in gray."
    )
    drawing = budget_plot(budget, parts, joints, units)
    blocks: list[Block] = [
        Paragraph(note),
        Paragraph(plot, "plot"),
        Figure("Misfit by joint", f"{source}; root mean square on the right", drawing),
        Statements(sentences(budget, parts, joints, units)),
        *([] if diagnosis.noise_measured_at_rest else [Paragraph(CONTAINED)]),
        _table(budget, parts, joints, units),
    ]
    return Section("budget", TITLE, blocks)


TITLE = "Misfit by cause"


def _source(budget: Budget) -> str:
    if budget.held_out:
        return f"held out: {', '.join(budget.held_out)}"
    return "fitted runs, each block predicted by the others"


def parts_of(diagnosis: Diagnosis) -> list[Part]:
    """The shares of a diagnosis with names; an undecided finding has that of its most probable hypothesis."""
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
    """The parts, with small kinds in one."""
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
    """Shares of parts (s, n) as whole per cents that add up to 100 on every joint; 0 where not known.

    What is rounded off goes to the parts that lost most by it.
    """
    exact = 100.0 * np.nan_to_num(shares, posinf=0.0, neginf=0.0)
    whole = np.floor(exact)
    for joint in range(exact.shape[1]):
        lacking = round(float(exact[:, joint].sum())) - int(whole[:, joint].sum())
        first = np.argsort(whole[:, joint] - exact[:, joint], kind="stable")
        whole[first[: max(lacking, 0)], joint] += 1.0
    return whole.astype(int)


def sentences(
    budget: Budget, parts: Sequence[Part], joints: Sequence[str], units: Sequence[str]
) -> list[str]:
    """One for each joint of which a finding explains a part, and one for all other joints."""
    whole = percents(np.array([part.shares for part in parts]))
    sizes = [f"{digits(rms, 3)} {unit}" for rms, unit in zip(budget.before_rms, units, strict=True)]
    lines = [
        _sentence(parts, joint, name, sizes[joint], whole[:, joint]) for joint, name in enumerate(joints)
    ]
    unexplained = [lower(name) for name, text in zip(joints, lines, strict=True) if not text]
    said = [text for text in lines if text]
    return [*said, f"No finding explains any misfit of {joined(unexplained)}."] if unexplained else said


def _sentence(parts: Sequence[Part], joint: int, name: str, size: str, whole: np.ndarray) -> str:
    pairs = [(part, int(share)) for part, share in zip(parts, whole, strict=True) if share]
    explaining = sorted((pair for pair in pairs if pair[0].is_finding), key=lambda pair: -pair[1])
    rest = [part for part in parts if not part.is_finding and part.shares[joint] > 0.0]
    if not explaining:
        return ""
    (first, share), *others = explaining[:MOST]
    said = f"{name}: {_here(first, joint)} explains {share} % of the {size} that the model misses"
    if others:
        said += f", besides {joined([f'{_here(part, joint)} ({percent} %)' for part, percent in others])}"
    return f"{said}{_most(rest, joint, '; of the rest, ')}."


def _here(part: Part, joint: int) -> str:
    """The finding's name, with its joint where that is another."""
    return lower(part.effect if part.joints in ((joint,), ()) else part.name)


def _most(rest: Sequence[Part], joint: int, opening: str) -> str:
    total = sum(float(part.shares[joint]) for part in rest)
    if total < SMALL:
        return ""
    largest = max(rest, key=lambda part: float(part.shares[joint]))
    share = float(largest.shares[joint]) / total
    amount = "most" if share > 0.5 else f"the largest part ({percent(share)})"
    if largest.name == NOISE:
        return f"{opening}{amount} is {NOISE}"
    depends = "depends on " if largest.name in (OTHER, LUMPED) else ""
    return f"{opening}{amount} {depends}{largest.name}"


def _table(budget: Budget, parts: Sequence[Part], joints: Sequence[str], units: Sequence[str]) -> Table:
    """Misfit before and after, and the share of each part with the torque that it is, root mean square."""
    shared_unit = f" [{units[0]}]" if len(set(units)) == 1 else ""
    cell_units = [""] * len(joints) if shared_unit else list(units)
    rows: list[list[Cell]] = [
        [
            name + shared_unit,
            *(Number(value, 3, unit) for value, unit in zip(values, cell_units, strict=True)),
        ]
        for name, values in (("misfit before", budget.before_rms), ("misfit after", budget.after_rms))
    ]
    for part, whole in zip(parts, percents(np.array([part.shares for part in parts])), strict=True):
        if np.any(part.shares > SHOWN):
            rows.append([part.name, *map(_cell, part.shares, whole, budget.before_rms)])
    return Table(["", *(name.partition(" (")[0].lower() for name in joints)], rows)


def _cell(share: float, whole: int, before: float) -> Cell:
    if not share > SHOWN:
        return "-"
    return Numbers(f"{whole or '< 1'} % ({{}})", (Number(np.sqrt(share) * before, 2),))


def budget_plot(budget: Budget, parts: Sequence[Part], joints: Sequence[str], units: Sequence[str]) -> str:
    """Bars of 100 % each, with the misfit before and after beside them, and what the colors mean below."""
    colors = _colors(parts)
    drawn = [text(LEFT + WIDTH + 8, 12, "before → after", "tick")]
    for joint, (name, unit) in enumerate(zip(joints, units, strict=True)):
        before, after = budget.before_rms[joint], budget.after_rms[joint]
        drawn += [
            text(LEFT - 8, 35 + STEP * joint, name, "name end"),
            *_bar(parts, colors, joint, before, unit),
        ]
        sizes = f"{digits(before, 3)} → {digits(after, 3)} {unit}"
        drawn.append(text(LEFT + WIDTH + 8, 35 + STEP * joint, sizes, "name"))
    bottom = 28 + STEP * len(joints)
    pairs = list(zip(parts, colors, strict=True))
    sides = [[pair for pair in pairs if pair[0].is_finding == is_finding] for is_finding in (True, False)]
    sides = [side for side in sides if side]
    keys = "".join(
        _key(LEFT + KEYS * column, bottom + 18 * row, color, part.name)
        for column, side in enumerate(sides)
        for row, (part, color) in enumerate(side)
    )
    height = bottom + 18 * max(map(len, sides), default=0)
    return picture(LEFT + WIDTH + 190, height, "where the misfit goes", "".join(drawn) + keys)


def _colors(parts: Sequence[Part]) -> list[str]:
    colors, count = [], [0, 0]
    for part in parts:
        palette = (FOUND, KINDS)[not part.is_finding]
        colors.append(PLAIN.get(part.name) or palette[count[part.is_finding] % len(palette)])
        count[part.is_finding] += part.name not in PLAIN
    return colors


def _bar(parts: Sequence[Part], colors: Sequence[str], joint: int, before: float, unit: str) -> list[str]:
    """The bar of one joint: a rectangle a part, with its share where that fits."""
    top, x, drawn = 20 + STEP * joint, LEFT, list[str]()
    for part, color in zip(parts, colors, strict=True):
        share = float(np.nan_to_num(part.shares[joint]))
        if share <= 0.0:
            continue
        width, size = WIDTH * share, f"{digits(np.sqrt(share) * before, 3)} {unit}"
        title = f"<title>{escape(part.name)}: {digits(100 * share, 3)} %, {size}</title>"
        drawn.append(
            f'<rect fill="{color}" x="{x:.1f}" y="{top:g}" width="{width:.1f}" height="20">{title}</rect>'
        )
        if share >= LEGIBLE:
            place = f'x="{x + width / 2:.1f}" y="{top + 14:g}"'
            drawn.append(f'<text {place} class="middle" style="fill:#fff">{100 * share:.0f} %</text>')
        x += width
    return drawn


def _key(x: float, y: float, colour: str, name: str) -> str:
    sample = f'<rect fill="{colour}" x="{x:g}" y="{y - 9:g}" width="18" height="10"/>'
    return sample + text(x + 24, y, name, "key")
