"""Recordings out of arrays and tables in memory."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import WrongShape
from .recording import Recording, Signal

if TYPE_CHECKING:
    from ..model import Model

IN_RADIANS = ("position", "velocity", "link_position", "command", "command_velocity")
"""Signals that may be in degrees."""


def signals_of(t: Any, arrays: Mapping[str, Any], degrees: bool) -> dict[str, Signal]:
    """Signals out of arrays (t, n) by name, on one time axis (t,) [s] that begins at zero; None is left out.

    Raises:
        WrongShape: An array without a row for each time.
    """
    time = np.asarray(t, float)
    return {
        name: _signal(
            name, time, np.asarray(values, float) * (np.pi / 180.0 if degrees and name in IN_RADIANS else 1.0)
        )
        for name, values in arrays.items()
        if values is not None
    }


def _signal(name: str, time: np.ndarray, array: np.ndarray) -> Signal:
    if time.ndim != 1 or array.shape[:1] != time.shape or array.ndim > 2:
        raise WrongShape(
            f"{name} has shape {array.shape} and t {time.shape}; expected (t, n) and (t,): a row a sample, a "
            "column a joint"
        )
    return Signal(time - time[:1].sum(), array.reshape(len(time), -1))


def from_dataframe(table: Any, robot: "Model", name: str = "table", **options: Any) -> list[Recording]:
    """The runs of a pandas table, by the names of its columns, as of a file with these columns.

    Args:
        table: The table; where its index has a name, that is a column too.
        robot: The arm that was recorded.
        name: Name of the run.
        options: Options of `import_table`, such as the names of the columns.

    Raises:
        RecordingError: It holds no run of this robot; the message gives the reason.
    """
    from .importers.tables.import_table import import_table
    from .importers.tables.table import Table

    columns = table.reset_index() if table.index.name else table
    names = [str(column) for column in columns.columns]
    values = columns.to_numpy(dtype=float)
    return import_table(lambda _: [Table(names, values)], Path(name), robot, name=name, **options)
