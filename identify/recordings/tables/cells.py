"""Numbers in cells of text: decimal marks, words for missing numbers, dates and times of day."""

import re
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta

import numpy as np

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
_DATES = tuple(
    re.compile(rf"{date}[T\s,]+{_TIME}{_ZONE}")
    for date in (
        r"(?P<y>\d{4})([-/.]?)(?P<m>\d\d?)\2(?P<d>\d\d?)",
        r"(?P<a>\d\d?)([./-])(?P<b>\d\d?)\2(?P<y>\d{4})",
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
    for pattern in _DATES:
        if match := pattern.fullmatch(cell):
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
    parts = match.groupdict()
    if "y" in parts and "m" in parts:
        month, day = int(parts["m"]), int(parts["d"])
    else:
        day, month = int(parts["a"]), int(parts["b"])
        if month > 12:
            day, month = month, day
    midnight = datetime(int(parts["y"]), month, day, tzinfo=UTC)
    zone = timedelta()
    if parts["sign"]:
        zone = timedelta(hours=int(parts["zh"]), minutes=int(parts["zm"] or 0)) * (
            -1 if parts["sign"] == "-" else 1
        )
    return (midnight - zone).timestamp() + _of_day(match)


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
