"""Store of a fleet: Parquet files by arm and month, which DuckDB, pandas and Polars read directly.

Each `runs/arm=A/month=M/HASH.parquet` holds one run under the hash of its recording. Every process would
write the same file, so that an interruption neither loses nor repeats work. `kinds/` has one file per type of
arm.
"""

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import quote, unquote
from uuid import uuid4

import numpy as np
from msgspec.structs import asdict as asdict_of

from exidyn.identification.fit.fit_file import read_json
from exidyn.identification.fleet.kind import Kind
from exidyn.identification.fleet.runs import Run
from exidyn.identification.fleet.summary import Summary
from exidyn.identification.notebook import optional
from exidyn.identification.recordings.decompression_limits import require_size
from exidyn.identification.robot_files.robot_file import model_text, parse_model
from exidyn.identification.schema import checked

from .store_schema import ChangeRow, IndexRow, KindFile, RunRow, plain, refused, require_kind

R = TypeVar("R", bound=IndexRow)
DAY = 86400.0
CHANGES = "changes.parquet"
"""Table of all changes in the store's folder."""
MERGED = "month"
"""Beginning of the name of a file with all runs of a month."""


@dataclass(frozen=True)
class Store:
    """The store of a fleet in a folder."""

    folder: Path

    @property
    def runs(self) -> Path:
        """The folder of the runs."""
        return self.folder / "runs"

    def write_kind(self, key: str, kind: Kind) -> None:
        """Write a type of arm."""
        text = {
            "robot": model_text(kind.model),
            "filtering": asdict(kind.filtering),
            "measures": kind.measures,
        }
        _write_bytes(self.folder / "kinds" / f"{key}.json", json.dumps(text, indent=1).encode())

    def kind(self, key: str) -> Kind:
        """Read a type of arm.

        Raises:
            NotAFile: If its file is damaged.
            RobotError: If the robot in it is wrong.
        """
        path = self.folder / "kinds" / f"{key}.json"
        with refused(path):
            file = checked(read_json(path), KindFile, str(path))
            return Kind(parse_model(file.robot, where=str(path)), file.filtering, file.measures)

    def kinds(self) -> list[str]:
        """Keys of all types of arms."""
        return sorted(path.stem for path in (self.folder / "kinds").glob("*.json"))

    def write_run(self, row: IndexRow, summary: Summary | None = None) -> None:
        """Write a run; it has no summary if it could not be identified."""
        path = self.runs / place_of(row.arm, row.date) / f"{row.key}.parquet"
        write_table(path, [_columns(row, summary)])

    def merge(self) -> None:
        """Merge the runs of each arm and month into one file, so that a year is read in seconds.

        The merged file exists before its parts are removed; runs in both count once.
        """
        arrow, parquet = _arrow()
        for folder in sorted({path.parent for path in self.runs.glob("*/*/*.parquet")}):
            parts = sorted(folder.glob("*.parquet"))
            if len(parts) == 1:
                continue
            for part in parts:
                _table(part)  # names the damaged part
            rows = arrow.concat_tables(map(_table, parts), promote_options="default")
            keys = np.asarray(rows["key"].to_pylist())
            rows = rows.take(np.unique(keys, return_index=True)[1])
            _write(folder / f"{MERGED}-{uuid4().hex}.parquet", rows)
            for part in parts:
                part.unlink()

    def index(self) -> dict[str, IndexRow]:
        """All runs without their summaries, by key."""
        columns = [name for name in IndexRow.__struct_fields__ if name != "arm"]
        return {row.key: row for row in self._rows(IndexRow, columns)}

    def arms(self, kind: str) -> dict[str, list[Run]]:
        """Identified runs of each arm of a type."""
        by_arm: dict[str, dict[str, Run]] = {}
        for row in self._rows(RunRow, of=self.kind(kind), key=kind):
            day = row.date.timestamp() / DAY
            by_arm.setdefault(row.arm, {})[row.key] = Run(row.key, day, _summary(row))
        return {arm: list(runs.values()) for arm, runs in sorted(by_arm.items())}

    def changes(self, arm: str) -> list[dict[str, Any]]:
        """Changes of an arm, as last written."""
        path = self.folder / CHANGES
        if not path.exists():
            return []
        with refused(path):
            rows = [(row, checked(row, ChangeRow, str(path))) for row in _table(path).to_pylist()]
        return [row for row, known in rows if known.arm == arm]

    def _rows(
        self, schema: type[R], columns: Sequence[str] | None = None, of: Kind | None = None, key: str = ""
    ) -> Iterator[R]:
        """Rows of all files, or identified runs of one type of arm if `of` is set."""
        for path in sorted(self.runs.glob("*/*/*.parquet")):
            arm = unquote(path.parent.parent.name.partition("=")[2])
            with refused(path):
                rows = [
                    {"note": "", **plain(row), "arm": arm}  # files of an earlier version have no notes
                    for row in _table(path, columns).to_pylist()
                    if of is None or (row.get("kind") == key and not row.get("error"))
                ]
                valid = [checked(row, schema, str(path)) for row in rows]
                for row in valid:
                    if isinstance(row, RunRow) and of is not None:
                        require_kind(row, of)
            yield from valid


def _columns(row: IndexRow, summary: Summary | None) -> dict[str, Any]:
    """Columns of a run's file; the arm is in its path."""
    columns = asdict_of(row)
    del columns["arm"]
    return columns | {
        "seconds": summary.seconds if summary else None,
        "payload": summary.payload if summary else None,
        "payload_known": summary.known if summary else None,
        "temperature": summary.temperature.tolist() if summary else [],
        "residual": summary.residual.tolist() if summary else [],
        "noise": summary.noise.tolist() if summary else [],
        "counts": summary.counts.tolist() if summary else [],
        "factors": _packed(summary.factors).tolist() if summary else [],
    }


def _packed(factors: np.ndarray) -> np.ndarray:
    """Upper triangles of factors (n, c, c) in one array."""
    upper = np.triu_indices(factors.shape[1])
    return np.concatenate([factor[upper] for factor in factors])


def _table(path: Path, columns: Sequence[str] | None = None) -> Any:
    """A Parquet file as a table, if it is not too large; columns that it lacks are omitted."""
    _, parquet = _arrow()
    with refused(path), parquet.ParquetFile(path) as file:
        require_size(
            path, sum(file.metadata.row_group(k).total_byte_size for k in range(file.num_row_groups))
        )
        existing = [name for name in file.schema_arrow.names if columns is None or name in columns]
        return file.read(existing)


def _summary(row: RunRow) -> Summary:
    joints = len(row.counts)
    packed = np.reshape(row.factors, (joints, -1))
    size = round((np.sqrt(8 * packed.shape[1] + 1) - 1) / 2)
    factors = np.zeros((joints, size, size))
    factors[(slice(None), *np.triu_indices(size))] = packed
    return Summary(
        factors=factors,
        counts=np.array(row.counts),
        noise=np.array(row.noise, float),
        residual=np.array(row.residual, float),
        temperature=np.array(row.temperature, float),
        payload=row.payload,
        known=row.payload_known,
        seconds=row.seconds,
    )


def place_of(arm: str, date: datetime) -> str:
    """Folder of an arm's month, from which other tools read the columns `arm` and `month`."""
    return f"arm={quote(arm, safe='')}/month={date:%Y-%m}"


def write_table(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows as a Parquet file, which appears under its name only once it is complete."""
    arrow, _ = _arrow()
    schema = arrow.schema([(name, _type(arrow, name, value)) for name, value in rows[0].items()])
    _write(path, arrow.Table.from_pylist(list(rows), schema))


def _type(arrow: Any, name: str, value: Any) -> Any:
    """Type of a column, by its name if its first value is None."""
    if name == "counts":
        return arrow.list_(arrow.int64())
    if isinstance(value, list):
        return arrow.list_(arrow.float64())
    if isinstance(value, datetime):
        return arrow.timestamp("us", "UTC")
    by_name = {"payload": arrow.string(), "seconds": arrow.float64(), "payload_known": arrow.bool_()}
    by_type = {str: arrow.string(), bool: arrow.bool_(), int: arrow.int64(), float: arrow.float64()}
    return by_name.get(name) or by_type[type(value)]


def _write(path: Path, table: Any) -> None:
    _, parquet = _arrow()
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{uuid4().hex}")
    parquet.write_table(table, part, compression="zstd")
    os.replace(part, path)


def _write_bytes(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{uuid4().hex}")
    part.write_bytes(content)
    os.replace(part, path)


def _arrow() -> tuple[Any, Any]:
    purpose = "a fleet's tables"
    return optional("pyarrow", purpose, "fleet"), optional("pyarrow.parquet", purpose, "fleet")


def utc(day: float) -> datetime:
    """The date of a time in days since 1970."""
    return datetime.fromtimestamp(day * DAY, UTC)
