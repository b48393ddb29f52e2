"""Table: named columns of numbers, of a file of text or from arrays."""

import csv
import gzip
import re
import zlib
from array import array
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from errno import EFBIG
from functools import partial
from itertools import islice
from pathlib import Path
from typing import NamedTuple
from warnings import catch_warnings, simplefilter

import numpy as np

from ....errors import ExidynError, NotAFile, WrongShape
from ...decompression_limits import largest_size, require_gzip, too_large
from .cells import decimal_mark, is_missing, number, onward, seconds_of
from .layout import COMMENT, PREAMBLE, Layout, cells_of, layout_of
from .stated_units import is_unit, stated_unit

LONGEST_LINE = 1_000_000
"""Characters of a line, at most: of ten thousand columns with a hundred characters each."""
DATE = "date"
"""Unit of a column of dates or times of day, which are seconds in the table."""
_COMMENTED = re.compile(r"(?:^|\s)#(?!(?:N/A|NA|NV|NUM!|WERT!|VALUE!|DIV/0!|REF!|NAME\?)).*")
Rows = Callable[[], Iterator[tuple[int, str]]]


class Table(NamedTuple):
    """What a file holds of one run.

    Attributes:
        names: Names of the columns, c of them, all different.
        values: Shape (t, c); NaN where a cell is empty, a word for a missing number, or text.
        lines: Line of the file in which each row stands, the first being 1, shape (t,); None without lines.
        text: Name of a column that holds text -> the first of it, and where.
        run: Name of the run, where a file holds several.
        joints: Names of the joints, where the file gives them to columns that are numbered.
        units: Name of a column -> its unit, where a line below the names states it; or `DATE`.
        above: Number of rows between the names and the first sample, such as a row of units.
        first: Rows of the file before the first.
        again: Lines at which the names of the columns stand again, where a recorder appends its runs.
    """

    names: list[str]
    values: np.ndarray
    lines: np.ndarray | None = None
    text: Mapping[str, str] = {}
    run: str = ""
    joints: tuple[str, ...] = ()
    units: Mapping[str, str] = {}
    above: int = 0
    first: int = 0
    again: tuple[int, ...] = ()

    def place(self, row: int) -> str:
        """Where a row stands in its file."""
        return f"row {self.first + row + 1}" if self.lines is None else f"line {self.lines[row]}"

    def without(self, rows: int) -> "Table":
        """The table without the first rows below its names, those above the first sample included."""
        left_out = max(rows - self.above, 0)
        return self.rows(slice(left_out, None))._replace(above=0, first=self.first + left_out)

    def headings(self) -> dict[int, str]:
        """Rows above which the names of the columns stand again, and where these stand."""
        if self.lines is None:
            return {}
        rows = np.searchsorted(self.lines, self.again).tolist()
        return {
            row: f"line {line}"
            for row, line in zip(rows, self.again, strict=True)
            if 0 < row < len(self.lines)
        }

    def rows(self, kept: slice | np.ndarray) -> "Table":
        """The table with some of its rows."""
        lines = None if self.lines is None else self.lines[kept]
        return self._replace(values=self.values[kept], lines=lines)

    def unit(self, name: str) -> str:
        """Unit of a column that the file states, below the names or in the name; "" for none."""
        return self.units.get(name) or stated_unit(name)[1]


@contextmanager
def refused_as(source: Path, form: str) -> Iterator[None]:
    """Whatever a library raises of a damaged file, as `NotAFile`; they raise many kinds of errors."""
    try:
        yield
    except (ExidynError, MemoryError):
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno == EFBIG:  # what was unpacked on the disk
            raise too_large(source) from None
        raise NotAFile(f"{source} cannot be read as {form}: {error}") from error


def read_csv(source: Path) -> list[Table]:
    """Read a line of names, then a row of numbers a line; what cannot be read is named by its line.

    Lines before the names and a row of units below them may be there (`layout.py`), and numbers, dates and
    words for missing numbers in any usual form (`cells.py`). The text is never held as a whole: of a
    compressed file it may be a hundred times as large as its numbers.

    Raises:
        NotAFile: The file is missing, empty, cut off, too large, or no table.
        WrongShape: A row of another length than the line of names.
    """
    try:
        if source.name.endswith(".gz"):
            require_gzip(source)
        return [_read_csv(source)]
    except (OSError, EOFError, UnicodeError, zlib.error, csv.Error) as error:
        raise NotAFile(f"{source} cannot be read as a table: {error}") from error


def _read_csv(source: Path) -> Table:
    first = [text for _, text in islice(_lines(source), PREAMBLE)]
    if not "".join(first).strip():
        raise NotAFile(f"{source} is empty")
    layout = layout_of(first)
    names = _distinct(layout.names)
    again: set[int] = set()
    above = [line.strip() for line in first[: layout.begin - 1] if line.strip()]
    heading = first[layout.header - 1].strip() if layout.header else ""
    rows = partial(_rows, source, layout, above, heading, again)
    units = {name: unit for name, unit in zip(names, layout.units, strict=False) if is_unit(unit)}
    table = _plain_numbers(rows, names, layout) or _any_cells(source, rows, names, layout)
    if table.lines is None or not len(table.lines):
        raise NotAFile(f"{source} has no samples")
    table = table._replace(again=tuple(sorted(again)))
    return _without_blank(table._replace(units={**units, **table.units}, above=layout.above))


def _distinct(names: list[str]) -> list[str]:
    """Names of which the second of two that are alike ends in .1, as pandas reads them."""
    count: dict[str, int] = {}
    result = []
    for name in names:
        count[name] = count.get(name, -1) + 1
        result.append(f"{name}.{count[name]}" if count[name] else name)
    return result


def _without_blank(table: Table) -> Table:
    """The table without columns that have neither a name nor a number, as spreadsheets add them."""
    empty = ~np.isfinite(table.values).any(axis=0)
    blank = [re.fullmatch(r"(\.\d+)?", name) is not None for name in table.names]
    kept = np.flatnonzero(~(empty & np.array(blank)))
    return table._replace(names=[table.names[k] for k in kept], values=table.values[:, kept])


def _plain_numbers(rows: Rows, names: list[str], layout: Layout) -> Table | None:
    """A table of plain numbers, which numpy reads at once; None where a cell needs a closer look."""
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
            simplefilter("ignore")  # numpy's, where there is no row; the caller refuses that
            values = np.loadtxt(plain(), delimiter=layout.separator, comments=None, ndmin=2)
    except NotAFile:
        raise
    except ValueError:
        return None
    if values.shape != (len(numbered), len(names)):
        return None
    return Table(names, np.where(np.isfinite(values), values, np.nan), np.array(numbered))


def _any_cells(source: Path, rows: Rows, names: list[str], layout: Layout) -> Table:
    """A table cell by cell: a missing number is NaN, and so is text, which is noted by its column."""
    decimal = decimal_mark(cell for _, row in rows() for cell in cells_of(row, layout.separator))
    cells, numbered = array("d"), array("q")
    text: dict[str, str] = {}
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
                if np.isnan(value) or {name} <= dates & numbers:
                    where = f"{source} line {line}: '{cell}' in column '{name}' is no number"
                    text.setdefault(name, where)
            cells.append(value)
    values = np.array(cells).reshape(-1, len(names))
    for place, name in enumerate(names):
        if name in dates:
            values[:, place] = onward(values[:, place])
    return Table(names, values, np.array(numbered), text, units=dict.fromkeys(dates - set(text), DATE))


def _row(source: Path, line: int, row: str, layout: Layout, width: int) -> list[str]:
    """The cells of a row, without empty ones behind the last name.

    Raises:
        WrongShape: Not one cell for each name.
    """
    cells = cells_of(row, layout.separator)
    while len(cells) > width and not cells[-1]:
        cells.pop()
    if len(cells) != width:
        comma = layout.separator == "," and len(cells) > width
        hint = "; numbers with a decimal comma need semicolons between the columns" if comma else ""
        names = f"names in line {layout.header}" if layout.header else f"cells in line {layout.begin}"
        raise WrongShape(f"{source} line {line}: {len(cells)} cells for {width} {names}{hint}")
    return cells


def _lines(source: Path) -> Iterator[tuple[int, str]]:
    """Number and text of each line.

    Raises:
        NotAFile: A line is longer than any row of numbers.
    """
    opener = gzip.open if source.name.endswith(".gz") else open
    with opener(source, "rt", encoding=_encoding(source)) as file:
        line = 0
        while row := file.readline(LONGEST_LINE):
            line += 1
            if len(row) == LONGEST_LINE:
                raise NotAFile(
                    f"{source} line {line}: more than {LONGEST_LINE - 1} characters: it is no table"
                )
            yield line, row


def _encoding(source: Path) -> str:
    """Encoding of a text by its first bytes: UTF-16 as spreadsheets write it, else UTF-8 or Latin-1."""
    opener = gzip.open if source.name.endswith(".gz") else open
    with opener(source, "rb") as file:
        begin = file.read(4096)
    if begin[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    try:
        begin[: begin.rfind(b"\n") + 1].decode("utf-8-sig")
    except UnicodeDecodeError:
        return "cp1252" if not re.search(rb"[\x00-\x08\x0e-\x1f]", begin) else "utf-8-sig"
    return "utf-8-sig"


def _rows(
    source: Path, layout: Layout, above: Collection[str], heading: str, again: set[int]
) -> Iterator[tuple[int, str]]:
    """Number and text of each line that holds a sample, without a comment behind it.

    Lines that stand above the samples are skipped where a recorder repeats them; those of names are noted.

    Raises:
        NotAFile: They have more numbers than the limit.
    """
    most = largest_size(source) // (8 * len(layout.names))
    count, separator = 0, layout.separator
    for line, row in _lines(source):
        if line < layout.begin or not row.strip():
            continue
        if row.strip() in above:
            again.update({line} if row.strip() == heading else ())
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
