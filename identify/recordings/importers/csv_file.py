"""Tables in text: a line of names, then a row of numbers a line; what cannot be read is named by its line."""

import gzip
from pathlib import Path

import numpy as np

from ...errors import NotAFile, WrongShape
from .tables.table import Table

COMMENT = "#"


def read_csv(source: Path) -> list[Table]:
    """Read a table with commas, semicolons, tabs or spaces; without commas, numbers may have a decimal comma.

    Raises:
        NotAFile: The file is missing, empty, cut off, or no table.
        WrongShape: A row of another length than the line of names.
    """
    opener = gzip.open if source.name.endswith(".gz") else open
    try:
        with opener(source, "rt", encoding="utf-8-sig") as file:
            first, rows = file.readline(), list(file)
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise NotAFile(f"{source} cannot be read as a table: {error}") from error
    if not rows:
        raise NotAFile(f"{source} has no samples" if first else f"{source} is empty")
    commonest = max(",;\t", key=first.count)
    separator = commonest if commonest in first else None  # any spaces
    # A line of names may be a comment, as numpy, MATLAB and rostopic write it.
    names = [column.strip().strip('"') for column in first.strip().lstrip("#% ").split(separator)]
    begin = 2
    if all(_is_number(name) for name in names):  # columns without names are called by their numbers
        names, rows, begin = [str(place + 1) for place in range(len(names))], [first, *rows], 1
    if separator != ",":
        rows = [row.replace(",", ".") for row in rows]
    numbered = [(line, row) for line, row in enumerate(rows, begin) if row.partition(COMMENT)[0].strip()]
    if not numbered:
        raise NotAFile(f"{source} has no samples")
    text: dict[str, str] = {}
    values = _at_once(rows, separator)
    if values is None or values.shape != (len(numbered), len(names)):
        values = np.array([_row(source, line, row, separator, names, text) for line, row in numbered])
    return [Table(names, values, np.array([line for line, _ in numbered]), text)]


def _is_number(cell: str) -> bool:
    try:
        return np.isfinite(float(cell.replace(",", ".")))
    except ValueError:
        return False


def _at_once(rows: list[str], separator: str | None) -> np.ndarray | None:
    """All rows, shape (t, c); None where one of them needs a closer look."""
    try:
        return np.loadtxt(rows, delimiter=separator, comments=COMMENT, ndmin=2)
    except ValueError:
        return None


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
