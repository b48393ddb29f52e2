"""Valid files of what exidyn keeps beside recordings: a fleet's store, and rounds of a study."""

import json
from functools import cache
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import pyarrow
import pyarrow.parquet

from exidyn.acquire.fleet.store import CHANGES, Store, utc, write_table
from exidyn.acquire.fleet.store_schema import IndexRow
from exidyn.acquire.study.rounds import CHOICE, ROBOT
from exidyn.identification.robot_files.robot_file import model_text

from ..small import fleet_runs, two_joints
from ..small.small_choice import choice
from .parser_files import Files

KIND, ARM = "two_joints-00000000", "arm 1"
DATED = ("date", "earliest", "latest", "alarm")


@cache
def fleet_store() -> Files:
    """Three runs of an arm, its type, and a change."""
    kind, _ = fleet_runs.kind_and_equations()
    with TemporaryDirectory() as name:
        store = Store(Path(name))
        store.write_kind(KIND, kind)
        for run in fleet_runs.season(0, weeks=3):
            file = f"{ARM}/{run.key}.mcap"
            row = IndexRow(run.key, utc(run.day), KIND, file, 1000, 1.0, "", "", ARM)
            store.write_run(row, run.summary)
        change = {"arm": ARM, "kind": KIND, "date": utc(fleet_runs.START), "words": "friction"}
        write_table(store.folder / CHANGES, [change])
        return {
            path.relative_to(name).as_posix(): path.read_bytes()
            for path in sorted(Path(name).rglob("*"))
            if path.is_file()
        }


def rows_of(parquet: bytes) -> bytes:
    """The rows of a Parquet file as JSON."""
    rows = pyarrow.parquet.read_table(BytesIO(parquet)).to_pylist()
    return json.dumps(rows, default=lambda date: date.isoformat()).encode()


def parquet_of(rows: bytes) -> bytes:
    """JSON as a Parquet file, dates as such where they are; text that Parquet cannot hold stays JSON."""
    file = BytesIO()
    try:
        table = pyarrow.Table.from_pylist(json.loads(rows))
        for place, name in enumerate(table.column_names):
            if name in DATED and pyarrow.types.is_string(table.schema.field(name).type):
                dates = table[name].cast(pyarrow.timestamp("us", "UTC"))
                table = table.set_column(place, name, dates)
        pyarrow.parquet.write_table(table, file)
    except (pyarrow.ArrowException, ValueError, TypeError, AttributeError, OverflowError, KeyError):
        return rows
    return file.getvalue()


@cache
def study() -> Files:
    """Two rounds, the second of which ended it, and the arm that it is about."""
    folder = Path("round-01") / "diagnosis" / CHOICE, Path("round-02") / "diagnosis" / CHOICE
    tables = choice("run", 10.0), choice("undecidable", 20.0)
    for table in tables:
        table["shapes"] = [["joint_elasticity", [1], "", {"resonance": 5.4, "damping_ratio": 0.01}]]
        table["findings"] = [["joint_spring", [2]]]
    files = {str(path): json.dumps(table).encode() for path, table in zip(folder, tables, strict=True)}
    return files | {ROBOT: model_text(two_joints.model()).encode()}
