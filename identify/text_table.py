"""Tables of numbers as text: four significant digits, aligned at the decimal point."""

import textwrap
from collections.abc import Sequence

import numpy as np

WIDTH = 110
"""Columns of a page: what a terminal beside an editor still shows."""

SMALL, LARGE = 1e-4, 1e7
"""Sizes below and above which a number is written with an exponent."""


def digits(value: float) -> str:
    """A number with four significant digits; all digits before the point are kept."""
    if not np.isfinite(value):
        return "-"
    size = abs(value)
    if value == 0:
        return "0"
    if not SMALL <= size < LARGE:
        return f"{value:.3e}"
    return f"{value:.{max(0, 3 - int(np.floor(np.log10(size))))}f}"


def at_point(texts: Sequence[str]) -> list[str]:
    """Numbers padded on the right so that their points stand below each other when right-aligned."""
    behind = [len(text) - text.index(".") if "." in text and "e" not in text else 0 for text in texts]
    widest = max(behind, default=0)
    return [text + " " * (widest - after) for text, after in zip(texts, behind, strict=True)]


def table(
    head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[int] = (0,), gap: int = 2
) -> list[str]:
    """Lines of a table; columns in `left` are aligned left, the others right.

    A row of one cell is a heading, written as it is.
    """
    full = [head, *(row for row in rows if len(row) == len(head))]
    widths = [max(len(row[column]) for row in full) for column in range(len(head))]
    lines = []
    for row in (head, *rows):
        if len(row) != len(head):
            lines.append(row[0])
            continue
        cells = (
            cell.ljust(width) if column in left else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        lines.append((" " * gap).join(cells).rstrip())
    return lines


def paragraph(text: str, indent: str = "", first: str | None = None) -> list[str]:
    """A text wrapped to the page; lines after the first begin with `indent`."""
    opening = indent if first is None else first
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=opening,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
