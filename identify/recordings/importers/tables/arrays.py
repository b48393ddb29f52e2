"""Named arrays as a table: a matrix becomes one column for each of its columns."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import NotAFile
from ...decompression_limits import require_size
from .table import Table

WIDEST = 200
"""Maximum number of columns of a matrix: with more rows and columns it is a picture."""


def table_of(source: Path, named: Mapping[str, Any], between: str = ".", **known: Any) -> Table:
    """Table of arrays: a matrix `q` becomes `q1`, `q2`; names in a group are preceded by that of the group.

    The number of samples is the axis length with the most numbers. Arrays without such an axis, such as
    parameters beside the run, are left out.

    Args:
        source: Path of the file.
        named: Arrays, or mappings or structures of arrays, by name.
        between: Separator of the names of a group and its members.
        known: Further attributes of the table.

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
    """Limit on the content of a file, counted as numbers of 8 bytes."""

    def __init__(self, source: Path) -> None:
        self._source, self._size = source, 0

    def add(self, count: int) -> None:
        """Count the numbers of an array before they are read; raise NotAFile if there are too many."""
        self._size += 8 * count
        require_size(self._source, self._size)


def _arrays(name: str, value: Any, between: str, limit: _Limit) -> Iterator[tuple[str, np.ndarray]]:
    """All arrays of numbers with one or two axes longer than one, as floats, and their names."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _arrays(f"{name}{between}{key}" if name else str(key), item, between, limit)
        return
    lengths = [count for count in getattr(value, "shape", ()) if count > 1]
    if len(lengths) > 2 or len(lengths) == 2 and min(lengths) > WIDEST:
        return  # pictures; they are not even read
    limit.add(math.prod(lengths))
    values = np.asarray(value)
    if values.dtype.names:
        yield from _arrays(name, {field: values[field] for field in values.dtype.names}, between, limit)
    elif values.dtype == object:
        for place, item in enumerate(values.flat):
            if isinstance(item, np.ndarray | np.void):
                yield from _arrays(name if values.size == 1 else f"{name}{place + 1}", item, between, limit)
    elif values.dtype.kind in "mM" and values.size > 1:
        yield name, np.squeeze(values.astype(f"{values.dtype.kind}8[ns]").astype(float)) * 1e-9
    elif values.dtype.kind in "biuf" and values.size > 1:
        yield name, np.squeeze(values.astype(float))
