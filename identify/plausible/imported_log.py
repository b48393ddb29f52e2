"""The log of a proposal as import reads it with hypothetical units: the same clocks, repairs and rows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..errors import BadTime, RecordingError
from ..model import Model
from ..recordings.misread_columns import unwrapped
from ..recordings.recording import EFFORT, SIGNALS, Recording
from ..recordings.servo_error import COMMAND
from ..recordings.tables.column_names import Family
from ..recordings.tables.import_table import import_values
from ..recordings.tables.preset import Preset, Reading
from ..recordings.units import factors
from .samples import LONG
from .units import TIME, Units, moves, unit_odds, units_of, with_fixed

RATE = "State the sampling rate: exidyn init --rate HZ"
FEWEST = 100
"""Minimum number of samples of a log."""


@dataclass(frozen=True)
class Log:
    """Time (t,) in its unit, and values of each signal (t, n) in the unit of the log."""

    time: np.ndarray
    values: Mapping[str, np.ndarray]


def rough_log(values: np.ndarray, clock: int, families: Mapping[str, Family]) -> Log:
    """Log of the rows of values (t, c) with all numbers and a later time than all rows before them."""
    known = [place for family in families.values() for place in family.places]
    known = [place for place in known if np.isfinite(values[:, place]).mean() > 0.5]
    rows = values[np.isfinite(values[:, [clock, *known]]).all(axis=1)]
    later = np.maximum.accumulate(rows[:, clock])
    rows = rows[np.concatenate([[True], np.diff(later) > 0])] if len(rows) else rows
    columns = {signal: rows[:, [*family.places]] for signal, family in families.items()}
    if "position" in columns:
        columns["position"] = np.apply_along_axis(_continuous, 0, columns["position"])
    return Log(rows[:, clock], columns)


def _continuous(position: np.ndarray) -> np.ndarray:
    """Positions (t,) without jumps by a full turn, which would look like high speeds."""
    better = unwrapped(position) or unwrapped(position, 360.0)
    return position if better is None else better.values


def likely_units(log: Log, robot: Robot, stated: Units, fixed: Units) -> Units:
    """Most probable units of a log, from its speeds, ranges and velocities; arguments as `propose_units`."""
    if len(log.time) < 2:
        return Units(*(part or si for part, si in zip(fixed, ("s", "rad", "rad"), strict=True)))
    seen = moves(log.time, log.values["position"], log.values.get("velocity"))
    odds = with_fixed(unit_odds(seen, robot, log.values["position"], stated), fixed)
    return max(odds, key=lambda units: odds[units])


class Signs(NamedTuple):
    """Signs of the columns of each joint."""

    position: list[float]
    effort: list[float]

    @property
    def by_signal(self) -> dict[str, list[float]]:
        """Signs of each signal of a recording that has them."""
        return dict.fromkeys(("position", "velocity"), self.position) | dict.fromkeys(EFFORT, self.effort)


def readings_of(
    columns: Mapping[str, Sequence[str]],
    units: Units,
    robot: Robot,
    position: np.ndarray,
    signs: Signs | None = None,
) -> dict[str, Reading]:
    """Reading of each signal in these columns; `position` are values of the positions, shape (t, n)."""
    angle = units_of(robot, units.position, position=position)
    rate = units_of(robot, units.velocity, "/s")
    unit = {"position": angle, "command": angle, "link_position": angle}
    unit |= {"velocity": rate, "command_velocity": rate} if units.velocity else {}
    sign = {} if signs is None else signs.by_signal
    readings = {
        signal: Reading([*names], unit.get(signal, ""), sign.get(signal, 1.0))
        for signal, names in columns.items()
    }
    return readings | {"time": Reading(columns["time"][0], units.time)}


def imported(
    names: Sequence[str],
    tables: Sequence[np.ndarray],
    readings: Mapping[str, Reading],
    model: Model,
    source: str,
) -> list[Recording]:
    """Runs of a log as import reads them; efforts keep the unit of the log.

    Args:
        names: Names of the c columns.
        tables: Values of the columns of each file, shape (t, c).
        readings: Columns and units of "time" and each signal.
        model: Model of the described arm.
        source: Name of the log, for messages.

    Raises:
        RecordingError: Import cannot read the log.
    """
    robot = replace(model.robot, servo=None)  # import would multiply the errors of servos by its gain
    as_is = {
        name: Reading(readings[name].column, readings[name].unit or [*robot.units(SIGNALS[name])])
        for name in EFFORT
        if name in readings
    }
    read = partial(
        import_values,
        names,
        source=source,
        model=replace(model, robot=robot),
        preset=Preset("", {**readings, **as_is}),
        effort=EFFORT[1] if as_is else COMMAND,
        in_si=False,
    )
    try:
        runs = [run for values in tables for run in read(values)]
    except BadTime as error:
        raise BadTime(f"{error}. {RATE}" if error.fact else str(error)) from error
    if (count := sum(len(run.signals["position"]) for run in runs)) < FEWEST:
        raise RecordingError(
            f"{count} samples with time, positions and efforts; {FEWEST} are needed: record a motion"
        )
    return runs


def in_log_units(runs: Sequence[Recording], readings: Mapping[str, Reading], units: Units) -> Log:
    """Samples of all runs, one run after another with a gap, in the units of the log."""
    robot = runs[0].robot
    gap = 2.0 * LONG * max(run.signals["position"].period for run in runs)
    times, start = [], 0.0
    for run in runs:
        time = run.signals["position"].time
        times.append(time - time[0] + start)
        start = times[-1][-1] + gap
    values = {}
    for name in {name: None for run in runs for name in run.signals}:
        if all(name in run.signals for run in runs):
            parts = [run.signals[name].at(run.signals["position"].time) for run in runs]
            stated = readings[name].unit if name in readings and name not in EFFORT else ""
            wanted = robot.units(SIGNALS[name])
            unit = [stated] * robot.dof if isinstance(stated, str) else stated
            factor, offset = factors(wanted, unit, name, robot.limits)
            values[name] = (np.concatenate(parts) - offset) / factor
    return Log(np.concatenate(times) / TIME[units.time], values)
