"""Result files: one mechanism writes frozen dataclasses as JSON and reads them back.

Arrays are lists, and numbers that are not finite or larger than `LARGEST_FLOAT` are null; "nan", as fit.json
has it, is read too. Python counts joints from 0 and people count them from 1, so the fields `joint` and
`joints` are one larger in a file. A field with the metadata `NOT_IN_FILE` stays in memory.
"""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from datetime import datetime
from typing import Any, TypeVar

import numpy as np

from .errors import ExidynError, NotAFile
from .schema import LARGEST_FLOAT, Real, checked

NOT_IN_FILE = {"in_file": False}
"""Metadata of a field that is not written to the file."""
T = TypeVar("T")


def to_table(value: Any) -> Any:
    """Convert a result to the tables, lists, text and numbers of JSON.

    Example:
        >>> to_table(Quantity(2.0, float("nan"), "N m"))
        {'value': 2.0, 'std': None, 'unit': 'N m'}
    """
    if is_dataclass(value):
        written = (field.name for field in fields(value) if field.metadata.get("in_file", True))
        return {name: _joints(name, to_table(getattr(value, name)), 1) for name in written}
    if isinstance(value, Mapping):
        return {key: to_table(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, tuple | list):
        return [to_table(entry) for entry in value]
    if isinstance(value, datetime):
        return value.isoformat()
    return None if isinstance(value, float) and not abs(value) <= LARGEST_FLOAT else value


def from_table(table: object, kind: type[T], where: str, error: type[ExidynError] = NotAFile) -> T:
    """Convert a table to a result of type `kind`; `where` names the file in messages.

    Raises:
        ExidynError: A field is wrong; the message names it, what is expected, and its value.
    """
    return checked(_from_0(table), kind, where, error, read=number_or_array, written=table)


def _from_0(table: Any) -> Any:
    """The table with joints counted from 0."""
    if isinstance(table, Mapping):
        return {key: _joints(key, _from_0(entry), -1) for key, entry in table.items()}
    return [_from_0(entry) for entry in table] if isinstance(table, list) else table


def _joints(name: str, value: Any, step: int) -> Any:
    """The value of a field, shifted by `step` if it holds joint numbers."""
    if name == "joint" and type(value) is int:
        return value + step
    if name == "joints" and isinstance(value, list):
        return [entry + step if type(entry) is int else entry for entry in value]
    return value


def number_or_array(kind: type, value: object) -> Any:
    """Convert the value in a file to a `Real` or an array."""
    if kind is Real:
        return _real(value)
    if kind is not np.ndarray:
        raise NotImplementedError(kind)
    if not isinstance(value, list | tuple):
        raise ValueError(f"expected a list of numbers, got {type(value).__name__}")
    return np.array(_numbers(value), float)


def _numbers(value: Any, where: str = "") -> Any:
    """Numbers of nested lists with equal lengths."""
    if not isinstance(value, list | tuple):
        return _real(value, where)
    rows = [_numbers(entry, f"{where}[{place}]") for place, entry in enumerate(value)]
    widths = {len(row) if isinstance(row, list) else -1 for row in rows}
    if len(widths) > 1:
        raise ValueError(f"expected rows of one length{where and f' at {where}'}")
    return rows


def _real(value: object, where: str = "") -> float:
    if value in (None, "nan"):
        return Real("nan")
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= LARGEST_FLOAT:
        raise ValueError(f"expected a number or null; found {value!r:.60}{where and f' at {where}'}")
    return Real(value)
