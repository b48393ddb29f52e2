"""Errors about missing parts of a log: time, positions, efforts."""

from collections.abc import Sequence

import numpy as np

from ..arm.robot import Robot
from ..errors import NotFinite, NotRecorded, RecordingError
from ..recordings.effort_checks import unmeasured_words
from ..recordings.incomplete_samples import LARGEST, is_number
from ..recordings.tables.column_names import families
from ..recordings.tables.name_index import column_words, named_joints

RATE = "or state the sampling rate: exidyn init --rate HZ"


def no_time(rising: int) -> RecordingError:
    """Error for a log without a column called time; `rising` is the number of columns that increase."""
    name = f"Name it: exidyn init --columns time=NAME; {RATE}" if rising else RATE.removeprefix("or ")
    return RecordingError(
        f"no column of time: {rising} columns increase, none of which is called time. {name}"
    )


def require_computable(names: Sequence[str], values: np.ndarray, places: Sequence[int]) -> None:
    """Reject numbers in the columns `places` of values (t, c) whose squares overflow, as the import does."""
    for place in places:
        rows = np.flatnonzero(np.isfinite(values[:, place]) & ~is_number(values[:, place]))
        if len(rows):
            raise NotFinite(
                f"column {names[place]} is above {LARGEST:g} in {len(rows)} of {len(values)} rows, first in "
                f"row {rows[0] + 1}: {values[rows[0], place]:g}. Leave such rows out"
            )


def require_measured(effort: np.ndarray, pattern: str) -> None:
    """Reject efforts (t, n) that are all constant; `pattern` is the name of their columns."""
    if words := unmeasured_words(effort):
        raise NotRecorded(
            f"{pattern}: {words}, and have no unit. Record a topic or columns with efforts or motor currents"
        )


def not_found(quantity: str, signals: Sequence[str], names: Sequence[str], robot: Robot) -> RecordingError:
    """Error for a log without one column per joint of any of `signals`, called `quantity`."""
    text = (
        f"no {quantity} of {robot.dof} joints ({named_joints(robot)}) found among the columns: "
        f"{column_words(names, quantity)}. "
    )
    fewer = _fewer(signals, names, robot)
    if fewer:
        return RecordingError(
            f"{text}The log has {fewer} joints: name the {fewer} in a robot.toml (urdf = ..., joints = "
            "[...]), and give that file as --robot"
        )
    # Fewer columns than time, positions and efforts cannot have all of them under other names.
    name = "Name them: --columns SIGNAL=NAME,...; or add" if len(names) > 2 * robot.dof else "Add"
    return RecordingError(f"{text}{name} those of another file")


def _fewer(signals: Sequence[str], names: Sequence[str], robot: Robot) -> int:
    """Number of joints for which the log has such columns, if fewer than the robot has; else 0."""
    for count in range(robot.dof - 1, 1, -1):
        groups = families(names, robot.joints[:count])
        if any(family.signal in signals and not family.by_name for family in groups):
            return count
    return 0
