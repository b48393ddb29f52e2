"""Errors about missing parts of a log: time, positions, efforts."""

from collections.abc import Sequence

import numpy as np

from ..arm.robot import Robot
from ..errors import BadTime, NotFinite, NotRecorded, RecordingError
from ..recordings.effort_checks import unmeasured_words
from ..recordings.recording_findings import LARGEST, is_number
from ..recordings.steps_back import advice, steps_back
from ..recordings.tables.column_names import STAMPS, families, words_of
from ..recordings.tables.name_index import column_words, named_joints
from ..text_table import digits

RATE = "or state the sampling rate: exidyn init --rate HZ"


def no_time(names: Sequence[str], values: np.ndarray, rising: int) -> RecordingError:
    """Error if no column of values (t, c) can be time: none has such a name, or those do not increase.

    `rising` is the number of columns that always increase.
    """
    called = [k for k, name in enumerate(names) if STAMPS.intersection(words_of(name))]
    moving = [k for k in called if len(values) > 1 and np.any(np.diff(values[:, k]) > 0)]
    if moving:
        return _goes_back(names[moving[0]], values[:, moving[0]], np.delete(values, called, axis=1))
    if called:
        return BadTime(f"column {names[called[0]]} does not increase at all; name the time column, {RATE}")
    name = f"Name it: exidyn init --columns time=NAME; {RATE}" if rising else RATE.removeprefix("or ")
    return RecordingError(
        f"no column of time: {rising} columns increase, none of which is called time. {name}"
    )


def _goes_back(name: str, time: np.ndarray, others: np.ndarray) -> RecordingError:
    """Error for a time column (t,) that does not increase, beside others (t, c); rows count from 1."""
    back = steps_back(time)
    if not len(back):
        lost = int(np.sum(~np.isfinite(time)))
        return BadTime(f"column {name} is not a number in {lost} of {len(time)} rows; leave them out, {RATE}")
    first = int(back[0])
    return BadTime(
        f"column {name} does not increase at {len(back)} of {len(time) - 1} steps, first from "
        f"{digits(time[first])} in row {first + 1} to {digits(time[first + 1])} in row {first + 2}. "
        f"{advice(time, others)}"
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
    return RecordingError(f"{text}Name them: --columns SIGNAL=NAME,...; or add those of another file")


def _fewer(signals: Sequence[str], names: Sequence[str], robot: Robot) -> int:
    """Number of joints for which the log has such columns, if fewer than the robot has; else 0."""
    for count in range(robot.dof - 1, 1, -1):
        groups = families(names, robot.joints[:count])
        if any(family.signal in signals and not family.by_name for family in groups):
            return count
    return 0
