"""Table: named columns of numbers, of a file of text or from arrays."""

from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ....errors import NotAFile

WIDEST = 200
"""Columns of a matrix, at most: one with more rows and columns is a picture."""


class Table(NamedTuple):
    """What a file holds of one run.

    Attributes:
        names: Of the columns, c of them.
        values: Shape (t, c); NaN where a cell is empty or holds text.
        lines: Line of the file in which each row stands, the first being 1, shape (t,); None without lines.
        text: Name of a column that holds text -> the first of it, and where.
        run: Name of the run, where a file holds several.
        joints: Names of the joints, where the file gives them to columns that are numbered.
    """

    names: list[str]
    values: np.ndarray
    lines: np.ndarray | None = None
    text: Mapping[str, str] = {}
    run: str = ""
    joints: tuple[str, ...] = ()

    def place(self, row: int) -> str:
        """Where a row stands in its file."""
        return f"row {row + 1}" if self.lines is None else f"line {self.lines[row]}"

    def without(self, rows: int) -> "Table":
        """The table without its first rows."""
        return self._replace(
            values=self.values[rows:], lines=None if self.lines is None else self.lines[rows:]
        )


def table_of(source: Path, named: Mapping[str, Any], between: str = ".", **known: Any) -> Table:
    """Arrays as columns: a matrix `q` becomes `q1`, `q2`, and what lies in a group has its name before it.

    Samples are counted along the axis whose length most of the numbers have; what has no such axis, such as
    parameters beside the run, is left out.

    Args:
        source: What errors call the file.
        named: Name -> array, or mapping or structure of arrays.
        between: Stands between the names of a group and of what is in it.
        known: Further attributes of the table.

    Raises:
        NotAFile: There is no array of numbers.
    """
    arrays = dict(_arrays("", named, between))
    numbers: Counter[int] = Counter()
    for array in arrays.values():
        numbers[max(array.shape)] += array.size
    if not numbers:
        raise NotAFile(f"{source} holds no arrays of numbers")
    [(length, _)] = numbers.most_common(1)
    columns: dict[str, np.ndarray] = {}
    for name, array in arrays.items():
        if array.ndim == 1 and len(array) == length:
            columns[name] = array
        elif length in array.shape and array.ndim == 2:
            upright = array if len(array) == length else array.T
            columns |= {f"{name}{k + 1}": column for k, column in enumerate(upright.T)}
    return Table(list(columns), np.column_stack(list(columns.values())), **known)


def _arrays(name: str, value: Any, between: str) -> Iterator[tuple[str, np.ndarray]]:
    """All arrays of numbers with one or two axes longer than one, as floats, and their names."""
    if isinstance(value, Mapping):
        for key, one in value.items():
            yield from _arrays(f"{name}{between}{key}" if name else str(key), one, between)
        return
    lengths = [count for count in getattr(value, "shape", ()) if count > 1]
    if len(lengths) > 2 or len(lengths) == 2 and min(lengths) > WIDEST:
        return  # pictures; they are not even read
    array = np.asarray(value)
    if array.dtype.names:
        yield from _arrays(name, {field: array[field] for field in array.dtype.names}, between)
    elif array.dtype == object:
        for place, one in enumerate(array.flat):
            if isinstance(one, np.ndarray | np.void):
                yield from _arrays(name if array.size == 1 else f"{name}{place + 1}", one, between)
    elif array.dtype.kind in "mM" and array.size > 1:
        yield name, np.squeeze(array.astype(f"{array.dtype.kind}8[ns]").astype(float)) * 1e-9
    elif array.dtype.kind in "biuf" and array.size > 1:
        yield name, np.squeeze(array.astype(float))
