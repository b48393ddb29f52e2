"""Misfit by cause: table, sentences and picture of a diagnosis's budget."""

from collections.abc import Sequence
from html import escape

import numpy as np

from ..diagnosis.results.budget import NOISE, OTHER
from ..diagnosis.words.diagnosis_file import array_of
from ..diagnosis.words.diagnosis_schema import BudgetTable, ShareRow
from ..diagnosis.words.naming import joined, lower
from ..document.document import Block, Cell, Figure, Number, Numbers, Paragraph, Section, Statements, Table
from ..text_table import digits, percent
from .svg import picture, text

SMALL = 0.01
"""Share of the misfit below which a kind is put together with others, where it is that on every joint."""
LUMPED = "other kinds, less than 1 % each"
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


def budget_section(budget: BudgetTable | None, joints: Sequence[str]) -> Section:
    """The picture, a sentence a joint, and the table; empty for a diagnosis without.

    Args:
        budget: As diagnosis.json has it.
        joints: In words.
    """
    if budget is None:
        return Section("budget", TITLE, ())
    source = _source(budget)
    note = (
        "The misfit is the torque that the model misses with parameters and drive gains fitted within their "
        f"tolerances ({source}; root mean square). Its square is divided among what explains it."
    )
    plot = (
        "Each bar is 100 % of the squared misfit of a joint. Findings are drawn in cold colors, what depends "
        "on a recorded quantity but has no name in warm colors, and the rest in gray."
    )
    blocks: list[Block] = [
        Paragraph(note),
        Paragraph(plot, "plot"),
        Figure("Misfit by joint", f"{source}; root mean square on the right", budget_plot(budget, joints)),
        Statements(sentences(budget, joints)),
        *([] if budget.noise_measured_at_rest else [Paragraph(CONTAINED)]),
        _table(budget, joints),
    ]
    return Section("budget", TITLE, blocks)


TITLE = "Misfit by cause"


def _source(budget: BudgetTable) -> str:
    if budget.held_out:
        return f"held out: {', '.join(budget.held_out)}"
    return "fitted runs, each block predicted by the others"


def _shares(one: ShareRow) -> np.ndarray:
    return array_of(one.percent) / 100.0


def lumped(budget: BudgetTable) -> list[ShareRow]:
    """Its parts, with small kinds in one."""
    small = [one for one in budget.shares if _small(one)]
    if len(small) < 2:
        return list(budget.shares)
    kept = [one for one in budget.shares if not _small(one)]
    sums = np.sum([array_of(one.percent) for one in small], axis=0)
    last = [one for one in kept if one.name in (NOISE, OTHER)]
    first = [one for one in kept if one.name not in (NOISE, OTHER)]
    return [*first, ShareRow(LUMPED, "", (), None, tuple(sums)), *last]


def _small(one: ShareRow) -> bool:
    return one.finding is None and one.name not in (NOISE, OTHER) and bool(np.all(_shares(one) < SMALL))


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


def sentences(budget: BudgetTable, joints: Sequence[str]) -> list[str]:
    """One for each joint of which a finding explains a part, and one for all other joints."""
    parts = lumped(budget)
    whole = percents(np.array([_shares(one) for one in parts]))
    lines = [_sentence(budget, parts, joint, name, whole[:, joint]) for joint, name in enumerate(joints)]
    unexplained = [lower(name) for name, text in zip(joints, lines, strict=True) if not text]
    said = [text for text in lines if text]
    return [*said, f"No finding explains any misfit of {joined(unexplained)}."] if unexplained else said


def _sentence(
    budget: BudgetTable, parts: Sequence[ShareRow], joint: int, name: str, whole: np.ndarray
) -> str:
    size = f"{digits(array_of(budget.before_rms)[joint], 3)} {budget.units[joint]}"
    pairs = [(one, int(share)) for one, share in zip(parts, whole, strict=True) if share]
    explaining = sorted((pair for pair in pairs if pair[0].finding is not None), key=lambda pair: -pair[1])
    rest = [one for one in parts if one.finding is None and _shares(one)[joint] > 0.0]
    if not explaining:
        return ""
    (first, share), *others = explaining[:MOST]
    said = f"{name}: {_here(first, joint)} explains {share} % of the {size} that the model misses"
    if others:
        said += f", besides {joined([f'{_here(one, joint)} ({part} %)' for one, part in others])}"
    return f"{said}{_most(rest, joint, '; of the rest, ')}."


def _here(one: ShareRow, joint: int) -> str:
    """The finding's name, with its joint where that is another."""
    return lower(one.effect if one.joints in ((joint + 1,), ()) else one.name)


def _most(rest: Sequence[ShareRow], joint: int, opening: str) -> str:
    total = sum(float(_shares(one)[joint]) for one in rest)
    if total < SMALL:
        return ""
    largest = max(rest, key=lambda one: float(_shares(one)[joint]))
    share = float(_shares(largest)[joint]) / total
    amount = "most" if share > 0.5 else f"the largest part ({percent(share)})"
    if largest.name == NOISE:
        return f"{opening}{amount} is {NOISE}"
    # Older files have "goes with".
    known = largest.name.startswith(("depends on", "goes with"))
    return f"{opening}{amount} {largest.name if known else f'depends on {largest.name}'}"


def _table(budget: BudgetTable, joints: Sequence[str]) -> Table:
    """Misfit before and after, and the share of each part with the torque that it is, root mean square."""
    before = array_of(budget.before_rms)
    one_unit = f" [{budget.units[0]}]" if len(set(budget.units)) == 1 else ""
    units = [""] * len(joints) if one_unit else list(budget.units)
    rows: list[list[Cell]] = [
        [
            name + one_unit,
            *(Number(value, 3, unit) for value, unit in zip(array_of(values), units, strict=True)),
        ]
        for name, values in (("misfit before", budget.before_rms), ("misfit after", budget.after_rms))
    ]
    parts = lumped(budget)
    for one, whole in zip(parts, percents(np.array([_shares(one) for one in parts])), strict=True):
        if np.any(_shares(one) > SHOWN):
            rows.append([one.name, *map(_cell, _shares(one), whole, before)])
    return Table(["", *(name.partition(" (")[0].lower() for name in joints)], rows)


def _cell(share: float, whole: int, before: float) -> Cell:
    if not share > SHOWN:
        return "-"
    return Numbers(f"{whole or '< 1'} % ({{}})", (Number(np.sqrt(share) * before, 2),))


def budget_plot(budget: BudgetTable, joints: Sequence[str]) -> str:
    """Bars of 100 % each, with the misfit before and after beside them, and what the colours mean below."""
    shown = lumped(budget)
    colours = _colours(shown)
    parts = [text(LEFT + WIDTH + 8, 12, "before → after", "tick")]
    parts += [_bar(budget, shown, joint, name, colours) for joint, name in enumerate(joints)]
    bottom = 28 + STEP * len(joints)
    pairs = list(zip(shown, colours, strict=True))
    sides = [[one for one in pairs if (one[0].finding is None) == unnamed] for unnamed in (False, True)]
    sides = [side for side in sides if side]
    keys = "".join(
        _key(LEFT + KEYS * column, bottom + 18 * row, colour, part.name)
        for column, side in enumerate(sides)
        for row, (part, colour) in enumerate(side)
    )
    height = bottom + 18 * max(map(len, sides), default=0)
    return picture(LEFT + WIDTH + 190, height, "where the misfit goes", "".join(parts) + keys)


def _colours(parts: Sequence[ShareRow]) -> list[str]:
    colours, count = [], [0, 0]
    for part in parts:
        kind = int(part.finding is None)
        palette = (FOUND, KINDS)[kind]
        colours.append(PLAIN.get(part.name) or palette[count[kind] % len(palette)])
        count[kind] += part.name not in PLAIN
    return colours


def _bar(
    budget: BudgetTable, parts: Sequence[ShareRow], joint: int, name: str, colours: Sequence[str]
) -> str:
    top, x, unit = 20 + STEP * joint, LEFT, budget.units[joint]
    before, after = (array_of(values)[joint] for values in (budget.before_rms, budget.after_rms))
    drawn = [text(LEFT - 8, top + 15, name, "name end")]
    for part, colour in zip(parts, colours, strict=True):
        share = float(np.nan_to_num(_shares(part)[joint]))
        if share <= 0.0:
            continue
        width = WIDTH * share
        size = f"{digits(np.sqrt(share) * before, 3)} {unit}"
        title = f"<title>{escape(part.name)}: {digits(100 * share, 3)} %, {size}</title>"
        drawn.append(
            f'<rect fill="{colour}" x="{x:.1f}" y="{top:g}" width="{width:.1f}" height="20">{title}</rect>'
        )
        if share >= LEGIBLE:
            place = f'x="{x + width / 2:.1f}" y="{top + 14:g}"'
            drawn.append(f'<text {place} class="middle" style="fill:#fff">{100 * share:.0f} %</text>')
        x += width
    sizes = f"{digits(before, 3)} → {digits(after, 3)} {unit}"
    return "".join([*drawn, text(LEFT + WIDTH + 8, top + 15, sizes, "name")])


def _key(x: float, y: float, colour: str, name: str) -> str:
    sample = f'<rect fill="{colour}" x="{x:g}" y="{y - 9:g}" width="18" height="10"/>'
    return sample + text(x + 24, y, name, "key")
