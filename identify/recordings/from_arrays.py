"""Recordings from arrays and tables in memory."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import WrongShape
from .recording import Recording, Signal
from .units import OF_JOINT

if TYPE_CHECKING:
    from ..model import Model


def signals_of(t: Any, arrays: Mapping[str, Any], degrees: bool) -> dict[str, Signal]:
    """Signals from arrays (t, n) by name, on one time axis (t,) [s] that begins at zero; skips None."""
    time = np.asarray(t, float)
    signals = {}
    for name, values in arrays.items():
        if values is None:
            continue
        array = np.asarray(values, float) * (np.pi / 180.0 if degrees and name in OF_JOINT else 1.0)
        if time.ndim != 1 or array.shape[:1] != time.shape or array.ndim > 2:
            raise WrongShape(
                f"{name} has shape {array.shape} and t {time.shape}; expected (t, n) and (t,): one row per "
                "sample, one column per joint"
            )
        signals[name] = Signal(time - time[:1].sum(), array.reshape(len(time), -1))
    return signals


def from_dataframe(table: Any, robot: "Model", name: str = "table", **options: Any) -> list[Recording]:
    """Runs of a pandas table, whose columns are read like those of a file.

    Args:
        table: The table; an index with a name is a column too.
        robot: Model of the recorded arm.
        name: Name of the run.
        options: Options of `import_table`, such as the names of the columns.

    Raises:
        RecordingError: The table holds no run of this robot; the message gives the reason.
    """
    from .tables.import_table import import_table
    from .tables.table import Table

    columns = table.reset_index() if table.index.name else table
    names = [str(column) for column in columns.columns]
    values = columns.to_numpy(dtype=float)
    return import_table(lambda _: [Table(names, values)], Path(name), robot, name=name, **options)
