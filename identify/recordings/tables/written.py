"""A recording as one table, with names that `exidyn import` recognizes."""

import io
from collections.abc import Callable

import numpy as np

from ...notebook import optional
from ..recording import Recording
from ..servo_error import LAW
from .columns import PREFIXES


def columns_of(recording: Recording) -> dict[str, np.ndarray]:
    """Time `t` [s] and each signal of each joint, `q1`, `q2`, …, in the units of `SIGNALS`, shape (t,) each.

    There is one row per time of any sample, with NaN for signals without a sample then. Joints without
    samples of a signal have no column, and neither has an effort that was computed from commands.
    """
    computed = ("current",) if LAW in recording.settings else ()
    signals = {name: signal for name, signal in recording.signals.items() if name not in computed}
    time = np.unique(np.concatenate([signal.time for signal in signals.values()]))
    columns = {"t": time}
    for name, signal in signals.items():
        rows = np.searchsorted(time, signal.time)
        for joint, values in enumerate(signal.values.T):
            if not np.isnan(values).all():
                column = columns[f"{PREFIXES[name][0]}{joint + 1}"] = np.full(len(time), np.nan)
                column[rows] = values
    return columns


def _csv_bytes(recording: Recording) -> bytes:
    """CSV text with commas, a line of names, and all digits; cells without a sample are empty."""
    table = columns_of(recording)
    cells = np.column_stack([*table.values()]).tolist()
    rows = [",".join("" if np.isnan(cell) else repr(cell) for cell in row) for row in cells]
    return "\n".join([",".join(table), *rows, ""]).encode()


def _parquet_bytes(recording: Recording) -> bytes:
    """Parquet file with columns of double precision; cells without a sample are null."""
    arrow = optional("pyarrow", "a Parquet file", "parquet")
    parquet = optional("pyarrow.parquet", "a Parquet file", "parquet")
    file = io.BytesIO()
    table = {name: arrow.array(values, from_pandas=True) for name, values in columns_of(recording).items()}
    parquet.write_table(arrow.table(table), file)
    return file.getvalue()


TABLES: dict[str, Callable[[Recording], bytes]] = {"csv": _csv_bytes, "parquet": _parquet_bytes}
"""Format, which is also the file ending -> function that writes a recording."""


def left_out(recording: Recording) -> list[str]:
    """Content of a recording that a table cannot hold, as phrases."""
    held = {
        "the robot and its nominal values: import needs --robot": True,
        f"the payload {recording.payload and recording.payload.name}": recording.payload,
        "the trajectory": recording.trajectory,
        "events, timing and outcome of the run": recording.events or recording.timing or recording.outcome,
        "the host's clock": recording.host_time is not None,
    }
    return [sentence for sentence, there in held.items() if there]
