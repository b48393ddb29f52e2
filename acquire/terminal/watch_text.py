"""Readings as `exidyn watch` shows them: as a table, a line, or JSON; joints in degrees or millimeters."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TextIO

import numpy as np

from exidyn.drivers import Arm, Info
from exidyn.drivers.values import SIGNALS
from exidyn.identification.arm.robot import Robot
from exidyn.identification.result_file import to_table
from exidyn.identification.text_table import fixed, table
from exidyn.quoting import json_text, visible

from ..run.listener import Reading
from ..screen import beneath

SHOWN = {
    "current": ("current [A]", "A", 3),
    "torque": ("torque [N m]", "N m", 2),
    "temperature": ("[degC]", "degC", 0),
}
"""Signal -> head of its column, its unit, and digits after the decimal point."""
LATEST = 4
"""Number of events that the table shows."""
BEYOND, SILENT, CONTACT = "BEYOND", "silent", "CONTACT"


@dataclass(frozen=True)
class JointUnits:
    """Names, units and limits with which joint positions are printed."""

    joints: tuple[str, ...]  # joint names
    units: tuple[str, ...]  # printed unit of each joint's position
    scale: np.ndarray  # printed value per rad or m, shape (n,)
    lower: np.ndarray  # lower position limits, shape (n,) [rad] or [m]; minus infinity for none
    upper: np.ndarray  # upper position limits, shape (n,) [rad] or [m]; infinity for none

    @classmethod
    def of(cls, robot: Robot) -> "JointUnits":
        """Units and limits of a known robot."""
        units = tuple("deg" if revolute else "mm" for revolute in robot.revolute)
        scale = np.where(robot.revolute, np.degrees(1.0), 1e3)
        return cls(robot.joints, units, scale, robot.limits.position_lower, robot.limits.position_upper)

    @classmethod
    def unknown(cls, arm: Arm) -> "JointUnits":
        """Radians and the driver's limits, for an arm of which only the number of joints is known."""
        return cls(arm.joints, ("rad",) * arm.dof, np.ones(arm.dof), arm.position_lower, arm.position_upper)

    def beyond(self, position: np.ndarray) -> np.ndarray:
        """Which joints are beyond their limits, shape (n,); joints without a position count as within."""
        outside: np.ndarray = (position < self.lower) | (position > self.upper)
        return outside

    def text(self, position: np.ndarray, joint: int) -> str:
        """Position of a joint with its unit."""
        return f"{fixed(self.scale[joint] * position[joint], 2)} {self.units[joint]}"

    def range_text(self, joint: int) -> str:
        """Position limits of a joint without unit; empty if it has none."""
        ends = [self.scale[joint] * end[joint] for end in (self.lower, self.upper)]
        return f"{fixed(ends[0], 1)} to {fixed(ends[1], 1)}" if np.isfinite(ends).any() else ""


class External(NamedTuple):
    """External torques in a reading, at its highest score; without a threshold, the last ones."""

    torque: np.ndarray  # external torque of each joint, shape (n,) [N m]; NaN if unknown
    # Torque at which each joint makes an alarm, shape (n,) [N m]; NaN without a threshold.
    contact_from: np.ndarray
    force: np.ndarray  # force on the flange in the axes of the base, shape (3,) [N]
    over: tuple[int, ...]  # joints above their threshold; empty without contact
    contacts: int  # number of contacts so far, with the present one

    def columns(self) -> dict[str, np.ndarray]:
        """Columns of the table, by their heads."""
        return {"external [N m]": self.torque, "contact from": self.contact_from}

    def numbers(self) -> str:
        """The external torques in a line."""
        return f"external torque {_several(self.torque, 2)} N m"

    def words(self, joints: Sequence[str]) -> list[str]:
        """Joints above their threshold, flange force, and the number of contacts."""
        words = [f"{CONTACT}: {', '.join(joints[joint] for joint in self.over)}"] * bool(self.over)
        words += [f"force on the flange {_several(self.force, 1)} N in the axes of the base"]
        if np.all(np.isfinite(self.torque)) and np.all(np.isnan(self.contact_from)):
            words += ["no threshold of contact: state runs without contact with --free"]
        return words + [f"contacts so far: {self.contacts}"] * bool(self.contacts)

    def table(self, joints: Sequence[str]) -> dict[str, Any]:
        """The external torques for JSON."""
        return {
            "external_torque": self.torque,
            "contact_from": self.contact_from,
            "force": self.force,
            "contact": [joints[joint] for joint in self.over],
            "contacts": self.contacts,
        }


def table_lines(
    reading: Reading,
    units: JointUnits,
    info: Info,
    seconds: float,
    events: Sequence[str],
    external: External | None = None,
) -> list[str]:
    """Lines of the table that is redrawn for each reading, seconds [s] after the first, with all events."""
    signals = [name for name in SHOWN if name in info.signals]
    columns = {} if external is None else external.columns()
    head = ["joint", "position", "", "limits", *(SHOWN[name][0] for name in signals), *columns, "state"]
    rows = [_row(reading, units, signals, columns, joint) for joint in range(len(units.joints))]
    lines = table(head, rows, left=(0, 2, len(head) - 1))
    if external is not None:
        lines += ["", *external.words(units.joints)]
    lines += ["", f"{seconds:.1f} s; {reading.cycles} samples since the last; Ctrl-C ends it"]
    if reading.fault:
        lines.append(f"fault: {reading.fault}")
    return lines + [f"message: {text}" for text in events[-LATEST:]]


def _row(
    reading: Reading, units: JointUnits, signals: Sequence[str], columns: Mapping[str, np.ndarray], joint: int
) -> list[str]:
    state = reading.states[joint] if np.isfinite(reading.position[joint]) else SILENT
    beyond = f"{BEYOND} " if units.beyond(reading.position)[joint] else ""
    return [
        units.joints[joint],
        _digits(units.scale[joint] * reading.position[joint], 2),
        units.units[joint],
        beyond + (units.range_text(joint) or "-"),
        *(_digits(getattr(reading, name)[joint], SHOWN[name][2]) for name in signals),
        *(_digits(values[joint], 2) for values in columns.values()),
        state or "-",
    ]


def line(
    reading: Reading, units: JointUnits, info: Info, seconds: float, external: External | None = None
) -> str:
    """A reading as one line, for a file or another program."""
    shown = [units.scale[k] * reading.position[k] for k in range(len(units.joints))]
    unit = units.units[0] if len(set(units.units)) == 1 else "/".join(units.units)
    parts = [f"{seconds:.1f} s", f"position {_several(shown, 2)} {unit}"]
    for name, (_, unit, places) in SHOWN.items():
        if name in info.signals:
            parts.append(f"{name} {_several(getattr(reading, name), places)} {unit}")
    parts.append(_states(reading.states))
    beyond = [units.joints[k] for k in np.flatnonzero(units.beyond(reading.position))]
    silent = [units.joints[k] for k in np.flatnonzero(np.isnan(reading.position))]
    parts += [f"{BEYOND} limits: {', '.join(beyond)}"] * bool(beyond)
    parts += [f"{SILENT}: {', '.join(silent)}"] * bool(silent)
    if external is not None:
        parts += [external.numbers(), *external.words(units.joints)]
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


def json_line(reading: Reading, units: JointUnits, seconds: float, external: External | None = None) -> str:
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
    if external is not None:
        content |= external.table(units.joints)
    return json_text(to_table(content), indent=None)


class Redraw:
    """Draws lines over the lines that it drew before."""

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
