"""Tables of numbers as text: four significant digits, aligned at the decimal point."""

import re
import textwrap
from collections.abc import Sequence

import numpy as np

WIDTH = 80
"""Columns of a page: what every terminal shows."""
INDENT = 2
"""Columns that are left to who indents a table."""
TOGETHER = re.compile(r" x (its )?noise| %|\bN m\b")
"""What no line begins with."""
STAYS = "\N{NO-BREAK SPACE}"
LEAST_SENTENCE = 20
"""Width below which a column of sentences is not wrapped."""
KEYS = 2
"""Columns on the left, at most, that stand beside those below once more."""
MOST_NARROW = 5
"""Width to which heads of columns are folded at most."""

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

    A row of one cell is a heading, written as it is. What is too wide for the page gets its heads, and the
    sentences of a last column, in several lines; if that is not enough, its last columns stand below, beside
    those on the left once more.
    """
    columns = list(range(len(head)))
    lines = _laid(head, rows, columns, left, gap)
    if not _too_wide(lines):
        return lines
    for narrower in (gap, 1):
        lines = _laid(head, rows, columns, left, narrower, folded=True)
        if not _too_wide(lines):
            return lines
    if columns[-1] in left:
        room = (
            WIDTH
            - INDENT
            - max(len(line) for line in _laid(head, rows, columns[:-1], left, gap, folded=True))
        )
        if room - gap >= LEAST_SENTENCE:
            return _laid(head, _wrapped(rows, len(head), room - gap), columns, left, gap, folded=True)
    keys = [column for column in columns[:KEYS] if column in left]
    if len(columns) - len(keys) < 2:
        return lines
    for count in range(len(columns) - 1, len(keys), -1):
        first = _laid(head, rows, columns[:count], left, gap, folded=True)
        if count == len(keys) + 1 or not _too_wide(first):
            break
    rest = [*keys, *columns[count:]]
    below = [[row[column] for column in rest] if len(row) == len(head) else row for row in rows]
    under = [place for place, column in enumerate(rest) if column in left]
    return [*first, *table([head[column] for column in rest], below, under, gap)]


def _wrapped(rows: Sequence[Sequence[str]], count: int, width: int) -> list[Sequence[str]]:
    """Rows of `count` cells, the last of which is continued below where it is wider than `width`."""
    found: list[Sequence[str]] = []
    for row in rows:
        if len(row) != count:
            found.append(row)
            continue
        first, *more = textwrap.wrap(row[-1], width, break_on_hyphens=False) or [""]
        found += [[*row[:-1], first], *([*[""] * (count - 1), line] for line in more)]
    return found


def _too_wide(lines: Sequence[str]) -> bool:
    return max(map(len, lines)) > WIDTH - INDENT


def _laid(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    columns: Sequence[int],
    left: Sequence[int],
    gap: int,
    folded: bool = False,
) -> list[str]:
    """Lines of some columns of a table, with heads as narrow as their words and cells if folded."""
    full = [row for row in rows if len(row) == len(head)]
    cells = [max((len(row[column]) for row in full), default=0) for column in columns]
    heads = [
        textwrap.wrap(head[column], max(width, MOST_NARROW), break_long_words=False)
        if folded
        else [head[column]]
        for column, width in zip(columns, cells, strict=True)
    ]
    deep = max(map(len, heads))
    heads = [[""] * (deep - len(words)) + words for words in heads]
    widths = [max(width, *map(len, words)) for width, words in zip(cells, heads, strict=True)]
    lines = []
    for row in [*zip(*heads, strict=True), *rows]:
        if isinstance(row, tuple):
            texts = list(row)
        elif len(row) == len(head):
            texts = [row[column] for column in columns]
        else:
            lines.append(row[0])
            continue
        padded = (
            text.ljust(width) if column in left else text.rjust(width)
            for column, text, width in zip(columns, texts, widths, strict=True)
        )
        lines.append((" " * gap).join(padded).rstrip())
    return lines


def paragraph(text: str, indent: str = "", first: str | None = None, width: int = WIDTH) -> list[str]:
    """A text wrapped to the page, numbers beside their signs; lines after the first begin with `indent`."""
    opening = indent if first is None else first
    lines = textwrap.wrap(
        TOGETHER.sub(lambda found: found[0].replace(" ", STAYS), text),
        width,
        initial_indent=opening,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(STAYS, " ") for line in lines]
