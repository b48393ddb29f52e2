"""Where the misfit goes: the first section of the page."""

import numpy as np

from ...diagnosis.words.misfit import CONTAINED, Misfit, sentences
from ..report_html import NAMELESS, figure, listing, number, paragraph, section, table
from .budget_plot import budget_plot
from .page_data import PageData

SHOWN = 5e-4
"""Share from which on a part is in the table: a tenth of a per cent, rounded."""


def budget_section(diagnosis: PageData) -> str:
    """The picture, a sentence a joint, and the table; nothing for a diagnosis without."""
    found = diagnosis.misfit
    if found is None:
        return ""
    note = (
        "What the model, its parameters fitted within their tolerances, misses of the recorded torque, by "
        "what explains it. Each bar is 100 % of the squared misfit of a joint. Findings have cold colours, "
        "what has no name and depends on something recorded warm ones; what depends on nothing is grey."
    )
    remark = f"{found.source}; root mean square before and after on the right"
    content = [
        paragraph(note),
        figure("Misfit by joint", remark, budget_plot(found)),
        listing(sentences(found)),
    ]
    if not found.noise_measured:
        content.append(paragraph(CONTAINED))
    return section("budget", "Where the misfit goes", *content, _table(found))


def _table(found: Misfit) -> str:
    """Shares in per cent, and the torque that they are, root mean square."""
    rows = [
        [name, *(number(v, 3) + f" {u}" for v, u in zip(values, found.units, strict=True))]
        for name, values in (("misfit before", found.before), ("misfit after", found.after))
    ]
    for part in (part for part in found.parts if np.any(part.shares > SHOWN)):
        sizes = np.sqrt(np.maximum(part.shares, 0.0)) * found.before
        cells = [_cell(*one) for one in zip(part.shares, sizes, found.units, strict=True)]
        rows.append([part.name, *cells])
    return table(["", *found.joints], rows, words=(0,))


def _cell(share: float, size: float, unit: str) -> str:
    return f"{100.0 * share:.1f} % (" + number(size, 2) + f" {unit})" if share > SHOWN else NAMELESS
