"""Parquet files, through the package pyarrow (extra `exidyn[parquet]`)."""

from pathlib import Path
from typing import Any

import numpy as np

from ...notebook import optional
from .damage import refused_as
from .tables.table import Table, table_of


def read_parquet(source: Path) -> list[Table]:
    """Read columns of numbers, times, and lists of numbers of one length, which become `name1`, `name2`, ….

    Raises:
        NotAFile: It is no such file, or holds no columns of numbers.
        MissingPackage: pyarrow is not installed.
    """
    return [table_of(source, parquet_columns(source))]


def parquet_columns(source: Path) -> dict[str, np.ndarray]:
    """Columns of numbers by name, shape (t,), or (t, c) of lists.

    Raises:
        NotAFile: It is no such file.
        MissingPackage: pyarrow is not installed.
    """
    types = optional("pyarrow", "a Parquet file", "parquet").types
    parquet = optional("pyarrow.parquet", "a Parquet file", "parquet")
    with refused_as(source, "Parquet"), parquet.ParquetFile(source) as file:
        names = [one.name for one in file.schema_arrow if _numeric(types, one.type)]
        read = file.read(columns=names)
        return {name: _array(read[name].to_numpy()) for name in names}


def _numeric(types: Any, kind: Any) -> bool:
    if types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        return _numeric(types, kind.value_type)
    return (
        types.is_integer(kind)
        or types.is_floating(kind)
        or types.is_boolean(kind)
        or types.is_timestamp(kind)
    )


def _array(column: np.ndarray) -> np.ndarray:
    """Lists of one length as a matrix."""
    lists = column.dtype == object and len({np.shape(one) for one in column}) == 1
    return np.stack(column.tolist()) if lists else column
