"""Readings as `exidyn watch` shows them: as a table, a line, or JSON."""

import shutil
from collections.abc import Sequence
from typing import Any, NamedTuple, TextIO

import numpy as np

from exidyn.drivers import Info
from exidyn.drivers.values import SIGNALS
from exidyn.identification.text_table import fixed, table
from exidyn.quoting import json_text, visible

from ..run.listener import Reading
from ..screen import beneath
from .joint_units import JointUnits, one_unit
from .json_output import plain

SHOWN = ("current", "torque", "temperature")
UNITS = {"current": "A", "torque": "N m", "temperature": "degC"}
HEADS = {"current": "current [A]", "torque": "torque [N m]", "temperature": "[degC]"}
DIGITS = {"current": 3, "torque": 2, "temperature": 0}
LATEST = 4
"""Number of events that the table shows."""
BEYOND, SILENT, ALARM, CONTACT = "BEYOND", "silent", "ALARM", "CONTACT"


class Residual(NamedTuple):
    """Residual torque over the last section of the motion, with the parameters from the arm's check runs.

    Attributes:
        value: Root mean square of each joint, shape (n,) [N m]; NaN if unknown.
        alarm: Alarm threshold, shape (n,) [N m].
        seconds: Duration of a section [s].
        why: Why there is no residual; empty otherwise.
    """

    value: np.ndarray
    alarm: np.ndarray
    seconds: float
    why: str

    @property
    def over(self) -> list[int]:
        """Joints with an alarm."""
        return [int(joint) for joint in np.flatnonzero(self.value > self.alarm)]


class External(NamedTuple):
    """External torques in a reading, at its highest score; without a threshold, the last ones.

    Attributes:
        torque: External torque of each joint, shape (n,) [N m]; NaN if unknown.
        contact_from: Torque at which each joint makes an alarm, shape (n,) [N m]; NaN without a threshold.
        force: Force on the flange in the axes of the base, shape (3,) [N].
        over: Joints above their threshold; empty without contact.
        contacts: Number of contacts so far, with the present one.
    """

    torque: np.ndarray
    contact_from: np.ndarray
    force: np.ndarray
    over: tuple[int, ...]
    contacts: int


def table_lines(
    reading: Reading,
    units: JointUnits,
    info: Info,
    seconds: float,
    events: Sequence[str],
    residual: Residual | None = None,
    external: External | None = None,
) -> list[str]:
    """Lines of the table that is redrawn for each reading.

    Args:
        reading: Latest reading.
        units: Units of the joints.
        info: Metadata of the driver.
        seconds: Time since the first reading [s].
        events: Messages so far.
        residual: Residual of the last section; None if it was not requested.
        external: External torques; None if they were not requested.
    """
    signals = [name for name in SHOWN if name in info.signals]
    head = ["joint", "position", "", "limits", *(HEADS[n] for n in signals), "state"]
    rows = [_row(reading, units, signals, joint) for joint in range(len(units.joints))]
    if residual is not None:
        head[-1:-1] = ["residual [N m]", "alarm from"]
        for joint, row in enumerate(rows):
            row[-1:-1] = [_digits(residual.value[joint], 2), _digits(residual.alarm[joint], 2)]
    if external is not None:
        head[-1:-1] = ["external [N m]", "contact from"]
        for joint, row in enumerate(rows):
            row[-1:-1] = [_digits(external.torque[joint], 2), _digits(external.contact_from[joint], 2)]
    lines = table(head, rows, left=(0, 2, len(head) - 1))
    lines += [""] * bool(residual) + _residual_words(residual, units)
    lines += [""] * bool(external) + _external_words(external, units)
    lines += ["", f"{seconds:.1f} s; {reading.cycles} samples since the last; Ctrl-C ends it"]
    if reading.fault:
        lines.append(f"fault: {reading.fault}")
    return lines + [f"message: {text}" for text in events[-LATEST:]]


def _row(reading: Reading, units: JointUnits, signals: Sequence[str], joint: int) -> list[str]:
    known = bool(np.isfinite(reading.position[joint]))
    position = _digits(units.scale[joint] * reading.position[joint], 2)
    state = reading.states[joint] if known else SILENT
    return [
        units.joints[joint],
        position,
        units.units[joint],
        _limits(reading, units, joint),
        *(_number(reading, name, joint) for name in signals),
        state or "-",
    ]


def _limits(reading: Reading, units: JointUnits, joint: int) -> str:
    beyond = f"{BEYOND} " if units.beyond(reading.position)[joint] else ""
    return beyond + (units.range_text(joint) or "-")


def _number(reading: Reading, name: str, joint: int) -> str:
    value = float(getattr(reading, name)[joint])
    return _digits(value, DIGITS[name])


def _residual_words(residual: Residual | None, units: JointUnits) -> list[str]:
    """Joints with an alarm, or why there is no residual; empty if no joint exceeds its threshold."""
    if residual is None:
        return []
    over = ", ".join(units.joints[joint] for joint in residual.over)
    words = [f"{ALARM}: residual of {over} over {residual.seconds:.0f} s"] * bool(over)
    return words + [f"residual: {residual.why}"] * bool(residual.why)


def _external_words(external: External | None, units: JointUnits) -> list[str]:
    """Flange force, and the joints above their threshold; empty if external torques were not requested."""
    if external is None:
        return []
    over = ", ".join(units.joints[joint] for joint in external.over)
    words = [f"{CONTACT}: {over}"] * bool(over)
    words += [f"force on the flange {_several(external.force, 1)} N in the axes of the base"]
    if np.all(np.isfinite(external.torque)) and np.all(np.isnan(external.contact_from)):
        words += ["no threshold of contact: state runs without contact with --free"]
    return words + [f"contacts so far: {external.contacts}"] * bool(external.contacts)


def line(
    reading: Reading,
    units: JointUnits,
    info: Info,
    seconds: float,
    residual: Residual | None = None,
    external: External | None = None,
) -> str:
    """A reading as one line, for a file or another program."""
    shown = [units.scale[k] * reading.position[k] for k in range(len(units.joints))]
    parts = [f"{seconds:.1f} s", f"position {_several(shown, 2)} {one_unit(units.units)}"]
    for name in SHOWN:
        if name in info.signals:
            parts.append(f"{name} {_several(getattr(reading, name), DIGITS[name])} {UNITS[name]}")
    parts.append(_states(reading.states))
    beyond = [units.joints[k] for k in np.flatnonzero(units.beyond(reading.position))]
    silent = [units.joints[k] for k in np.flatnonzero(np.isnan(reading.position))]
    parts += [f"{BEYOND} limits: {', '.join(beyond)}"] * bool(beyond)
    parts += [f"{SILENT}: {', '.join(silent)}"] * bool(silent)
    if residual is not None and not residual.why:
        value, alarm = _several(residual.value, 2), _several(residual.alarm, 2)
        parts.append(f"residual {value} N m, alarm from {alarm}")
    parts += _residual_words(residual, units)
    if external is not None:
        parts.append(f"external torque {_several(external.torque, 2)} N m")
    parts += _external_words(external, units)
    parts += [f"fault: {reading.fault}"] * bool(reading.fault)
    return "; ".join(part for part in [*parts, *(f"message: {text}" for text in reading.events)] if part)


def _several(values: Sequence[float] | np.ndarray, digits: int) -> str:
    return " ".join(_digits(value, digits) for value in values)


def _digits(value: float, digits: int) -> str:
    """A number, or a dash for NaN; values that round to zero have no sign, which would flicker."""
    return fixed(value, digits) if np.isfinite(value) else "-"


def _states(states: Sequence[str]) -> str:
    if not any(states):
        return ""
    return f"all {states[0]}" if len(set(states)) == 1 else " / ".join(state or "-" for state in states)


def json_line(
    reading: Reading,
    units: JointUnits,
    seconds: float,
    residual: Residual | None = None,
    external: External | None = None,
) -> str:
    """A reading as one line of JSON, in SI units; unknown values are null."""
    content: dict[str, Any] = {
        "exidyn_reading": 1,
        "time": seconds,
        "host_time_ns": reading.host_time,
        "joints": list(units.joints),
        **{name: getattr(reading, name) for name in SIGNALS},
        "beyond_limits": [units.joints[k] for k in np.flatnonzero(units.beyond(reading.position))],
        "states": list(reading.states),
        "cycles": reading.cycles,
        "silent": reading.silent,
        "events": list(reading.events),
        "fault": reading.fault,
    }
    if residual is not None:
        content |= {
            "residual": residual.value,
            "residual_alarm_from": residual.alarm,
            "residual_alarms": [units.joints[joint] for joint in residual.over],
        }
    if external is not None:
        content |= {
            "external_torque": external.torque,
            "contact_from": external.contact_from,
            "force": external.force,
            "contact": [units.joints[joint] for joint in external.over],
            "contacts": external.contacts,
        }
    return json_text(plain(content), indent=None)


class Redraw:
    """Draws lines over the lines that it drew before.

    Args:
        terminal: Stream to draw on.
    """

    def __init__(self, terminal: TextIO) -> None:
        self._terminal, self._drawn = terminal, 0

    def draw(self, lines: Sequence[str]) -> None:
        """Replace the last drawn lines; what does not fit into the terminal is cut off."""
        size = shutil.get_terminal_size()
        # A line that wraps, or scrolls away, could not be drawn over.
        shown = [line[: size.columns - 1] for line in lines[: size.lines - 1]]
        back = f"\x1b[{self._drawn}A" if self._drawn else ""
        beneath(self._terminal).write(back + "\x1b[J" + "".join(f"{visible(line)}\n" for line in shown))
        self._terminal.flush()
        self._drawn = len(shown)
