"""Simulations beside recordings: who differs how far from what was measured, and where."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from ...fit.verdict import EXPLAINED, LITTLE, MISSING, TO_NOISE
from ...simulation.comparison import NAMES, Comparison, Mismatch
from ..diagnosis.plots import bars
from ..report_html import figure, grid, heading, listing, number, paragraph, section, table
from .material import Compared


def compared_sections(comparisons: Sequence[Compared]) -> str:
    """Pairs of the same recording before and after, then a section for each comparison."""
    parts = [
        _pair(first.comparison, last.comparison)
        for first, last in zip(comparisons, comparisons[1:], strict=False)
        if _alike(first.comparison, last.comparison)
    ]
    return "".join(parts) + "".join(_one(one, place) for place, one in enumerate(comparisons))


def _alike(first: Comparison, last: Comparison) -> bool:
    """Whether two simulations are judged by one recording, in one unit, over a noise that is known."""
    same = first.recorded == last.recorded and first.effort.quantity == last.effort.quantity
    return same and all(bool(np.all(np.isfinite(one.effort.noise))) for one in (first, last))


def _pair(first: Comparison, last: Comparison) -> str:
    quantity = first.effort.quantity
    before, after = (one.effort.rms / one.effort.noise for one in (first, last))
    note = f"Before: {first.simulated}, after: {last.simulated}; both beside the recording {first.recorded}."
    picture = bars(before, after, first.joints, "residual over noise")
    return section(
        "pair",
        "Two simulations",
        paragraph(note),
        grid(figure(f"Simulated less recorded {quantity}", "over noise", picture)),
    )


def _one(one: Compared, place: int) -> str:
    found, effort = one.comparison, one.comparison.effort
    by_joint = heading("By joint, root mean square") + _joints(found)
    region = heading(f"{effort.quantity.capitalize()} by region [{_units(effort)}]") + _regions(found, effort)
    both = grid(*(Markup("<div>{}</div>").format(half) for half in (by_joint, region)), kind="two tables")
    title = f"{found.simulated} beside {found.recorded}"
    return section(f"compared{place or ''}", title, listing(one.verdict), both)


def _joints(found: Comparison) -> Markup:
    effort = found.effort
    over = effort.rms / effort.noise
    rows = [
        [
            name,
            *(number(mismatch.rms[joint], 3) for mismatch in found.mismatches),
            number(100.0 * effort.rms[joint] / effort.size[joint], 3),
            _judged(over[joint]),
        ]
        for joint, name in enumerate(found.joints)
    ]
    head = [f"{mismatch.quantity} [{_units(mismatch)}]" for mismatch in found.mismatches]
    return table(["joint", *head, "% of recorded", "over noise"], rows)


def _judged(over: float) -> str:
    """Coloured as residuals of a fit are."""
    if not np.isfinite(over):
        return number(over)
    kind = "good" if over <= TO_NOISE else "middling" if over <= MISSING else "bad"
    words = {"good": EXPLAINED, "middling": LITTLE}.get(kind, "it differs by more than noise")
    return Markup('<td class="{}" title="{}">{}</td>').format(kind, words, number(over, 3))


def _regions(found: Comparison, mismatch: Mismatch) -> Markup:
    """The mismatch in thirds of speed, position and load."""
    rows = [
        [
            name,
            *(number(value, 3) for regions in mismatch.regions.values() for value in regions.rms[joint]),
        ]
        for joint, name in enumerate(found.joints)
    ]
    head = [f"{kind} {name}" if name == NAMES[0] else name for kind in mismatch.regions for name in NAMES]
    return table(["joint", *head], rows)


def _units(mismatch: Mismatch) -> str:
    return ", ".join(dict.fromkeys(mismatch.units))
