"""LeRobot data sets: a folder with meta/info.json and episodes in Parquet files, version 2 or 3."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import NotAFile
from .parquet_file import parquet_columns
from .tables.table import Table, table_of

STATE = "observation.state"


def read_lerobot(source: Path) -> list[Table]:
    """Read the episodes, each a run; time is the number of the frame over the frames a second.

    Raises:
        NotAFile: A file is missing or is not of such a data set.
        MissingPackage: pyarrow is not installed.
    """
    rate, joints = _info(source / "meta" / "info.json")
    tables = []
    for path in sorted(source.glob("data/**/*.parquet")):
        columns = parquet_columns(path)
        if not {"episode_index", "frame_index", STATE} <= set(columns):
            raise NotAFile(f"{path} lacks episode_index, frame_index or {STATE}; it has {', '.join(columns)}")
        # Its own time stamps are the same, in single precision.
        columns["timestamp"] = columns["frame_index"] / rate
        for episode in np.unique(columns["episode_index"]).astype(int).tolist():
            rows = columns["episode_index"] == episode
            named = {name: column[rows] for name, column in columns.items()}
            tables.append(table_of(path, named, run=f"episode_{episode:06d}", joints=joints))
    if not tables:
        raise NotAFile(f"{source} has no episodes in data/*.parquet")
    return tables


def _info(path: Path) -> tuple[float, tuple[str, ...]]:
    """Frames a second, and the names of what the state holds; none where the data set does not name it."""
    try:
        info = json.loads(path.read_text(encoding="utf-8"))
        rate, state = float(info["fps"]), info["features"][STATE]
        if not rate > 0.0:
            raise ValueError(f"fps is {rate}")
        return rate, tuple(name.removesuffix(".pos") for name in _texts(state.get("names")))
    except (OSError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise NotAFile(f"{path} is no description of a LeRobot data set: {error!r}") from error


def _texts(value: Any) -> Iterator[str]:
    """All texts in lists or mappings, however deep: versions of the format differ."""
    if isinstance(value, str):
        yield value
    for one in value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ():
        yield from _texts(one)
