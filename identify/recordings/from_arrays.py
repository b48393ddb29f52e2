"""Recordings out of arrays and tables in memory."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..effects import known_parameters
from ..errors import WrongShape
from ..robot_files.robot_file import read_model
from .recording import KnownPayload, Recording, Signal

if TYPE_CHECKING:
    from ..model import Model

IN_RADIANS = ("position", "velocity", "link_position", "command", "command_velocity")
"""Signals that may be in degrees."""


def from_arrays(
    robot: "Model | Path | str",
    t: Any,
    q: Any,
    *,
    torque: Any = None,
    current: Any = None,
    dq: Any = None,
    mass: float | None = None,
    com: Sequence[float] | None = None,
    degrees: bool = False,
    name: str = "arrays",
    **signals: Any,
) -> Recording:
    """One recording out of arrays; see `Recording.from_arrays`."""
    model = read_model(robot) if isinstance(robot, Path | str) else robot
    time = np.asarray(t, float)
    arrays = {"position": q, "velocity": dq, "torque": torque, "current": current, **signals}
    scale = {key: np.pi / 180.0 for key in IN_RADIANS} if degrees else {}
    measured = {
        key: _signal(key, time, scale.get(key, 1.0) * np.asarray(values, float))
        for key, values in arrays.items()
        if values is not None
    }
    body = None if mass is None else KnownPayload("L", known_parameters(mass, com))
    return Recording(name, model, measured, payload=body)


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
