"""A recording as one table, with the names by which `exidyn import` reads it again."""

import io
from collections.abc import Callable

import numpy as np

from ....notebook import optional
from ...recording import Recording
from ...servo_error import LAW
from .columns import PREFIXES


def columns_of(recording: Recording) -> dict[str, np.ndarray]:
    """Time `t` [s] and each signal of each joint, `q1`, `q2`, …, in the units of `SIGNALS`, shape (t,) each.

    A row for every time at which anything was measured; NaN for what was not measured then. Joints on which
    a signal was never measured have no column, and nor has an effort that was made of commands.
    """
    made = ("current",) if LAW in recording.settings else ()
    signals = {name: signal for name, signal in recording.signals.items() if name not in made}
    time = np.unique(np.concatenate([signal.time for signal in signals.values()]))
    found = {"t": time}
    for name, signal in signals.items():
        rows = np.searchsorted(time, signal.time)
        for joint, values in enumerate(signal.values.T):
            if not np.isnan(values).all():
                column = found[f"{PREFIXES[name][0]}{joint + 1}"] = np.full(len(time), np.nan)
                column[rows] = values
    return found


def _csv_bytes(recording: Recording) -> bytes:
    """Text with commas, a line of names, and every digit; empty where nothing was measured."""
    table = columns_of(recording)
    cells = np.column_stack([*table.values()]).tolist()
    rows = [",".join("" if np.isnan(cell) else repr(cell) for cell in row) for row in cells]
    return "\n".join([",".join(table), *rows, ""]).encode()


def _parquet_bytes(recording: Recording) -> bytes:
    """Columns of double precision; null where nothing was measured.

    Raises:
        MissingPackage: pyarrow is not installed.
    """
    arrow = optional("pyarrow", "a Parquet file", "parquet")
    parquet = optional("pyarrow.parquet", "a Parquet file", "parquet")
    file = io.BytesIO()
    table = {name: arrow.array(values, from_pandas=True) for name, values in columns_of(recording).items()}
    parquet.write_table(arrow.table(table), file)
    return file.getvalue()


TABLES: dict[str, Callable[[Recording], bytes]] = {"csv": _csv_bytes, "parquet": _parquet_bytes}
"""Format, and ending of such files -> how a recording is written."""


def left_out(recording: Recording) -> list[str]:
    """What a recording has and a table has not, a sentence each."""
    held = {
        "the robot and its nominal values: import needs --robot": True,
        f"the payload {recording.payload and recording.payload.name}": recording.payload,
        "the trajectory": recording.trajectory,
        "events, timing and outcome of the run": recording.events or recording.timing or recording.outcome,
        "the host's clock": recording.host_time is not None,
    }
    return [sentence for sentence, there in held.items() if there]
