"""Simulations beside recordings: who differs how far from what was measured, and where."""

from collections.abc import Sequence

import numpy as np

from ..document.document import (
    Cell,
    Document,
    Figure,
    Grid,
    Heading,
    Marked,
    Number,
    Paragraph,
    Section,
    Statements,
    Table,
)
from ..document.text import text
from ..fit.verdict import MISSING, TO_NOISE
from ..simulation.comparison import NAMES, Comparison, Mismatch, Regions
from ..text_table import digits, percent
from .diagnosis_plots import bars

MOST = 1.5
"""Ratio of a mismatch in its worst third to that in its best from which on it is reported to depend on
something: more than between thirds of a run in which it is the same everywhere."""
ANOTHER = 0.1
"""Share of the motion by which positions differ in another one; the slowest position loops lag by less."""
SMALL = {"rad": "mrad", "m": "mm", "rad/s": "mrad/s", "m/s": "mm/s"}
"""Units of what hardly differs -> a thousandth of them, which people use."""


def compared_text(comparison: Comparison) -> str:
    """The document as text; a line or three where there is nothing to see."""
    if two_motions(comparison):
        return verdict(comparison)[0]
    if not differs(comparison):
        return "\n".join([*_alike(comparison), *map(_sentence, comparison.warnings)])
    title = f"{comparison.simulated} beside {comparison.recorded}"
    said = Section("verdict", "Verdict", [Statements(verdict(comparison), "verdict")])
    return text(Document(title, "", [said, *_tables(comparison)]))


def compared_sections(comparisons: Sequence[tuple[Comparison, Sequence[str]]]) -> list[Section]:
    """Pairs of the same recording before and after, then a section for each comparison with its verdict."""
    pairs = zip(comparisons, comparisons[1:], strict=False)
    sections = [_pair(first, last) for (first, _), (last, _) in pairs if _same_recording(first, last)]
    for place, (comparison, said) in enumerate(comparisons):
        blocks = [
            block for section in _tables(comparison) for block in (Heading(section.title), *section.blocks)
        ]
        title = f"{comparison.simulated} beside {comparison.recorded}"
        sections.append(Section(f"compared{place or ''}", title, [Statements(said), *blocks]))
    return sections


def _same_recording(first: Comparison, last: Comparison) -> bool:
    """Whether two simulations are judged by one recording, in one unit, over a noise that is known."""
    same = first.recorded == last.recorded and first.effort.quantity == last.effort.quantity
    return same and all(bool(np.all(np.isfinite(one.effort.noise))) for one in (first, last))


def _pair(first: Comparison, last: Comparison) -> Section:
    before, after = (one.effort.rms / one.effort.noise for one in (first, last))
    note = f"Before: {first.simulated}, after: {last.simulated}; both beside the recording {first.recorded}."
    picture = bars(before, after, first.joints, "residual over noise")
    figure = Figure(f"Simulated less recorded {first.effort.quantity}", "over noise", picture)
    return Section("pair", "Two simulations", [Paragraph(note), Grid([figure])])


def _tables(comparison: Comparison) -> list[Section]:
    by_joint = Section("joints", "Mismatch by joint, root mean square", [_by_joint(comparison)])
    return [by_joint, *(_by_region(comparison, mismatch) for mismatch in comparison.mismatch.values())]


def _by_joint(comparison: Comparison) -> Table:
    effort, over = comparison.effort, _over(comparison)
    head, columns = ["joint"], list[list[Cell]]([list(comparison.joints)])
    for mismatch in comparison.mismatch.values():
        head.append(mismatch.quantity + _unit(mismatch))
        columns.append(_scaled(mismatch, mismatch.rms))
    head += [f"{effort.quantity} mean", "% of recorded", "over noise"]
    columns += [list(map(Number, effort.mean)), list(map(Number, 100.0 * effort.rms / effort.size))]
    columns.append([_judged(value) for value in over])
    return Table(head, [list(row) for row in zip(*columns, strict=True)])


def _judged(over: float) -> Cell:
    """Coloured as residuals of a fit are."""
    if not np.isfinite(over):
        return Number(over)
    kind = "good" if over <= TO_NOISE else "middling" if over <= MISSING else "bad"
    return Marked(Number(over, 3), kind, "" if kind == "good" else "it differs by more than noise")


def _by_region(comparison: Comparison, mismatch: Mismatch) -> Section:
    head, columns = ["joint"], list[list[Cell]]([list(comparison.joints)])
    for kind, regions in mismatch.regions.items():
        for third, name in enumerate(NAMES):
            head.append(f"{kind} {name}")
            columns.append(_scaled(mismatch, regions.rms[:, third]))
    title = f"Mismatch of {mismatch.quantity}{_unit(mismatch)} by region, a third of the samples each"
    table = Table(head, [list(row) for row in zip(*columns, strict=True)])
    return Section(mismatch.quantity, title, [table])


def _unit(mismatch: Mismatch) -> str:
    """The units that people use, in brackets."""
    return f" [{', '.join(dict.fromkeys(SMALL.get(unit, unit) for unit in mismatch.units))}]"


def _scaled(mismatch: Mismatch, values: np.ndarray) -> list[Cell]:
    """Numbers of all joints in the units that people use."""
    scale = np.array([1e3 if unit in SMALL else 1.0 for unit in mismatch.units])
    return [Number(value) for value in scale * values]


def differs(comparison: Comparison) -> bool:
    """Whether any joint differs by more than noise, in the same motion."""
    return bool(np.any(_over(comparison) > MISSING)) and not two_motions(comparison)


def two_motions(comparison: Comparison) -> bool:
    """Whether both did other things, so that there is nothing to compare."""
    position = comparison.mismatch["position"]
    return bool(np.linalg.norm(position.rms) > ANOTHER * np.linalg.norm(position.size))


def _over(comparison: Comparison) -> np.ndarray:
    """Mismatch of the effort over noise, shape (n,)."""
    return comparison.effort.rms / comparison.effort.noise


def _alike(comparison: Comparison) -> list[str]:
    """Three lines about two runs that do not differ."""
    over = np.nan_to_num(_over(comparison))
    most = int(np.argmax(over))
    return [
        f"No joint's {comparison.effort.quantity} differs by more than noise: {comparison.simulated} beside "
        f"{comparison.recorded}",
        f"The largest: {comparison.joints[most]}, {digits(over[most], 3)} x noise; there is nothing to "
        "diagnose",
        _compared(comparison),
    ]


def _compared(comparison: Comparison) -> str:
    """How both were brought together; an offset of less than its last digit has no sign."""
    return (
        f"Compared over {comparison.duration:.1f} s behind a low-pass of {comparison.filter_hz:.3g} Hz, "
        f"{comparison.simulated} moved by {round(comparison.offset, 4) + 0.0:.4f} s"
    )


def _sentence(warning: str) -> str:
    return f"{warning[:1].upper()}{warning[1:]}."


def verdict(comparison: Comparison) -> list[str]:
    """What differs most, and what should be known of the comparison, in sentences."""
    effort, over = comparison.effort, _over(comparison)
    if two_motions(comparison):
        position = comparison.mismatch["position"]
        most = int(np.argmax(position.rms))
        return [
            f"{comparison.simulated} and {comparison.recorded} are two different motions: "
            f"{comparison.joints[most]} is {digits(position.rms[most])} {position.units[most]} elsewhere."
        ]
    lines = []
    for joint in np.argsort(-np.nan_to_num(over)):
        if over[joint] > MISSING:
            lines.append(_joint(comparison, effort, int(joint)))
    if not lines and not np.any(np.isfinite(over)):
        most = int(np.argmax(effort.rms / effort.size))
        lines = [
            f"The noise is not known, so that {effort.quantity} is not judged. It differs most on "
            f"{comparison.joints[most]}, by {percent(effort.rms[most] / effort.size[most])} of what it is."
        ]
    if not lines:
        lines = [f"No joint's {effort.quantity} differs by more than noise: there is nothing to diagnose."]
    lines.append(
        f"{_compared(comparison)}. {effort.quantity.capitalize()} counts while the joint moves, not at rest."
    )
    return [*lines, *map(_sentence, comparison.warnings)]


def _joint(comparison: Comparison, effort: Mismatch, joint: int) -> str:
    share = 100.0 * effort.rms[joint] / effort.size[joint]
    text = (
        f"{comparison.joints[joint]}: {effort.quantity} differs by {digits(effort.rms[joint])} "
        f"{effort.units[joint]}, {digits(share, 3)} % of what it is and "
        f"{digits(effort.rms[joint] / effort.noise[joint], 3)} x noise"
    )
    kind, ratio, most, least = max(
        ((name, *_contrast(regions, joint)) for name, regions in effort.regions.items()),
        key=lambda found: found[1],
    )
    if ratio < MOST:
        return f"{text}, everywhere alike."
    where = f"{NAMES[most]} {kind} ({_span(comparison, kind, joint, most)})"
    return f"{text}; {digits(ratio, 2)} times as much at {where} as at {NAMES[least]}."


def _contrast(regions: Regions, joint: int) -> tuple[float, int, int]:
    """Mismatch in the worst third over that in the best, and which they are."""
    rms = regions.rms[joint]
    if not np.all(np.isfinite(rms)) or np.min(rms) <= 0.0:
        return 0.0, 0, 0
    most, least = int(np.argmax(rms)), int(np.argmin(rms))
    return float(rms[most] / rms[least]), most, least


def _span(comparison: Comparison, kind: str, joint: int, third: int) -> str:
    """From where to where a third goes."""
    position, velocity, effort = comparison.mismatch.values()
    unit = {"position": position, "speed": velocity, "load": effort}[kind].units[joint]
    low, high = effort.regions[kind].edges[joint, third : third + 2]
    return f"{digits(low)} to {digits(high)} {unit}"
