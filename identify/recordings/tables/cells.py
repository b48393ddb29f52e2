"""Text files of columns: the layout of their lines, and numbers, dates and times of day in their cells."""

import csv
import re
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from typing import NamedTuple

import numpy as np

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


MISSING = frozenset(
    "nan na n/a #n/a #na #nv null none nil - -- --- ? inf -inf +inf infinity -infinity #num! #wert! #value! "
    "#div/0! #ref! #name? 1.#qnan -1.#ind 1.#inf nan(ind) -nan(ind) -nan undefined missing".split()
)
"""Words for a missing number, in lower case; those with # are from spreadsheets."""
GROUPED = {mark: re.compile(rf"[+-]?\d{{1,3}}(?:[{mark}]\d{{3}})+") for mark in ".,"}
"""Mark -> pattern of a number whose thousands it separates, or with three digits behind the mark."""
DAY = 86400.0
_TIME = r"(?P<h>\d{1,2}):(?P<min>\d\d)(?::(?P<s>\d\d)(?:[.,](?P<f>\d+))?)?(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?"
_ZONE = r"\s*(?:Z|UTC|GMT|(?P<sign>[+-])(?P<zh>\d\d):?(?P<zm>\d\d)?)?"
_YEAR_FIRST, _YEAR_LAST = (
    re.compile(rf"{date}[T\s,]+{_TIME}{_ZONE}")
    for date in (
        r"(?P<y>\d{4})([-/.]?)(?P<m>\d\d?)\2(?P<d>\d\d?)",
        r"(?P<d>\d\d?)([./-])(?P<m>\d\d?)\2(?P<y>\d{4})",
    )
)
_OF_DAY = re.compile(_TIME)
_OF_HOUR = re.compile(r"(?P<min>\d{1,2}):(?P<s>\d\d)[.,](?P<f>\d+)")


def is_missing(cell: str) -> bool:
    """Whether a cell stands for a missing number."""
    return not cell or cell.lower() in MISSING


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with any decimal mark; words for a missing number do not count."""
    for mark in ",.":
        try:
            return bool(np.isfinite(number(cell, mark)))
        except ValueError:
            continue
    return False


def decimal_mark(cells: Iterable[str]) -> str:
    """Decimal mark of numbers: "." or ","; "" if both occur and neither separates thousands."""
    dots, commas = [], []
    for cell in cells:
        if not re.fullmatch(r"[\s+-]*[\d.,\s']+(?:[eE][+-]?\d+)?", cell):
            continue
        if "." in cell and "," in cell:
            return max(".,", key=cell.rfind)
        if cell.count(".") > 1 or cell.count(",") > 1:
            return "," if "." in cell else "."
        if "." in cell:
            dots.append(cell)
        elif "," in cell:
            commas.append(cell)
    if not (dots and commas):
        return "," if commas else "."
    grouped = {
        mark: all(GROUPED[mark].fullmatch(cell) for cell in cells)
        for mark, cells in ((".", dots), (",", commas))
    }
    if grouped["."] == grouped[","]:
        return ""
    return "," if grouped["."] else "."


def number(cell: str, decimal: str) -> float:
    """Number of a cell that is not missing; raises ValueError if it is not a number."""
    value = float(_plain(cell, decimal))
    return value if np.isfinite(value) else np.nan


def _plain(cell: str, decimal: str) -> str:
    """Text of a number in the notation of Python, without marks between thousands."""
    if "_" in cell:
        raise ValueError(cell)
    if not decimal:
        return cell.replace(",", ".")
    thousands = "." if decimal == "," else ","
    if thousands in cell and not re.fullmatch(
        rf"[+-]?\d{{1,3}}(?:[{thousands}]\d{{3}})+(?:[{decimal}]\d*)?", cell
    ):
        raise ValueError(cell)
    plain = cell.replace(thousands, "").replace("'", "").replace("\u00a0", "").replace("\u202f", "")
    return plain.replace(decimal, ".").replace("\u2212", "-")


def seconds_of(cell: str) -> float | None:
    """Seconds since 1970 of a date with a time, or since midnight or the full hour of a time; else None.

    A date without a time zone counts as UTC, since runs only need differences.
    """
    if match := _YEAR_FIRST.fullmatch(cell) or _YEAR_LAST.fullmatch(cell):
        try:
            return _since_1970(match)
        except (ValueError, OverflowError):  # no such day
            return None
    if match := _OF_DAY.fullmatch(cell):
        return _of_day(match)
    if match := _OF_HOUR.fullmatch(cell):
        return 60.0 * int(match["min"]) + int(match["s"]) + float(f"0.{match['f']}")
    return None


def _since_1970(match: "re.Match[str]") -> float:
    day, month = int(match["d"]), int(match["m"])
    if match.re is _YEAR_LAST and month > 12:
        day, month = month, day
    midnight = datetime(int(match["y"]), month, day, tzinfo=UTC)
    zone = timedelta(hours=int(match["zh"] or 0), minutes=int(match["zm"] or 0))
    return (midnight - zone * (-1 if match["sign"] == "-" else 1)).timestamp() + _of_day(match)


def _of_day(match: "re.Match[str]") -> float:
    hour, half = int(match["h"]), (match["half"] or "").lower()
    if half:
        hour = hour % 12 + (12 if half == "p" else 0)
    return 3600.0 * hour + 60.0 * int(match["min"]) + int(match["s"] or 0) + float(f"0.{match['f'] or 0}")


def onward(times: np.ndarray) -> np.ndarray:
    """Times of day, or within the hour, made continuous where they restart at zero, shape (t,) [s]."""
    known = np.flatnonzero(np.isfinite(times))
    if not len(known) or times[known].max() >= DAY:
        return times
    period = DAY if times[known].max() >= 3600.0 else 3600.0
    continuous = np.array(times)
    steps = np.diff(times[known])
    continuous[known[1:]] += period * np.cumsum(steps < -0.5 * period)
    return continuous
