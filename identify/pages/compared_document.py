"""Simulations compared with recordings: which joints differ, by how much, and where."""

import numpy as np

from ..document.document import Block, Cell, Document, Marked, Number, Paragraph, Section, Statements, Table
from ..fit.verdict import MISSING, TO_NOISE
from ..simulation.comparison import NAMES, Comparison, Mismatch, Regions
from ..text_table import digits, percent

MOST = 1.5
"""Ratio of a joint's mismatch in its worst and best third above which the worst third is reported; a uniform
mismatch varies less between the thirds of a run."""
ANOTHER = 0.1
"""Position difference, relative to the motion, from which on two runs are different motions [-]; even slow
position loops lag by less."""
SMALL = {"rad": "mrad", "m": "mm", "rad/s": "mrad/s", "m/s": "mm/s"}
"""Unit of a thousandth, which is readable for small differences, by unit."""


def compared_document(comparison: Comparison, note: str = "") -> Document:
    """The document of a comparison."""
    said, joints = Statements(verdict(comparison), "verdict"), _by_joint(comparison)
    sections = [
        Section("verdict", "Verdict", [said]),
        Section("joints", "Mismatch by joint, root mean square", [joints]),
        *(_by_region(comparison, mismatch) for mismatch in comparison.mismatch.values()),
    ]
    brief: list[Block] = [Paragraph(note)] if note else []
    brief += [said] if two_motions(comparison) else [said, joints]
    return Document(f"{comparison.simulated} versus {comparison.recorded}", note, sections, brief=brief)


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
    """Mismatch over noise, marked by the same limits as the residuals of a fit."""
    if not np.isfinite(over):
        return Number(over)
    kind = "good" if over <= TO_NOISE else "middling" if over <= MISSING else "bad"
    return Marked(Number(over, 3), kind, "" if kind == "good" else "differs by more than noise")


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
    """Readable units of a mismatch, in brackets."""
    return f" [{', '.join(dict.fromkeys(SMALL.get(unit, unit) for unit in mismatch.units))}]"


def _scaled(mismatch: Mismatch, values: np.ndarray) -> list[Cell]:
    """Values of all joints in readable units."""
    scale = np.array([1e3 if unit in SMALL else 1.0 for unit in mismatch.units])
    return [Number(value) for value in scale * values]


def differs(comparison: Comparison) -> bool:
    """Whether the motions agree and any joint differs by more than noise."""
    return bool(np.any(_over(comparison) > MISSING)) and not two_motions(comparison)


def two_motions(comparison: Comparison) -> bool:
    """Whether the runs are different motions, which cannot be compared."""
    position = comparison.mismatch["position"]
    return bool(np.linalg.norm(position.rms) > ANOTHER * np.linalg.norm(position.size))


def _over(comparison: Comparison) -> np.ndarray:
    """Mismatch of the effort over noise, shape (n,)."""
    return comparison.effort.rms / comparison.effort.noise


def verdict(comparison: Comparison) -> list[str]:
    """Sentences on the joints that differ most and on the limits of the comparison."""
    effort, over = comparison.effort, _over(comparison)
    if two_motions(comparison):
        position = comparison.mismatch["position"]
        most = int(np.argmax(position.rms))
        return [
            f"{comparison.simulated} and {comparison.recorded} are two different motions: "
            f"the positions of {comparison.joints[most]} differ by {digits(position.rms[most])} "
            f"{position.units[most]}."
        ]
    lines = []
    for joint in np.argsort(-np.nan_to_num(over)):
        if over[joint] > MISSING:
            lines.append(_joint(comparison, effort, int(joint)))
    if not lines and not np.any(np.isfinite(over)):
        most = int(np.argmax(effort.rms / effort.size))
        lines = [
            f"The noise is unknown, so {effort.quantity} is not judged. It differs most on "
            f"{comparison.joints[most]}, by {percent(effort.rms[most] / effort.size[most])} of its size."
        ]
    if not lines:
        most = int(np.nanargmax(over))
        lines = [
            f"No joint's {effort.quantity} differs by more than noise: at most {digits(over[most], 3)} x "
            f"noise, on {comparison.joints[most]}."
        ]
    lines.append(
        f"Compared over {comparison.duration:.1f} s behind a low-pass of {comparison.filter_hz:.3g} Hz, "
        f"{comparison.simulated} shifted by {round(comparison.offset, 4) + 0.0:.4f} s. "  # 0.0, not -0.0
        f"{effort.quantity.capitalize()} is compared only while the joint moves."
    )
    return [*lines, *(f"{warning[:1].upper()}{warning[1:]}." for warning in comparison.warnings)]


def _joint(comparison: Comparison, effort: Mismatch, joint: int) -> str:
    share = 100.0 * effort.rms[joint] / effort.size[joint]
    text = (
        f"{comparison.joints[joint]}: {effort.quantity} differs by {digits(effort.rms[joint])} "
        f"{effort.units[joint]} ({digits(share, 3)} % of its size, "
        f"{digits(effort.rms[joint] / effort.noise[joint], 3)} x noise)"
    )
    kind, ratio, most, least = max(
        ((name, *_contrast(regions, joint)) for name, regions in effort.regions.items()),
        key=lambda contrast: contrast[1],
    )
    if ratio < MOST:
        return f"{text}, about equally everywhere."
    where = f"{NAMES[most]} {kind} ({_span(comparison, kind, joint, most)})"
    return f"{text}; {digits(ratio, 2)} times as large at {where} as at {NAMES[least]} {kind}."


def _contrast(regions: Regions, joint: int) -> tuple[float, int, int]:
    """Ratio of the mismatches in the worst and the best third, and the indices of both."""
    rms = regions.rms[joint]
    if not np.all(np.isfinite(rms)) or np.min(rms) <= 0.0:
        return 0.0, 0, 0
    most, least = int(np.argmax(rms)), int(np.argmin(rms))
    return float(rms[most] / rms[least]), most, least


def _span(comparison: Comparison, kind: str, joint: int, third: int) -> str:
    """Range of a third, with its unit."""
    position, velocity, effort = comparison.mismatch.values()
    unit = {"position": position, "speed": velocity, "load": effort}[kind].units[joint]
    low, high = effort.regions[kind].edges[joint, third : third + 2]
    return f"{digits(low)} to {digits(high)} {unit}"
