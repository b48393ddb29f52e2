"""Columns of a log, renamed for a proposal, and restored to their names in the file.

A unit stated below the names is appended to the name. Columns that a person named get the words of their
signal. Of an array with more columns than the arm has joints, only the columns of this arm are used.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..errors import RecordingError
from ..recordings.recording import EFFORT
from ..recordings.tables.column_names import STAMPS, families, signal_of, words_of
from ..recordings.tables.columns import Columns, Names
from ..recordings.tables.name_index import array_name, columns_of_array, numbered, which_columns
from ..recordings.tables.preset import Reading
from ..recordings.tables.table import DATE, Table
from ..recordings.units import unit_named
from .proposal import Proposal

WORDS = {"link_position": "ql", "command_velocity": "command velocity"}
"""Signal -> words by which a proposal recognizes it, if they are not its name."""
FULL = ((0.0, 1.0), (4 * np.pi, 100.0))
"""Scales of a gripper's opening: value that the largest position must exceed, and value when fully open."""
SHARE_NOISE = 0.02
"""Tolerance of a gripper's opening below 0 and above full scale, relative to full scale."""


class LogColumns(NamedTuple):
    """A log with the column names that a proposal uses."""

    names: list[str]  # names of the c columns
    # Values of the columns, shape (t, c); torques and currents in a stated unit are in N m and A.
    values: np.ndarray
    original: Mapping[str, str]  # name of a column -> its name in the file
    torque_factor: Mapping[str, float]  # name of a torque column -> N m per unit of the file
    notes: tuple[str, ...] = ()  # sentences on decisions that were made

    def restored(self, proposal: Proposal) -> Proposal:
        """Proposal with the names of the file, and gains per unit that the import uses."""
        readings = {
            signal: Reading(self._originals(reading.column), reading.unit, reading.sign)
            for signal, reading in proposal.readings.items()
        }
        gains = proposal.gains
        if gains and "current" in proposal.columns:
            # The import does not apply a torque unit to currents.
            factors = [self.torque_factor.get(name, 1.0) for name in proposal.columns["current"]]
            gains = tuple(
                gain._replace(value=gain.value * factor) for gain, factor in zip(gains, factors, strict=True)
            )
        return replace(proposal, readings=readings, gains=gains, notes=(*self.notes, *proposal.notes))

    def _originals(self, names: Names) -> str | list[str]:
        """Names in the file of one column or of several."""
        if isinstance(names, str):
            return self.original.get(names, names)
        return [self.original.get(name, name) for name in names]


def log_columns(columns: Columns, chosen: Mapping[str, Names]) -> LogColumns:
    """Columns of a log for a proposal.

    Args:
        columns: Columns of the log, and the arm.
        chosen: "time", a signal or "effort" -> its columns, in the form that `Columns` accepts.

    Raises:
        WrongShape: A chosen column does not exist.
        RecordingError: An array has more columns than the arm has joints, and those of the arm are unknown.
    """
    table, robot = columns.table, columns.robot
    places = _chosen_places(columns, chosen, str(columns.source))
    arm, others, notes = _columns_of_arm(columns, places)
    shown = {k: _with_unit(table, k) for k in range(len(table.names))}
    for array in arm:
        for number, place in enumerate(array):
            before, _, behind = numbered(table.names[place]) or (table.names[place], 0, "")
            shown[place] = f"{before}{number + 1}{behind}"
    for signal, chosen_places in places.items():
        for joint, place in enumerate(chosen_places):
            words = WORDS.get(signal, signal)
            name = words if signal == "time" else f"{robot.joints[joint]} {words}"
            shown[place] = _with_unit(table, place, name)
    fixed = {place for chosen_places in places.values() for place in chosen_places}
    dropped = others | _rivals(shown, fixed, places, robot)
    used = [k for k in shown if k in fixed or k not in dropped]
    factor = {k: _effort_factor(table, k) for k in used}
    return LogColumns(
        [shown[k] for k in used],
        _from_zero(table.values[:, used] * [factor[k][0] for k in used], [shown[k] for k in used]),
        {shown[k]: table.names[k] for k in used},
        {shown[k]: value for k, (value, is_torque) in factor.items() if is_torque},
        tuple(notes),
    )


def _from_zero(values: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Values (t, c) with time stamps from zero, since ns since 1970 exceed the accepted range of numbers."""
    for place, name in enumerate(names):
        known = np.isfinite(values[:, place])
        if STAMPS.intersection(words_of(name)) and known.any():
            values[:, place] -= values[known.argmax(), place]
    return values


def _with_unit(table: Table, place: int, name: str = "") -> str:
    """Name of a column, or another name for it, followed by the unit that the file states elsewhere."""
    original = table.names[place]
    unit = table.unit(original) if name else table.units.get(original, "")
    unit = "s" if unit == DATE else unit
    return f"{name or original} [{unit.strip('[]() ')}]" if unit else original if not name else name


def _effort_factor(table: Table, place: int) -> tuple[float, bool]:
    """SI units per stated unit of an effort column, else 1; and whether the stated unit is one of torque."""
    entry = unit_named(table.unit(table.names[place])) or ("", 1.0, 0.0)
    is_torque = entry[0] in ("N m", "N")
    return (entry[1] if is_torque or entry[0] == "A" else 1.0), is_torque


def _chosen_places(columns: Columns, chosen: Mapping[str, Names], where: str) -> dict[str, list[int]]:
    """Indices of the chosen columns for time and signals."""
    signals = {name: names for name, names in chosen.items() if name != "time"}
    effort = {"torque": signals.pop("effort")} if "effort" in signals else {}
    places = {"time": [columns.time(chosen, where)]} if "time" in chosen else {}
    places |= columns.signals(signals, signals, (), where)
    if effort:
        places["effort"] = columns.signals(effort, effort, (), where)["torque"]
    return places


def _rivals(
    shown: Mapping[int, str], fixed: set[int], places: Mapping[str, Sequence[int]], robot: Robot
) -> set[int]:
    """Columns whose names mean a signal for which other columns were chosen."""
    signals = {*places, *(EFFORT if {"effort", *EFFORT} & set(places) else ())}
    others = [k for k in shown if k not in fixed]
    groups = families([shown[k] for k in others], robot.joints)
    rivals = {others[place] for family in groups if family.signal in signals for place in family.places}
    if "time" in places:
        rivals |= {k for k in others if STAMPS.intersection(words_of(shown[k]))}
    return rivals


def _columns_of_arm(
    columns: Columns, places: Mapping[str, Sequence[int]]
) -> tuple[list[list[int]], set[int], list[str]]:
    """Arrays with more columns than joints, if no other columns have the positions."""
    table, robot = columns.table, columns.robot
    groups = families(table.names, robot.joints, table.joints)
    if table.joints or "position" not in places and any(family.signal == "position" for family in groups):
        return [], set(), []
    arrays = _larger_arrays(table, robot)
    position = next((array for array in arrays if _signal_of_array(array) == "position"), [])
    if not position:
        return [], set(), []
    begin, notes = _begin_of_arm(columns, position, places)
    if begin is None:
        return [], set(), notes
    alike = [list(map(table.names.index, array)) for array in arrays if len(array) == len(position)]
    arm = [array[begin : begin + robot.dof] for array in alike]
    return arm, {k for array in alike for k in array}.difference(*arm), notes


def _larger_arrays(table: Table, robot: Robot) -> list[list[str]]:
    """Arrays of numbered columns of a known signal with more columns than joints."""
    arrays = {tuple(columns_of_array(table.names, name)): None for name in table.names}
    return [
        list(array)
        for array in arrays
        if len(array) > robot.dof and _signal_of_array(array) not in ("", "other")
    ]


def _signal_of_array(array: Sequence[str]) -> str:
    return signal_of(array_name(array))


def _begin_of_arm(
    columns: Columns, array: list[str], places: Mapping[str, Sequence[int]]
) -> tuple[int | None, list[str]]:
    """Index at which the arm's columns begin in an array of positions, and notes."""
    table, robot = columns.table, columns.robot
    if "position" in places:
        names = [table.names[place] for place in places["position"]]
        begin = array.index(names[0]) if names[0] in array else 0
        return (begin, []) if array[begin : begin + len(names)] == names else (None, [])
    values = table.values[:, [table.names.index(name) for name in array]]
    # A gripper before the joints is rare, and any joint may stay within 0 to 1 by chance.
    if len(array) != robot.dof + 1 or not _is_share(values[:, -1]) or _is_share(values[:, 0]):
        raise RecordingError(f"{columns.source}: {which_columns('position', array, robot)}")
    note = (
        f"{array_name(array)} has {len(array)} columns for {robot.dof} joints: {array[-1]} stays between 0 "
        "and full scale like a gripper, and is left out"
    )
    return 0, [note]


def _is_share(values: np.ndarray) -> bool:
    """Whether numbers (t,) stay within the scale of a gripper's opening."""
    known = values[np.isfinite(values)]
    if not len(known):
        return False
    return any(
        least < known.max() <= full * (1 + SHARE_NOISE) and known.min() >= -SHARE_NOISE * full
        for least, full in FULL
    )
