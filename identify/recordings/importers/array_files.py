"""Files with named arrays: MATLAB, HDF5, NumPy, Parquet, and LeRobot's folders of Parquet files.

Readers raise `NotAFile` for a damaged file, and `MissingPackage` if their library is not installed.
"""

import json
import math
import struct
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any
from zipfile import ZipFile

import numpy as np
from numpy.lib import format as npy

from ...errors import NotAFile
from ...notebook import optional
from ..reading_limits import PIECE, largest_size, require_size, require_zip, too_large
from ..tables.table import Table, refused_as

HDF5 = b"\x89HDF"
"""First bytes of an HDF5 file; in a MATLAB file they follow 512 other bytes."""
MATLAB_HEAD, COMPRESSED = 128, 15
"""Bytes before the first element of a MATLAB file of version 5, and the type of a compressed element."""
STATE = "observation.state"
"""LeRobot's column of joint positions."""


def read_matlab(source: Path) -> list[Table]:
    """Read the variables of a MATLAB file: scipy reads version 5, and h5py version 7.3, which is HDF5.

    The name of a field of a structure contains both names, such as `data.q`.
    """
    from scipy.io import loadmat

    with open(source, "rb") as file:
        begin = file.read(512 + len(HDF5))
    if HDF5 in (begin[: len(HDF5)], begin[512:]):
        return read_hdf5(source, between=".")
    with refused_as(source, "a MATLAB file"):
        _require_matlab(source)
        return [table_of(source, loadmat(source))]


def _require_matlab(source: Path) -> None:
    """Refuse variables that are too large once decompressed; each is an element, compressed or not."""
    limit, size = largest_size(source), 0
    with open(source, "rb") as file:
        order = "<" if file.read(MATLAB_HEAD)[-2:] == b"IM" else ">"
        while len(tag := file.read(8)) == 8:
            kind, length = struct.unpack(f"{order}II", tag)
            content = file.read(length)
            unpacker = zlib.decompressobj()
            while kind == COMPRESSED and content and not unpacker.eof:
                size += len(unpacker.decompress(content, PIECE))
                content = unpacker.unconsumed_tail
                if size > limit:
                    raise too_large(source)


def read_hdf5(source: Path, between: str = "/") -> list[Table]:
    """Read data sets of an HDF5 file; the name of a data set in a group is its path, such as `arm/q`."""
    h5py = optional("h5py", "an HDF5 file", "hdf5")
    arrays: dict[str, Any] = {}

    def collect(name: str, node: Any) -> None:
        if isinstance(node, h5py.Dataset) and not name.startswith("#"):  # #refs# is MATLAB's
            arrays[name.replace("/", between)] = node

    with refused_as(source, "HDF5"), h5py.File(source) as file:
        file.visititems(collect)
        return [table_of(source, arrays, between)]


def read_npz(source: Path) -> list[Table]:
    """Read arrays that `numpy.savez` or `savez_compressed` wrote; samples that are objects are refused."""
    with refused_as(source, "a NumPy file"):
        require_zip(source)
        with ZipFile(source) as archive:
            arrays: dict[str, np.ndarray] = {}
            for name in archive.namelist():
                with archive.open(name) as file:
                    arrays |= _numpy_array(source, name.removesuffix(".npy"), file)
        return [table_of(source, arrays)]


def read_npy(source: Path) -> list[Table]:
    """Read an array that `numpy.save` wrote, with or without names of its columns."""
    with refused_as(source, "a NumPy file"), open(source, "rb") as file:
        return [table_of(source, _numpy_array(source, "", file))]


def _numpy_array(source: Path, name: str, file: IO[bytes]) -> dict[str, np.ndarray]:
    """An array of numbers by its name; empty for a single object, such as a dictionary of settings."""
    version = npy.read_magic(file)
    head = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = head(file)
    if dtype.hasobject and math.prod(shape) == 1:
        return {}
    if dtype.hasobject:
        raise NotAFile(
            f"{source}: {name or 'the array'} holds Python objects, which are not loaded. Save numbers: "
            f"np.array({name or 'x'}, float)"
        )
    require_size(source, math.prod(shape) * dtype.itemsize)
    file.seek(0)
    return {name: npy.read_array(file, allow_pickle=False)}


def read_parquet(source: Path) -> list[Table]:
    """Read columns of numbers, times, and lists of equal length, which become `name1`, `name2`, …."""
    return [table_of(source, _parquet_columns(source))]


def read_lerobot(source: Path) -> list[Table]:
    """Read a LeRobot folder with meta/info.json, version 2 or 3: one run per episode, at its frame rate."""
    rate, joints = _lerobot_info(source / "meta" / "info.json")
    tables = []
    for path in sorted(source.glob("data/**/*.parquet")):
        columns = _parquet_columns(path)
        if not {"episode_index", "frame_index", STATE} <= set(columns):
            raise NotAFile(f"{path} lacks episode_index, frame_index or {STATE}; it has {', '.join(columns)}")
        # The time stamps in the file are the same, in single precision.
        columns["timestamp"] = columns["frame_index"] / rate
        for episode in np.unique(columns["episode_index"]).astype(int).tolist():
            rows = columns["episode_index"] == episode
            named = {name: column[rows] for name, column in columns.items()}
            tables.append(table_of(path, named, run=f"episode_{episode:06d}", joints=joints))
    if not tables:
        raise NotAFile(f"{source} has no episodes in data/*.parquet")
    return tables


def _parquet_columns(source: Path) -> dict[str, np.ndarray]:
    """Columns of numbers by name, shape (t,), or (t, c) of lists of one length."""
    types = optional("pyarrow", "a Parquet file", "parquet").types
    parquet = optional("pyarrow.parquet", "a Parquet file", "parquet")
    columns = {}
    with refused_as(source, "Parquet"), parquet.ParquetFile(source) as file:
        names = [field.name for field in file.schema_arrow if _numeric(types, field.type)]
        require_size(source, 8 * file.metadata.num_rows * len(names))
        table = file.read(columns=names)
        for name in names:
            column = table[name].to_numpy()
            lists = column.dtype == object and len({np.shape(cell) for cell in column}) == 1
            columns[name] = np.stack(column.tolist()) if lists else column
    return columns


def _numeric(types: Any, kind: Any) -> bool:
    if types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        return _numeric(types, kind.value_type)
    tests = (types.is_integer, types.is_floating, types.is_boolean, types.is_timestamp)
    return any(test(kind) for test in tests)


def _lerobot_info(path: Path) -> tuple[float, tuple[str, ...]]:
    """Frame rate [Hz], and names of the elements of the state; empty if the data set does not name them."""
    try:
        info = json.loads(path.read_text(encoding="utf-8"))
        rate, state = float(info["fps"]), info["features"][STATE]
        if not rate > 0.0:
            raise ValueError(f"fps is {rate}")
        return rate, tuple(name.removesuffix(".pos") for name in _texts(state.get("names")))
    except (OSError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise NotAFile(f"{path} does not describe a LeRobot data set: {error!r}") from error


def _texts(value: Any) -> Iterator[str]:
    """All texts in nested lists or mappings, as versions of the format differ."""
    if isinstance(value, str):
        yield value
    for item in value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ():
        yield from _texts(item)


WIDEST = 200
"""Maximum number of columns of a matrix: with more rows and columns it is a picture."""


def table_of(source: Path, named: Mapping[str, Any], between: str = ".", **known: Any) -> Table:
    """Table of arrays: a matrix `q` becomes `q1`, `q2`; names in a group are preceded by that of the group.

    The number of samples is the axis length with the most numbers. Arrays without such an axis, such as
    parameters beside the run, are left out. `known` are further attributes of the table.
    """
    size = 0

    def require(count: int) -> None:
        """Refuse an array, before its numbers are read, if the content becomes too large."""
        nonlocal size
        size += 8 * count
        require_size(source, size)

    arrays = dict(_arrays("", named, between, require))
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


def _arrays(
    name: str, value: Any, between: str, require: Callable[[int], None]
) -> Iterator[tuple[str, np.ndarray]]:
    """All arrays of numbers with one or two axes longer than one, as floats, and their names."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _arrays(f"{name}{between}{key}" if name else str(key), item, between, require)
        return
    lengths = [count for count in getattr(value, "shape", ()) if count > 1]
    if len(lengths) > 2 or len(lengths) == 2 and min(lengths) > WIDEST:
        return  # pictures; they are not even read
    require(math.prod(lengths))
    values = np.asarray(value)
    if values.dtype.names:
        yield from _arrays(name, {field: values[field] for field in values.dtype.names}, between, require)
    elif values.dtype == object:
        for place, item in enumerate(values.flat):
            if isinstance(item, np.ndarray | np.void):
                yield from _arrays(name if values.size == 1 else f"{name}{place + 1}", item, between, require)
    elif values.dtype.kind in "mM" and values.size > 1:
        yield name, np.squeeze(values.astype(f"{values.dtype.kind}8[ns]").astype(float)) * 1e-9
    elif values.dtype.kind in "biuf" and values.size > 1:
        yield name, np.squeeze(values.astype(float))
