"""The columns of a log under names by which a proposal reads them, and back to the names that they have.

A unit below the names is put behind the name, columns that a person named get the words of their signal, and
of an array with more columns than the arm has joints those of this arm are kept.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arm.robot import Robot
from ..errors import RecordingError
from ..recordings.importers.tables.array_blocks import array_name, which_columns
from ..recordings.importers.tables.columns import Columns, Names
from ..recordings.importers.tables.name_index import columns_of_array, numbered
from ..recordings.importers.tables.table import DATE, Table
from ..recordings.recording import EFFORT
from ..recordings.units import unit_named
from .column_names import STAMPS, families, signal_of, words_of
from .proposal import Proposal

WORDS = {
    "time": "time",
    "position": "position",
    "velocity": "velocity",
    "effort": "effort",
    "torque": "torque",
    "current": "current",
    "temperature": "temperature",
    "link_position": "ql",
    "command": "command",
    "command_velocity": "command velocity",
}
"""Signal -> words by which a proposal reads it."""
FULL = ((0.0, 1.0), (4 * np.pi, 100.0))
"""What the position of a gripper that is half open exceeds, and what an open one is called."""
SHARE_NOISE = 0.02
"""How far a share may be below 0 or above all of it, as encoders see it."""


class LogColumns(NamedTuple):
    """A log as a proposal reads it.

    Attributes:
        names: Names of the columns, c of them.
        values: Shape (t, c); torques and currents in N m and A where the file states another unit of them.
        original: Name of a column -> its name in the file.
        torque_factor: Name of a column of torque in another unit than N m -> N m per that unit.
        notes: What was decided, in sentences.
    """

    names: list[str]
    values: np.ndarray
    original: Mapping[str, str]
    torque_factor: Mapping[str, float]
    notes: tuple[str, ...] = ()

    def restored(self, proposal: Proposal) -> Proposal:
        """A proposal with the names of the file; gains are per unit as import reads it."""
        columns = {
            signal: tuple(self.original.get(name, name) for name in names)
            for signal, names in proposal.columns.items()
        }
        gains = proposal.gains
        if gains and "current" in proposal.columns:
            # Import does not apply a unit of torque to what is no torque.
            factors = [self.torque_factor.get(name, 1.0) for name in proposal.columns["current"]]
            gains = tuple(
                gain._replace(value=gain.value * factor) for gain, factor in zip(gains, factors, strict=True)
            )
        return replace(proposal, columns=columns, gains=gains, notes=(*self.notes, *proposal.notes))


def log_columns(columns: Columns, chosen: Mapping[str, Names]) -> LogColumns:
    """The columns of a log for an arm.

    Args:
        columns: Of the log, for the arm.
        chosen: "time", a signal or "effort" -> its columns, as `Columns` takes them.

    Raises:
        WrongShape: A chosen column is not there.
        RecordingError: An array has more columns than the arm has joints, and nothing says which are its.
    """
    table, robot = columns.table, columns.robot
    places = _chosen_places(columns, chosen, str(columns.source))
    arm, notes = _columns_of_arm(columns, places)
    shown = {k: _with_unit(table, k) for k in range(len(table.names))}
    for array in arm:
        for number, place in enumerate(array.kept):
            before, _, behind = numbered(table.names[place]) or (table.names[place], 0, "")
            shown[place] = f"{before}{number + 1}{behind}"
    for signal, chosen_places in places.items():
        for joint, place in enumerate(chosen_places):
            name = WORDS[signal] if signal == "time" else f"{robot.joints[joint]} {WORDS[signal]}"
            shown[place] = _with_unit(table, place, name)
    fixed = {place for chosen_places in places.values() for place in chosen_places}
    dropped = {place for array in arm for place in array.dropped} | _rivals(shown, fixed, places, robot)
    kept = [k for k in shown if k in fixed or k not in dropped]
    factor = {k: _effort_factor(table, k) for k in kept}
    return LogColumns(
        [shown[k] for k in kept],
        _from_zero(table.values[:, kept] * [factor[k][0] for k in kept], [shown[k] for k in kept]),
        {shown[k]: table.names[k] for k in kept},
        {shown[k]: value for k, (value, is_torque) in factor.items() if is_torque},
        tuple(notes),
    )


def _from_zero(values: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Values (t, c) of which stamps begin at zero: those in ns since 1970 exceed what is computed with."""
    for place, name in enumerate(names):
        known = np.isfinite(values[:, place])
        if STAMPS.intersection(words_of(name)) and known.any():
            values[:, place] -= values[known.argmax(), place]
    return values


def _with_unit(table: Table, place: int, name: str = "") -> str:
    """A column's name, or another one, with the unit behind it that the file states elsewhere."""
    own = table.names[place]
    unit = table.unit(own) if name else table.units.get(own, "")
    unit = "s" if unit == DATE else unit
    return f"{name or own} [{unit.strip('[]() ')}]" if unit else own if not name else name


def _effort_factor(table: Table, place: int) -> tuple[float, bool]:
    """SI per unit of a column that the file states to be of an effort, else 1; and whether of a torque."""
    entry = unit_named(table.unit(table.names[place])) or ("", 1.0, 0.0)
    is_torque = entry[0] in ("N m", "N")
    return (entry[1] if is_torque or entry[0] == "A" else 1.0), is_torque


def _chosen_places(columns: Columns, chosen: Mapping[str, Names], where: str) -> dict[str, list[int]]:
    """Columns of the time and of the signals that were chosen, by number."""
    signals = {name: names for name, names in chosen.items() if name != "time"}
    effort = {"torque": signals.pop("effort")} if "effort" in signals else {}
    places = {"time": [columns.time(chosen, where)]} if "time" in chosen else {}
    places |= columns.signals(signals, signals, False, where)
    if effort:
        places["effort"] = columns.signals(effort, effort, False, where)["torque"]
    return places


def _rivals(
    shown: Mapping[int, str], fixed: set[int], places: Mapping[str, Sequence[int]], robot: Robot
) -> set[int]:
    """Columns that are not chosen and whose names say that they are what was chosen."""
    signals = {*places, *(EFFORT if {"effort", *EFFORT} & set(places) else ())}
    others = [k for k in shown if k not in fixed]
    found = families([shown[k] for k in others], robot.joints)
    rivals = {others[place] for family in found if family.signal in signals for place in family.places}
    if "time" in places:
        rivals |= {k for k in others if STAMPS.intersection(words_of(shown[k]))}
    return rivals


class _Array(NamedTuple):
    """Columns of an array, by number: those of the arm, and the others."""

    kept: list[int]
    dropped: list[int]


def _columns_of_arm(columns: Columns, places: Mapping[str, Sequence[int]]) -> tuple[list[_Array], list[str]]:
    """Arrays with more columns than the arm has joints, where no others hold its positions; and notes."""
    table, robot = columns.table, columns.robot
    found = families(table.names, robot.joints, table.joints)
    if table.joints or "position" not in places and any(family.signal == "position" for family in found):
        return [], []
    arrays = _larger_arrays(table, robot)
    position = next((array for array in arrays if _signal_of_array(array) == "position"), [])
    if not position:
        return [], []
    numbers = {name: k for k, name in enumerate(table.names)}
    begin, notes = _begin_of_arm(columns, position, places)
    alike = [array for array in arrays if len(array) == len(position) and begin is not None]
    result = []
    for array in alike:
        kept = array[begin : (begin or 0) + robot.dof]
        result.append(_Array([numbers[n] for n in kept], [numbers[n] for n in array if n not in kept]))
    return result, notes


def _larger_arrays(table: Table, robot: Robot) -> list[list[str]]:
    """Numbered columns of a signal, of more than there are joints."""
    arrays = {tuple(columns_of_array(table.names, name)): None for name in table.names}
    return [
        list(one) for one in arrays if len(one) > robot.dof and _signal_of_array(one) not in ("", "other")
    ]


def _signal_of_array(array: Sequence[str]) -> str:
    return signal_of(array_name(array))


def _begin_of_arm(
    columns: Columns, array: list[str], places: Mapping[str, Sequence[int]]
) -> tuple[int | None, list[str]]:
    """Where in an array of positions the arm's begin, and what was decided.

    Raises:
        RecordingError: Nothing says it.
    """
    table, robot = columns.table, columns.robot
    if "position" in places:
        names = [table.names[place] for place in places["position"]]
        begin = array.index(names[0]) if names[0] in array else 0
        return (begin, []) if array[begin : begin + len(names)] == names else (None, [])
    values = table.values[:, [table.names.index(name) for name in array]]
    # Before the joints a gripper is rare; any joint may stay within 0 to 1 by chance.
    if len(array) != robot.dof + 1 or not _is_share(values[:, -1]) or _is_share(values[:, 0]):
        raise RecordingError(f"{columns.source}: {which_columns('position', array, robot)}")
    note = (
        f"{array_name(array)} has {len(array)} columns for {robot.dof} joints: {array[-1]} stays within "
        "0 and all of it, as a gripper does, and is left out"
    )
    return 0, [note]


def _is_share(values: np.ndarray) -> bool:
    """Whether numbers (t,) stay between 0 and all of what a gripper opens."""
    known = values[np.isfinite(values)]
    if not len(known):
        return False
    return any(
        least < known.max() <= full * (1 + SHARE_NOISE) and known.min() >= -SHARE_NOISE * full
        for least, full in FULL
    )
