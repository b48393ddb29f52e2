"""Comma-separated values: one row a sample, columns named t, q1, …, dq1, …, i1, … or as mapped."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ...arm.robot import Robot
from ...errors import NotAFile, NotFinite, RecordingError, WrongShape, listed
from ...model import Model
from ..recording import SIGNALS, KnownPayload, Recording, Signal
from ..recording_checks import check
from ..units import joint_side, to_axes_of_robot, to_radians
from .table_text import read_table

PREFIXES: dict[str, tuple[str, ...]] = {
    "position": ("q",),
    "velocity": ("dq", "qd"),
    "current": ("i",),
    "torque": ("tau",),
    "temperature": ("temp",),
    "link_position": ("ql",),
    "command": ("q_ref", "q_cmd"),
    "command_velocity": ("dq_ref", "dq_cmd"),
}
"""What stands before the number of the joint in a column's name; the signal's own name always may."""

TIMES = ("t", "time", "timestamp")

Columns = Mapping[str, str | Sequence[str]]


def import_csv(
    source: Path,
    model: Model | None = None,
    columns: Columns | None = None,
    degrees: bool = False,
    motor_side: bool | Sequence[str] = False,
    sign: Sequence[float] | None = None,
    zero: Sequence[float] | None = None,
    time_scale: float = 1.0,
    skip_rows: int = 0,
    name: str | None = None,
    payload: KnownPayload | None = None,
    settings: Mapping[str, str] | None = None,
) -> list[Recording]:
    """Import one file; irregular time stamps stay as they are.

    Args:
        source: A .csv or .csv.gz file with a line of names at its beginning, comma, semicolon or tab.
        model: The nominal robot.
        columns: Where the names are others: "time" -> column; signal -> list of columns, one a joint, or
            a pattern with {number} or {joint} in it, such as "axis{number}_current".
        degrees: Positions and velocities are in degrees and degrees a second.
        motor_side: Positions, velocities and torques are the motor's, before the gear; or which of them.
        sign: 1 or -1 a joint, where the controller counts the other way than the robot's description.
        zero: Position in the robot's description where the controller shows zero [rad], one a joint.
        time_scale: Seconds per unit of the time column.
        skip_rows: Rows to leave out at the beginning, where a recorder had not yet settled.
        name: Name of the run; that of the file by default.
        payload: What hung on the flange.
        settings: Whatever else explains the run.

    Raises:
        RecordingError: The file does not hold a run of this robot; the message gives the reason.
    """
    if model is None:
        raise RecordingError(f"{source}: a table does not name its robot; give the robot too (--robot FILE)")
    header, values, lines = read_table(source)
    values, lines = values[skip_rows:], lines[skip_rows:]
    if not len(values):
        raise NotAFile(f"{source} has no samples behind the {skip_rows} rows to skip (--skip-rows)")
    time, *places = _places(source, model.robot, header, columns or {})
    stamps = _stamps(source, values[:, time[1][0]] * time_scale, lines)
    start = stamps[0]
    signals = {}
    for signal, where in places:
        picked = values[:, [max(place, 0) for place in where]]
        picked[:, [place < 0 for place in where]] = np.nan
        signals[signal] = Signal(stamps - start, picked)
    recording = Recording(
        name=name or source.name.removesuffix(".gz").rsplit(".", 1)[0],
        model=model,
        signals=signals,
        payload=payload,
        settings={"source": source.name, "first_time_stamp_s": repr(float(start)), **(settings or {})},
    )
    if degrees:
        recording = to_radians(recording)
    recording = to_axes_of_robot(joint_side(recording, motor_side), sign, zero)
    try:
        return [check(recording)]
    except NotFinite as error:
        if error.time is None:
            raise
        row = int(np.argmin(np.abs(stamps - start - error.time)))
        raise NotFinite(f"{source} line {lines[row]}: {error}", error.time) from error


def _stamps(source: Path, stamps: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """The time stamps, shape (t,) [s], if they can be those of a run."""
    bad = np.flatnonzero(~np.isfinite(stamps))
    if len(bad):
        raise NotFinite(
            f"{source} line {lines[bad[0]]}: no time stamp; leave such rows out ({len(bad)} in all)"
        )
    if len(stamps) < 2:
        raise NotAFile(f"{source} has one sample, in line {lines[0]}; a run has many")
    return stamps


def _places(source: Path, robot: Robot, header: list[str], columns: Columns) -> list[tuple[str, list[int]]]:
    """Column numbers of the time, first, and of each signal; -1 for a joint without one."""
    unknown = [key for key in columns if key != "time" and key not in SIGNALS]
    if unknown:
        raise WrongShape(
            f"columns (--columns): unknown {', '.join(unknown)}. Valid: time, {', '.join(SIGNALS)}"
        )
    times = [columns["time"]] if "time" in columns else TIMES
    time = next((header.index(str(column)) for column in times if column in header), None)
    if time is None:
        raise WrongShape(
            f"{source}: no column of time ({', '.join(map(str, times))}) among {listed(header, 't')}; name "
            'it by --columns time=NAME (columns={"time": NAME})'
        )
    found: list[tuple[str, list[int]]] = [("time", [time])]
    for signal in SIGNALS:
        names = _names(signal, robot, columns)
        where = [next((header.index(n) for n in choices if n in header), -1) for choices in names]
        if signal in columns or signal == "position":
            _refuse_missing(source, signal, names, where, header)
        if max(where) >= 0:
            _refuse_more(source, signal, robot, header, columns)
            found.append((signal, where))
    return found


def _names(signal: str, robot: Robot, columns: Columns) -> list[list[str]]:
    """Names that the column of each joint may have."""
    given = columns.get(signal)
    if given is not None and not isinstance(given, str):
        if len(given) != robot.dof:
            raise WrongShape(
                f"columns (--columns): {signal} has {len(given)} columns, {robot.name} {robot.dof} joints"
            )
        return [[column] for column in given]
    if given is not None:
        return [[given.format(number=k + 1, joint=joint)] for k, joint in enumerate(robot.joints)]
    prefixes = (*PREFIXES[signal], signal)
    return [
        [f"{p}{k + 1}" for p in prefixes]
        + [f"{p}_{joint}" for p in prefixes]
        + [f"{joint}{between}{signal}" for between in "_./"]
        for k, joint in enumerate(robot.joints)
    ]


def _refuse_missing(
    source: Path, signal: str, names: list[list[str]], where: list[int], header: list[str]
) -> None:
    missing = [choices[0] for choices, place in zip(names, where, strict=True) if place < 0]
    if missing:
        raise WrongShape(
            f"{source}: no column {listed(missing)} for {signal}. Columns: {listed(header, missing[0])}; "
            f"name others by --columns {signal}=NAME,NAME,... (columns={{...}})"
        )


def _refuse_more(source: Path, signal: str, robot: Robot, header: list[str], columns: Columns) -> None:
    """A table with more joints than the robot is of another robot."""
    if signal in columns:
        return
    for prefix in PREFIXES[signal]:
        numbers = [int(m[1]) for c in header if (m := re.fullmatch(re.escape(prefix) + r"(\d+)", c))]
        if numbers and max(numbers) > robot.dof:
            raise WrongShape(
                f"{source}: column {prefix}{max(numbers)}, but {robot.name} has {robot.dof} joints: "
                f"{', '.join(robot.joints)}"
            )
