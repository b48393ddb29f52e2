"""Tables in text: a line of names, then a row of numbers a line; what cannot be read is named by its line."""

import gzip
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import NotAFile, WrongShape

COMMENT = "#"


class Table(NamedTuple):
    """What a file holds.

    Attributes:
        names: Of the columns, c of them.
        values: Shape (t, c); NaN where a cell is empty.
        lines: Line of the file in which each row stands, the first being 1, shape (t,).
    """

    names: list[str]
    values: np.ndarray
    lines: np.ndarray


def read_table(source: Path) -> Table:
    """Read a table with commas, semicolons or tabs; with the latter two, numbers may have a decimal comma.

    Raises:
        NotAFile: The file is missing, empty, cut off, or no table.
        WrongShape: A cell that is no number, or a row of another length than the line of names.
    """
    opener = gzip.open if source.name.endswith(".gz") else open
    try:
        with opener(source, "rt", encoding="utf-8-sig") as file:
            first, rows = file.readline(), list(file)
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise NotAFile(f"{source} cannot be read as a table: {error}") from error
    if not rows:
        raise NotAFile(f"{source} has no samples" if first else f"{source} is empty")
    separator = max(",;\t", key=first.count)
    names = [column.strip().strip('"') for column in first.split(separator)]
    if separator != ",":
        rows = [row.replace(",", ".") for row in rows]
    numbered = [(line, row) for line, row in enumerate(rows, 2) if row.partition(COMMENT)[0].strip()]
    if not numbered:
        raise NotAFile(f"{source} has no samples")
    values = _at_once(rows, separator)
    if values is None or values.shape != (len(numbered), len(names)):
        values = np.array([_row(source, line, row, separator, names) for line, row in numbered])
    return Table(names, values, np.array([line for line, _ in numbered]))


def _at_once(rows: list[str], separator: str) -> np.ndarray | None:
    """All rows, shape (t, c); None where one of them needs a closer look."""
    try:
        return np.loadtxt(rows, delimiter=separator, comments=COMMENT, ndmin=2)
    except ValueError:
        return None


def _row(source: Path, line: int, row: str, separator: str, names: list[str]) -> list[float]:
    """Numbers of one line; an empty cell is NaN."""
    cells = [cell.strip().strip('"') for cell in row.partition(COMMENT)[0].rstrip("\r\n").split(separator)]
    if len(cells) != len(names):
        comma = separator == "," and len(cells) > len(names)
        hint = "; numbers with a decimal comma need semicolons between the columns" if comma else ""
        raise WrongShape(f"{source} line {line}: {len(cells)} cells for {len(names)} names in line 1{hint}")
    return [_number(source, line, cell, name) for cell, name in zip(cells, names, strict=True)]


def _number(source: Path, line: int, cell: str, name: str) -> float:
    try:
        return float(cell) if cell else np.nan
    except ValueError as error:
        raise WrongShape(f"{source} line {line}: '{cell}' in column '{name}' is no number") from error
