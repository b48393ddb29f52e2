"""The budget as a picture: one bar a joint, of what the misfit consists of."""

from collections.abc import Sequence
from html import escape

import numpy as np

from ...diagnosis.results.budget import NOISE, OTHER
from ...diagnosis.words.misfit import Misfit, Part, lumped
from ..svg import picture, text

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


def budget_plot(found: Misfit) -> str:
    """Bars of 100 % each, with the misfit before and after beside them, and what the colours mean below."""
    shown = lumped(found)
    colours = _colours(shown.parts)
    parts = [text(LEFT + WIDTH + 8, 12, "before → after", "tick")]
    for joint, name in enumerate(shown.joints):
        parts.append(_bar(shown, joint, name, colours))
    bottom = 28 + STEP * len(shown.joints)
    pairs = list(zip(shown.parts, colours, strict=True))
    sides = [[one for one in pairs if (one[0].place is None) == unnamed] for unnamed in (False, True)]
    sides = [side for side in sides if side]
    keys = "".join(
        _key(LEFT + KEYS * column, bottom + 18 * row, colour, part.name)
        for column, side in enumerate(sides)
        for row, (part, colour) in enumerate(side)
    )
    height = bottom + 18 * max(map(len, sides), default=0)
    return picture(LEFT + WIDTH + 190, height, "where the misfit goes", "".join(parts) + keys)


def _colours(parts: Sequence[Part]) -> list[str]:
    colours, count = [], [0, 0]
    for part in parts:
        kind = int(part.place is None)
        palette = (FOUND, KINDS)[kind]
        colours.append(PLAIN.get(part.name) or palette[count[kind] % len(palette)])
        count[kind] += part.name not in PLAIN
    return colours


def _bar(found: Misfit, joint: int, name: str, colours: Sequence[str]) -> str:
    top, x = 20 + STEP * joint, LEFT
    parts = [text(LEFT - 8, top + 15, name, "name end")]
    for part, colour in zip(found.parts, colours, strict=True):
        share = float(np.nan_to_num(part.shares[joint]))
        width, percent = WIDTH * share, f"{100 * share:.0f} %"
        if share <= 0.0:
            continue
        size = f"{np.sqrt(share) * found.before[joint]:.3g} {found.units[joint]}"
        title = f"<title>{escape(part.name)}: {100 * share:.3g} %, {size}</title>"
        parts.append(
            f'<rect fill="{colour}" x="{x:.1f}" y="{top:g}" width="{width:.1f}" height="20">{title}</rect>'
        )
        if share >= LEGIBLE:
            middle = x + width / 2
            parts.append(
                f'<text x="{middle:.1f}" y="{top + 14:g}" class="middle" style="fill:#fff">{percent}</text>'
            )
        x += width
    sizes = f"{found.before[joint]:.3g} → {found.after[joint]:.3g} {found.units[joint]}"
    return "".join([*parts, text(LEFT + WIDTH + 8, top + 15, sizes, "name")])


def _key(x: float, y: float, colour: str, name: str) -> str:
    sample = f'<rect fill="{colour}" x="{x:g}" y="{y - 9:g}" width="18" height="10"/>'
    return sample + text(x + 24, y, name, "key")
