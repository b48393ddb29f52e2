"""Tables of numbers as text: four significant digits, aligned at the decimal point."""

import re
import textwrap
from collections.abc import Sequence
from contextvars import ContextVar

import numpy as np

WIDTH, WIDEST = 80, 120
"""Width of a page in characters, which every terminal can show, and of the widest page that reads well."""
page_width = ContextVar("page_width", default=WIDTH)
"""Width of the pages of this command; a command sets that of its terminal."""
INDENT = 2
"""Width reserved for callers that indent a table, in characters."""
TOGETHER = re.compile(r" x (its )?noise| %|\bN m\b| ?-> | ± ")
"""Texts inside which no line is broken."""
TIME = re.compile(r"(?<=\d) (?=s\b)")
"""Space between a time and its unit."""
STAYS = "\N{NO-BREAK SPACE}"
LEAST_SENTENCE = 20
"""Width below which a column of sentences is not wrapped."""
KEYS = 2
"""Maximum number of columns on the left that are repeated beside columns moved below."""
MOST_NARROW = 5
"""Least width to which the heads of columns are folded."""

NORMAL_95 = 1.96
"""Half-width of a 95 % interval in standard deviations; ± always means this interval."""
SMALL, LARGE = 1e-4, 1e7
"""Magnitudes below and above which a number is written with an exponent."""
UNKNOWN = "-"
"""Text for an unknown number."""


def raised(text: str) -> str:
    """Text with raised exponents: kg m² for kg m^2."""
    return text.replace("^2", "\N{SUPERSCRIPT TWO}").replace("^3", "\N{SUPERSCRIPT THREE}")


def digits(value: float, significant: int = 4) -> str:
    """A number with `significant` digits; all digits before the decimal point are kept."""
    value = float(value)
    if not np.isfinite(value):
        return UNKNOWN
    if value == 0.0:
        return "0"
    mantissa, exponent = f"{value:.{significant - 1}e}".split("e")
    if SMALL <= abs(value) < LARGE:
        return f"{value:.{max(0, significant - 1 - int(exponent))}f}"
    return f"{mantissa}e{int(exponent)}"


def percent(share: float, significant: int = 2) -> str:
    """A share in percent, such as "97 %"; shares close to 0 or 1 are bounded: "below 0.1 %"."""
    if 0.0 < share < 1e-3:
        return "below 0.1 %"
    if 0.999 < share <= 1.0:
        return "above 99.9 %"
    value = digits(100.0 * share, 3 if share > 0.99 else significant)
    return f"{value.rstrip('0').rstrip('.') if '.' in value else value} %"


def fixed(value: float, places: int) -> str:
    """A number with `places` digits after the decimal point; a number that rounds to zero has no sign."""
    return f"{round(float(value), places) + 0.0:.{places}f}"


def at_point(texts: Sequence[str]) -> list[str]:
    """Numbers padded on the right so that their decimal points align when the numbers are right-aligned."""
    decimals = [len(text) - text.index(".") if "." in text and "e" not in text else 0 for text in texts]
    most = max(decimals, default=0)
    return [text + " " * (most - count) for text, count in zip(texts, decimals, strict=True)]


def table(
    head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[int] = (0,), gap: int = 2
) -> list[str]:
    """Lines of a table; columns in `left` are aligned left, the others right.

    A row of one cell is a heading, written unchanged. If the table is too wide for the page, its heads are
    folded, then the sentences of the last column or the widest column of words are wrapped. If that is not
    enough, the last columns are moved below, beside a copy of the columns on the left.
    """
    lines = _laid([[words] for words in head], rows, range(len(head)), left, gap)
    if not _too_wide(lines):
        return lines
    return _narrow(_folded(head, _widths(rows, len(head))), rows, left, gap)


Heads = Sequence[Sequence[str]]
"""Lines of the head of each column."""


def _narrow(
    heads: Heads, rows: Sequence[Sequence[str]], left: Sequence[int], gap: int, repeated: int = 0
) -> list[str]:
    """Lines of a table with folded heads; if it is still too wide, its last columns are moved below.

    The first `repeated` columns are copies; if their number is `KEYS`, the last of them may be dropped.
    """
    columns = list(range(len(heads)))
    for narrower in (gap, 1):
        lines = _laid(heads, rows, columns, left, narrower)
        if not _too_wide(lines):
            return lines
    widths = _widths(rows, len(heads))
    # A last column of sentences is wrapped first, else the widest column of words.
    words = [columns[-1]] if columns[-1] in left else []
    words += [max(left, key=lambda column: widths[column])] if left and rows else []
    for column in words:
        others = [index for index in columns if index != column]
        beside = max(map(len, _laid(heads, rows, others, left, gap))) + gap if others else 0
        room = page_width.get() - INDENT - beside
        if room >= LEAST_SENTENCE:
            return _laid(heads, _wrapped(rows, column, len(heads), room), columns, left, gap)
    keys = [column for column in columns[:KEYS] if column in left]
    if len(columns) - len(keys) < 2:
        dropped = repeated == len(keys) == KEYS
        return _narrow(*_without(keys[-1], heads, rows, left), gap, repeated - 1) if dropped else lines
    for count in range(len(columns) - 1, len(keys), -1):
        first = _laid(heads, rows, columns[:count], left, gap)
        if count == len(keys) + 1 or not _too_wide(first):
            break
    moved = [*keys, *columns[count:]]
    below = [[row[column] for column in moved] if len(row) == len(heads) else row for row in rows]
    under = [place for place, column in enumerate(moved) if column in left]
    return [*first, *_narrow([heads[column] for column in moved], below, under, gap, len(keys))]


def _without(
    column: int, heads: Heads, rows: Sequence[Sequence[str]], left: Sequence[int]
) -> tuple[Heads, list[Sequence[str]], list[int]]:
    """Heads, rows and left-aligned columns of the table after one column is removed."""
    fewer = [[*row[:column], *row[column + 1 :]] if len(row) == len(heads) else row for row in rows]
    still_left = [index - (index > column) for index in left if index != column]
    return [*heads[:column], *heads[column + 1 :]], fewer, still_left


def _widths(rows: Sequence[Sequence[str]], count: int) -> list[int]:
    """Width of the cells of each of `count` columns."""
    full = [row for row in rows if len(row) == count]
    return [max((len(row[column]) for row in full), default=0) for column in range(count)]


def _wrapped(rows: Sequence[Sequence[str]], column: int, count: int, width: int) -> list[Sequence[str]]:
    """Rows of `count` cells; a cell of the column that is wider than `width` continues in rows below."""
    wrapped: list[Sequence[str]] = []
    for row in rows:
        if len(row) != count:
            wrapped.append(row)
            continue
        first, *more = _wrap(row[column], width) or [""]
        wrapped.append([*row[:column], first, *row[column + 1 :]])
        wrapped += [[line if place == column else "" for place in range(count)] for line in more]
    return wrapped


def _too_wide(lines: Sequence[str]) -> bool:
    return max(map(len, lines)) > page_width.get() - INDENT


def _laid(
    heads: Heads, rows: Sequence[Sequence[str]], columns: Sequence[int], left: Sequence[int], gap: int
) -> list[str]:
    """Lines of some columns of a table."""
    cells = _widths(rows, len(heads))
    deep = max(len(heads[column]) for column in columns)
    words = [[*[""] * (deep - len(heads[column])), *heads[column]] for column in columns]
    widths = [max(cells[column], *map(len, head)) for column, head in zip(columns, words, strict=True)]
    lines = []
    for row in [*zip(*words, strict=True), *rows]:
        if isinstance(row, tuple):
            texts = list(row)
        elif len(row) == len(heads):
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


def _folded(heads: Sequence[str], cells: Sequence[int]) -> list[list[str]]:
    """Lines of each head over cells of these widths; heads that differ only in a number fold alike.

    A time stays on the line of its unit.
    """
    kinds = [re.sub(r"\d+", "", head) for head in heads]
    narrowest = {
        kind: max(MOST_NARROW, min(width for width, of in zip(cells, kinds, strict=True) if of == kind))
        for kind in kinds
    }
    return [
        [
            line.replace(STAYS, " ")
            for line in textwrap.wrap(
                TIME.sub(STAYS, head), narrowest[kind], break_long_words=False, break_on_hyphens=False
            )
        ]
        for head, kind in zip(heads, kinds, strict=True)
    ]


def paragraph(text: str, indent: str = "", first: str | None = None, narrower: int = 0) -> list[str]:
    """A text wrapped to the page, with numbers and units together; later lines begin with `indent`.

    Lines are shorter than the page by `narrower` characters.
    """
    return _wrap(text, page_width.get() - narrower, indent, indent if first is None else first)


def _wrap(text: str, width: int, indent: str = "", first: str = "") -> list[str]:
    """Lines of a text, with numbers and units together."""
    lines = textwrap.wrap(
        TOGETHER.sub(lambda match: match[0].replace(" ", STAYS), text),
        width,
        initial_indent=first,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(STAYS, " ") for line in lines]
