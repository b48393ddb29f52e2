"""Table: named columns of numbers, of a file of text or from arrays."""

import gzip
import math
import zlib
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from errno import EFBIG
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from warnings import catch_warnings, simplefilter

import numpy as np

from ....errors import ExidynError, NotAFile, WrongShape
from ...decompression_limits import largest_size, require_gzip, require_size, too_large

WIDEST = 200
"""Columns of a matrix, at most: one with more rows and columns is a picture."""
COMMENT = "#"
LONGEST_LINE = 1_000_000
"""Characters of a line, at most: of ten thousand columns with a hundred characters each."""


class Table(NamedTuple):
    """What a file holds of one run.

    Attributes:
        names: Names of the columns, c of them.
        values: Shape (t, c); NaN where a cell is empty or holds text.
        lines: Line of the file in which each row stands, the first being 1, shape (t,); None without lines.
        text: Name of a column that holds text -> the first of it, and where.
        run: Name of the run, where a file holds several.
        joints: Names of the joints, where the file gives them to columns that are numbered.
        first: Rows of the file before the first.
        again: Lines at which the names of the columns stand again, where a recorder appends its runs.
    """

    names: list[str]
    values: np.ndarray
    lines: np.ndarray | None = None
    text: Mapping[str, str] = {}
    run: str = ""
    joints: tuple[str, ...] = ()
    first: int = 0
    again: tuple[int, ...] = ()

    def place(self, row: int) -> str:
        """Where a row stands in its file."""
        return f"row {self.first + row + 1}" if self.lines is None else f"line {self.lines[row]}"

    def without(self, rows: int) -> "Table":
        """The table without its first rows."""
        lines = None if self.lines is None else self.lines[rows:]
        return self._replace(values=self.values[rows:], lines=lines, first=self.first + rows)

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

    Between columns are commas, semicolons, tabs or spaces; without commas, numbers may have a decimal comma.
    The text is never held as a whole: of a compressed file it may be a hundred times as large as its numbers.

    Raises:
        NotAFile: The file is missing, empty, cut off, too large, or no table.
        WrongShape: A row of another length than the line of names.
    """
    try:
        if source.name.endswith(".gz"):
            require_gzip(source)
        return [_read_csv(source)]
    except (OSError, EOFError, UnicodeDecodeError, zlib.error) as error:
        raise NotAFile(f"{source} cannot be read as a table: {error}") from error


def _read_csv(source: Path) -> Table:
    first = next(_lines(source), (1, ""))[1]
    if not first:
        raise NotAFile(f"{source} is empty")
    commonest = max(",;\t", key=first.count)
    separator = commonest if commonest in first else None  # any spaces
    # A line of names may be a comment, as numpy, MATLAB and rostopic write it.
    names = [column.strip().strip('"') for column in first.strip().lstrip("#% ").split(separator)]
    if not names:
        raise NotAFile(f"{source} line 1 is empty; expected the names of the columns")
    named = not all(_is_number(name) for name in names)
    if not named:  # columns without names are called by their numbers
        names = [str(place + 1) for place in range(len(names))]
    again: set[int] = set()
    rows = partial(_rows, source, first if named else "", again, separator != ",", len(names))
    numbered = array("q")
    text: dict[str, str] = {}
    try:
        with catch_warnings():
            simplefilter("ignore")  # numpy's, where there is no row; the error below says it
            values = np.loadtxt(_counted(rows(), numbered), delimiter=separator, comments=COMMENT, ndmin=2)
    except NotAFile:
        raise
    except ValueError:  # one of the rows needs a closer look
        values = np.empty((0, 0))
    if values.shape != (len(numbered), len(names)):
        numbers, numbered = array("d"), array("q")
        for line, row in rows():
            numbers.extend(_row(source, line, row, separator, names, text))
            numbered.append(line)
        values = np.array(numbers).reshape(-1, len(names))
    if not numbered:
        raise NotAFile(f"{source} has no samples")
    return Table(names, values, np.array(numbered), text, again=tuple(sorted(again)))


def _lines(source: Path) -> Iterator[tuple[int, str]]:
    """Number and text of each line.

    Raises:
        NotAFile: A line is longer than any row of numbers.
    """
    opener = gzip.open if source.name.endswith(".gz") else open
    with opener(source, "rt", encoding="utf-8-sig") as file:
        line = 0
        while row := file.readline(LONGEST_LINE):
            line += 1
            if len(row) == LONGEST_LINE:
                raise NotAFile(
                    f"{source} line {line}: more than {LONGEST_LINE - 1} characters: it is no table"
                )
            yield line, row


def _rows(
    source: Path, heading: str, again: set[int], decimal_comma: bool, width: int
) -> Iterator[tuple[int, str]]:
    """Number and text of each line that holds a row; lines at which the heading stands again are noted.

    Raises:
        NotAFile: They have more numbers than the limit.
    """
    most = largest_size(source) // (8 * width)
    count = 0
    for line, row in _lines(source):
        if heading and row.strip("\ufeff \r\n") == heading.strip():
            again.update({line} - {1})
            continue
        if not row.partition(COMMENT)[0].strip():
            continue
        count += 1
        if count > most:
            raise too_large(source)
        yield line, row.replace(",", ".") if decimal_comma else row


def _counted(rows: Iterator[tuple[int, str]], numbered: "array[int]") -> Iterator[str]:
    """The rows; the number of each one's line is kept."""
    for line, row in rows:
        numbered.append(line)
        yield row


def _is_number(cell: str) -> bool:
    try:
        return np.isfinite(float(cell.replace(",", ".")))
    except ValueError:
        return False


def _row(
    source: Path, line: int, row: str, separator: str | None, names: list[str], text: dict[str, str]
) -> list[float]:
    """Numbers of one line; an empty cell is NaN, and so is one of text, which is noted by its column."""
    cells = [cell.strip().strip('"') for cell in row.partition(COMMENT)[0].rstrip("\r\n").split(separator)]
    if len(cells) != len(names):
        comma = separator == "," and len(cells) > len(names)
        hint = "; numbers with a decimal comma need semicolons between the columns" if comma else ""
        raise WrongShape(f"{source} line {line}: {len(cells)} cells for {len(names)} names in line 1{hint}")
    numbers = []
    for cell, name in zip(cells, names, strict=True):
        try:
            numbers.append(float(cell) if cell else np.nan)
        except ValueError:
            numbers.append(np.nan)
            text.setdefault(name, f"{source} line {line}: '{cell}' in column '{name}' is no number")
    return numbers


def table_of(source: Path, named: Mapping[str, Any], between: str = ".", **known: Any) -> Table:
    """Arrays as columns: a matrix `q` becomes `q1`, `q2`, and what lies in a group has its name before it.

    Samples are counted along the axis whose length most of the numbers have; what has no such axis, such as
    parameters beside the run, is left out.
    `named` has arrays, or mappings or structures of them; `known` are further attributes of the table.

    Raises:
        NotAFile: There is no array of numbers.
    """
    limit = _Limit(source)
    arrays = dict(_arrays("", named, between, limit))
    numbers: Counter[int] = Counter()
    for values in arrays.values():
        numbers[max(values.shape)] += values.size
    if not numbers:
        raise NotAFile(f"{source} holds no arrays of numbers")
    [(length, _)] = numbers.most_common(1)
    columns: dict[str, np.ndarray] = {}
    for name, values in arrays.items():
        if values.ndim == 1 and len(values) == length:
            columns[name] = values
        elif length in values.shape and values.ndim == 2:
            upright = values if len(values) == length else values.T
            columns |= {f"{name}{k + 1}": column for k, column in enumerate(upright.T)}
    return Table(list(columns), np.column_stack(list(columns.values())), **known)


class _Limit:
    """The limit of what a file may hold, as numbers of 8 bytes."""

    def __init__(self, source: Path) -> None:
        self._source, self._size = source, 0

    def add(self, count: int) -> None:
        """Count the numbers of an array before they are read; NotAFile where they are too many."""
        self._size += 8 * count
        require_size(self._source, self._size)


def _arrays(name: str, value: Any, between: str, limit: _Limit) -> Iterator[tuple[str, np.ndarray]]:
    """All arrays of numbers with one or two axes longer than one, as floats, and their names."""
    if isinstance(value, Mapping):
        for key, one in value.items():
            yield from _arrays(f"{name}{between}{key}" if name else str(key), one, between, limit)
        return
    lengths = [count for count in getattr(value, "shape", ()) if count > 1]
    if len(lengths) > 2 or len(lengths) == 2 and min(lengths) > WIDEST:
        return  # pictures; they are not even read
    limit.add(math.prod(lengths))
    values = np.asarray(value)
    if values.dtype.names:
        yield from _arrays(name, {field: values[field] for field in values.dtype.names}, between, limit)
    elif values.dtype == object:
        for place, one in enumerate(values.flat):
            if isinstance(one, np.ndarray | np.void):
                yield from _arrays(name if values.size == 1 else f"{name}{place + 1}", one, between, limit)
    elif values.dtype.kind in "mM" and values.size > 1:
        yield name, np.squeeze(values.astype(f"{values.dtype.kind}8[ns]").astype(float)) * 1e-9
    elif values.dtype.kind in "biuf" and values.size > 1:
        yield name, np.squeeze(values.astype(float))
