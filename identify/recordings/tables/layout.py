"""Layout of a text file: the separator of columns, and the lines of names, units and samples."""

import csv
from collections.abc import Sequence
from typing import NamedTuple

from .cells import is_missing, is_number, seconds_of
from .name_index import is_unit_row

PREAMBLE = 200
"""Number of lines that are searched for the first sample."""
SEPARATORS = (";", "\t", ",", "|", None)
"""Possible separators of columns; None is any number of spaces."""
COMMENT = "#"
MARKS = "#% "
"""Characters before a line of names that is a comment to the program that wrote it."""


class Layout(NamedTuple):
    """Layout of a text file."""

    separator: str | None  # separator of columns; None for spaces
    names: list[str]  # names of the columns, "" for a column without a name; numbers if the file has no names
    units: list[str]  # units below the names, one per column; empty if the file has no such line
    header: int  # line of the names, from 1; 0 if the file has no names
    begin: int  # line of the first sample, from 1
    above: int  # number of lines between the names and the first sample that are not comments


def cells_of(line: str, separator: str | None) -> list[str]:
    """Cells of a line, without quotes and spaces around them."""
    if separator and '"' in line:
        cells = next(csv.reader([line.strip("\r\n")], delimiter=separator, skipinitialspace=True), [])
    else:
        cells = line.strip("\r\n").split(separator)
    return [cell.strip().strip('"').strip("'").strip() for cell in cells]


def without_empty_end(cells: list[str], least: int = 0) -> list[str]:
    """Cells without empty ones at the end; at least the first `least` are left."""
    count = len(cells)
    while count > least and not cells[count - 1]:
        count -= 1
    return cells[:count]


def layout_of(lines: Sequence[str]) -> Layout:
    """Layout of a file, from its first lines."""
    separator, begin = _first_sample(lines)
    if begin is None:
        header = next((k for k, line in enumerate(lines) if line.strip()), 0)
        commonest = max(SEPARATORS[:3], key=lambda mark: lines[header].count(mark or " "))
        separator = commonest if commonest in lines[header] else None
        return Layout(separator, _names(lines[header], separator), [], header + 1, header + 2, 0)
    width = len(without_empty_end(cells_of(lines[begin], separator), 1))
    heads = {k: _names(lines[k], separator) for k in range(begin) if lines[k].strip()}
    if not heads:
        return Layout(separator, [str(k + 1) for k in range(width)], [], 0, begin + 1, 0)
    header = _header(heads, lines, width)
    below = [k for k in heads if k > header]
    units = next(
        (heads[k] for k in below if is_unit_row(heads[k]) and len(heads[k]) <= len(heads[header])), []
    )
    names = without_empty_end(heads[header], width)
    units = (units + [""] * len(names))[: len(names)] if units else []
    above = sum(not lines[k].lstrip().startswith(COMMENT) for k in below)
    return Layout(separator, names, units, header + 1, begin + 1, above)


def _names(line: str, separator: str | None) -> list[str]:
    return cells_of(line.strip("\r\n").lstrip(MARKS), separator)


def _first_sample(lines: Sequence[str]) -> tuple[str | None, int | None]:
    """Separator, and index of the first line of samples; None if there are no samples."""
    places = {}
    for separator in SEPARATORS:
        place = next((k for k in range(len(lines)) if _is_sample(lines[k], separator, k == 0)), None)
        if place is not None:
            places[separator] = place
    if not places:
        return None, None
    first = min(places.values())
    return next((mark, place) for mark, place in places.items() if place == first)


def _is_sample(line: str, separator: str | None, first: bool) -> bool:
    """Whether a line has at least two cells, most of which are numbers; all of them in the first line."""
    if line.lstrip().startswith(COMMENT):
        return False
    cells = [cell for cell in cells_of(line, separator) if cell]
    if separator is None:
        cells = [cell for cell in cells if cell not in ",;|"]
    numbers = sum(is_number(cell) or seconds_of(cell) is not None for cell in cells)
    missing = sum(is_missing(cell) for cell in cells)
    if len(cells) < 2 or not numbers:
        return False
    return numbers + missing == len(cells) if first else 2 * (numbers + missing) >= len(cells)


def _header(heads: dict[int, list[str]], lines: Sequence[str], width: int) -> int:
    """Index of the line of names above the samples: as many names as a sample has cells, all different."""

    def rank(place: int) -> tuple[bool, ...]:
        names = without_empty_end(heads[place])
        distinct = len(set(names)) == len(names)
        comment = lines[place].lstrip().startswith(COMMENT)
        return (len(names) == width, not is_unit_row(names), distinct, len(names) > width // 2, not comment)

    return max(heads, key=lambda place: (*rank(place), -place))
