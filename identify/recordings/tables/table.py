"""Table: named columns of numbers, from a text file or from arrays."""

import re
from array import array
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from errno import EFBIG
from functools import partial
from itertools import islice
from pathlib import Path
from typing import NamedTuple
from warnings import catch_warnings, simplefilter

import numpy as np

from ...errors import ExidynError, NotAFile, WrongShape
from ..reading_limits import largest_size, opened, require_gzip, too_large
from .cells import (
    COMMENT,
    PREAMBLE,
    Layout,
    cells_of,
    decimal_mark,
    is_missing,
    layout_of,
    number,
    onward,
    seconds_of,
    without_empty_end,
)
from .name_index import is_unit, names_joints, stated_unit

LONGEST_LINE = 1_000_000
"""Maximum length of a line in characters: ten thousand columns of a hundred characters."""
DATE = "date"
"""Unit of a column of dates or times of day; the table holds them in seconds."""
_COMMENTED = re.compile(r"(?:^|\s)#(?!(?:N/A|NA|NV|NUM!|WERT!|VALUE!|DIV/0!|REF!|NAME\?)).*")
Rows = Callable[[], Iterator[tuple[int, str]]]


class Table(NamedTuple):
    """Content of a file for one run."""

    names: list[str]  # names of the c columns, all different
    values: np.ndarray  # values, shape (t, c); NaN if a cell is empty, a word for a missing number, or text
    # Line of each row in the file, from 1, shape (t,); None if the file has no lines.
    lines: np.ndarray | None = None
    text: Mapping[str, str] = {}  # name of a column with text -> the first such cell, and its place
    # Name of a column that names joints -> the names; its values are their places in this list, from 1.
    labels: Mapping[str, Sequence[str]] = {}
    run: str = ""  # name of the run, if a file holds several
    joints: tuple[str, ...] = ()  # names of the joints, if the file states them for numbered columns
    # Name of a column -> its unit, if a line below the names states it; or `DATE`.
    units: Mapping[str, str] = {}
    above: int = 0  # number of rows between the names and the first sample, such as a row of units
    first: int = 0  # number of rows in the file before the first row
    # Lines that repeat the names of the columns, because a recorder appends its runs.
    repeated: tuple[int, ...] = ()

    def place(self, row: int) -> str:
        """Place of a row in its file, for messages."""
        return f"row {self.first + row + 1}" if self.lines is None else f"line {self.lines[row]}"

    def without(self, rows: int) -> "Table":
        """Table without the first rows below its names, including rows above the first sample."""
        left_out = max(rows - self.above, 0)
        return self.rows(slice(left_out, None))._replace(above=0, first=self.first + left_out)

    def headings(self) -> dict[int, str]:
        """Rows that follow a repetition of the names of the columns, and the place of the names."""
        if self.lines is None:
            return {}
        rows = np.searchsorted(self.lines, self.repeated).tolist()
        return {
            row: f"line {line}"
            for row, line in zip(rows, self.repeated, strict=True)
            if 0 < row < len(self.lines)
        }

    def rows(self, selected: slice | np.ndarray) -> "Table":
        """Table with some of its rows."""
        lines = None if self.lines is None else self.lines[selected]
        return self._replace(values=self.values[selected], lines=lines)

    def unit(self, name: str) -> str:
        """Unit that the file states for a column, below the names or in the name; "" if there is none."""
        return self.units.get(name) or stated_unit(name)[1]


@contextmanager
def refused_as(source: Path, form: str) -> Iterator[None]:
    """Context that turns any error of a library about a damaged file into `NotAFile`."""
    try:
        yield
    except (ExidynError, MemoryError):
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno == EFBIG:  # the unpacked file exceeds the limit
            raise too_large(source) from None
        raise NotAFile(f"{source} cannot be read as {form}: {error}") from error


def read_csv(source: Path) -> list[Table]:
    """Read a line of names, followed by one row of numbers per line; errors name the line.

    There may be lines before the names and a row of units below them, and numbers, dates and words for
    missing numbers in any usual form. The text is never in memory at once: for a
    compressed file it may be a hundred times as large as its numbers.
    """
    with refused_as(source, "a table"):
        require_gzip(source)
        return [_read_csv(source)]


def _read_csv(source: Path) -> Table:
    first = [text for _, text in islice(lines_of(source), PREAMBLE)]
    if not "".join(first).strip():
        raise NotAFile(f"{source} is empty")
    layout = layout_of(first)
    names = _distinct(layout.names)
    repeated: set[int] = set()
    above = [line.strip() for line in first[: layout.begin - 1] if line.strip()]
    heading = first[layout.header - 1].strip() if layout.header else ""
    rows = partial(_rows, source, layout, above, heading, repeated)
    units = {name: unit for name, unit in zip(names, layout.units, strict=False) if is_unit(unit)}
    table = _plain_numbers(rows, names, layout) or _any_cells(source, rows, names, layout)
    if table.lines is None or not len(table.lines):
        raise NotAFile(f"{source} has no samples")
    # Spreadsheets add columns that have neither a name nor numbers.
    empty = ~np.isfinite(table.values).any(axis=0)
    blank = [re.fullmatch(r"(\.\d+)?", name) is not None for name in table.names]
    used = np.flatnonzero(~(empty & np.array(blank)))
    return table._replace(
        names=[table.names[k] for k in used],
        values=table.values[:, used],
        units={**units, **table.units},
        above=layout.above,
        repeated=tuple(sorted(repeated)),
    )


def _distinct(names: list[str]) -> list[str]:
    """Names in which repetitions end in .1, .2 and so on, as in pandas."""
    count: dict[str, int] = {}
    result = []
    for name in names:
        count[name] = count.get(name, -1) + 1
        result.append(f"{name}.{count[name]}" if count[name] else name)
    return result


def _plain_numbers(rows: Rows, names: list[str], layout: Layout) -> Table | None:
    """Table of plain numbers, read by numpy; None if some cell is not a plain number."""
    numbered = array("q")
    decimal_comma = layout.separator != ","

    def plain() -> Iterator[str]:
        marks = set()
        for line, row in rows():
            numbered.append(line)
            if decimal_comma:
                marks |= {mark for mark in ".," if mark in row}
                if len(marks) > 1:
                    raise ValueError("both decimal marks")
            yield row.replace(",", ".") if decimal_comma else row

    try:
        with catch_warnings():
            simplefilter("ignore")  # numpy warns about an empty table, which the caller refuses
            values = np.loadtxt(plain(), delimiter=layout.separator, comments=None, ndmin=2)
    except NotAFile:
        raise
    except ValueError:
        return None
    if values.shape != (len(numbered), len(names)):
        return None
    return Table(names, np.where(np.isfinite(values), values, np.nan), np.array(numbered))


def _any_cells(source: Path, rows: Rows, names: list[str], layout: Layout) -> Table:
    """Table read cell by cell: missing numbers and text are NaN; the first text of each column is noted."""
    decimal = decimal_mark(cell for _, row in rows() for cell in cells_of(row, layout.separator))
    cells, numbered = array("d"), array("q")
    text: dict[str, str] = {}
    labels: dict[str, dict[str, int]] = {name: {} for name in names if names_joints(name)}
    dates, numbers = set(), set()
    for line, row in rows():
        numbered.append(line)
        for name, cell in zip(names, _row(source, line, row, layout, len(names)), strict=True):
            value = np.nan
            if not is_missing(cell):
                try:
                    value = number(cell, decimal)
                    numbers.add(name)
                except ValueError:
                    seconds = seconds_of(cell)
                    dates |= {name} if seconds is not None else set()
                    value = np.nan if seconds is None else seconds
                if np.isnan(value) and name in labels and name not in numbers:
                    value = labels[name].setdefault(cell, len(labels[name]) + 1)
                elif np.isnan(value) or {name} <= dates & numbers:
                    where = f"{source} line {line}: '{cell}' in column '{name}' is not a number"
                    text.setdefault(name, where)
            cells.append(value)
    values = np.array(cells).reshape(-1, len(names))
    for place, name in enumerate(names):
        if name in dates:
            values[:, place] = onward(values[:, place])
    joints = {name: list(known) for name, known in labels.items() if known}
    return Table(
        names, values, np.array(numbered), text, joints, units=dict.fromkeys(dates - set(text), DATE)
    )


def _row(source: Path, line: int, row: str, layout: Layout, width: int) -> list[str]:
    """Cells of a row, without empty cells behind the last name."""
    cells = without_empty_end(cells_of(row, layout.separator), width)
    if len(cells) != width:
        comma = layout.separator == "," and len(cells) > width
        hint = "; numbers with a decimal comma need semicolons between the columns" if comma else ""
        names = f"names in line {layout.header}" if layout.header else f"cells in line {layout.begin}"
        raise WrongShape(f"{source} line {line}: {len(cells)} cells for {width} {names}{hint}")
    return cells


def lines_of(source: Path) -> Iterator[tuple[int, str]]:
    """Number and text of each line."""
    with opened(source, "rt", encoding=_encoding(source)) as file:
        line = 0
        while row := file.readline(LONGEST_LINE):
            line += 1
            if len(row) == LONGEST_LINE:
                raise NotAFile(
                    f"{source} line {line}: more than {LONGEST_LINE - 1} characters: it is not a table"
                )
            yield line, row


def _encoding(source: Path) -> str:
    """Encoding of a text, from its first bytes: UTF-16 (from spreadsheets), else UTF-8 or Latin-1."""
    with opened(source, "rb") as file:
        begin: bytes = file.read(4096)
    if begin[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    try:
        begin[: begin.rfind(b"\n") + 1].decode("utf-8-sig")
    except UnicodeDecodeError:
        return "cp1252" if not re.search(rb"[\x00-\x08\x0e-\x1f]", begin) else "utf-8-sig"
    return "utf-8-sig"


def _rows(
    source: Path, layout: Layout, above: Collection[str], heading: str, repeated: set[int]
) -> Iterator[tuple[int, str]]:
    """Number and text of each line with a sample, without trailing comments.

    Repetitions of lines above the samples are skipped; lines that repeat the names are added to `repeated`.
    """
    most = largest_size(source) // (8 * len(layout.names))
    count, separator = 0, layout.separator
    for line, row in lines_of(source):
        if line < layout.begin or not row.strip():
            continue
        if row.strip() in above:
            repeated.update({line} if row.strip() == heading else ())
            continue
        if COMMENT in row:
            row = _COMMENTED.sub("", row)
            if not row.strip():
                continue
        if separator and row.count(separator) >= len(layout.names) and '"' not in row:
            row = row.rstrip(" \r\n").removesuffix(separator)
        count += 1
        if count > most:
            raise too_large(source)
        yield line, row
