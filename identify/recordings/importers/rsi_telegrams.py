"""Telegrams of a KUKA controller, logged by the program at the other end of RSI: XML in a text file.

A telegram is `<Rob ...> ... </Rob>`. Text between telegrams, such as the answers (`<Sen ...>`) or the time of
the host, is ignored; the time is that of the controller's clock IPOC.
"""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arm.robot import Robot
from ...errors import NotAFile, NotRecorded, WrongShape, listed
from ...model import Model
from ..incomplete_samples import without_damaged, without_stale
from ..reading_limits import opened, require_gzip
from ..recording import EFFORT, KnownPayload, Recording, Signal
from ..recording_checks import check
from ..tables.columns import find_joints
from ..tables.table import refused_as
from ..units import to_axes_of_robot

ELEMENTS: dict[str, tuple[str, ...]] = {
    "position": ("AIPos", "EIPos"),
    "command": ("ASPos", "ESPos"),
    "current": ("MACur", "MECur"),
    "torque": ("GearTorque",),
}
"""Signal -> elements with its values: for the arm's axes A1 to A6, and for external axes E1 to E6."""
WRAP = 2**32
"""Time at which the clock IPOC restarts from zero [ms]."""
LATE = 1000
"""Maximum delay of a logged telegram [ms]; a controller stops much earlier, so a larger step is a new run."""
USUAL = 0.5
"""Minimum share of telegrams with a value; a rarer name is damaged."""

TELEGRAM, END = re.compile(r"<Rob(?=[\s>])"), "</Rob>"
CLOCK = re.compile(r"<IPOC>\s*(-?\d{1,18})\s*</IPOC>")
ELEMENT = re.compile(rf"<({'|'.join(name for names in ELEMENTS.values() for name in names)})\s([^<>]*)>")
ATTRIBUTE = re.compile(r'(\w+)\s*=\s*"([^"]*)"')


class _Telegrams(NamedTuple):
    """Telegrams of a file."""

    clock: np.ndarray  # IPOC of each telegram, shape (t,) [ms]
    # Signal -> axis -> values as sent, shape (t,); NaN if a telegram lacks them.
    values: dict[str, dict[str, np.ndarray]]
    elements: list[str]  # names of the elements in the telegrams
    damaged: list[int]  # line of each telegram that cannot be read, from 1


def import_rsi_telegrams(
    source: Path,
    model: Model,
    joints: str | Sequence[str] | None = None,
    sign: Sequence[float] | None = None,
    zero: Sequence[float] | None = None,
    payload: KnownPayload | None = None,
) -> list[Recording]:
    """Import telegrams: positions in degrees, or mm for prismatic joints; currents in A or torques in N m.

    Args:
        source: Path of the file.
        model: Nominal model.
        joints: Axis of each of the robot's joints, such as "A1", or a pattern; by default all in order.
        sign: 1 or -1 per joint: direction of the controller's axis relative to the robot's description.
        zero: Position in the robot's description at the controller's zero, one per joint [rad].
        payload: Payload on the flange.
    """
    telegrams = _read(source)
    axes = _axes(source, telegrams, model.robot, joints)
    time, rows = _time(telegrams.clock)
    signals = {
        name: Signal(time, values[rows])
        for name in ELEMENTS
        if (values := _values(telegrams, name, axes, model.robot)) is not None
    }
    if not any(name in signals for name in EFFORT):
        raise NotRecorded(
            f"{source}: the telegrams have neither motor currents (MACur) nor torques (GearTorque) of all "
            f"axes; present: {listed(telegrams.elements)}. Let the controller send them: DEF_MACur in SEND "
            "of the configuration"
        )
    recording = Recording(
        source.name.removesuffix(".gz").rsplit(".", 1)[0],
        model,
        signals,
        payload,
        settings={"source": source.name, "first_IPOC_ms": str(telegrams.clock[rows[0]])},
        warnings=tuple(_damage(telegrams)),
    )
    return [check(to_axes_of_robot(without_damaged(without_stale(recording)), sign, zero))]


def _read(source: Path) -> _Telegrams:
    with refused_as(source, "telegrams of RSI"):
        require_gzip(source)
        with opened(source, "rt", encoding="utf-8-sig", errors="replace") as file:
            text: str = file.read()
    clock: list[int] = []
    rows: list[dict[tuple[str, str], float]] = []
    damaged = []
    starts = [match.start() for match in TELEGRAM.finditer(text)]
    for start, stop in pairwise([*starts, len(text)]):
        end = text.find(END, start, stop)
        telegram = _telegram(text[start:end]) if end > 0 else None
        if telegram is None:
            damaged.append(text.count("\n", 0, start) + 1)
        else:
            clock.append(telegram[0])
            rows.append(telegram[1])
    if len(clock) < 2:
        raise NotAFile(
            f"{source}: {len(clock)} telegrams of RSI, <Rob ...> with IPOC and </Rob>, can be read, and "
            f"{len(damaged)} are damaged; a run has many"
        )
    counts = Counter(place for row in rows for place in row)
    places = [place for place, count in counts.items() if count > USUAL * len(rows)]
    values = {
        signal: {
            axis: np.array([row.get((element, axis), np.nan) for row in rows])
            for element, axis in places
            if element in elements
        }
        for signal, elements in ELEMENTS.items()
    }
    return _Telegrams(np.array(clock), values, list(dict.fromkeys(element for element, _ in places)), damaged)


def _telegram(text: str) -> tuple[int, dict[tuple[str, str], float]] | None:
    """Clock [ms] of a telegram, and its values by element and axis; None if it is damaged."""
    stamp = CLOCK.search(text)
    try:
        values = {
            (element[1], axis): float(number)
            for element in ELEMENT.finditer(text)
            for axis, number in ATTRIBUTE.findall(element[2])
        }
    except ValueError:
        return None
    return (int(stamp[1]), values) if stamp else None


def _axes(source: Path, telegrams: _Telegrams, robot: Robot, joints: str | Sequence[str] | None) -> list[str]:
    """Axis of each joint."""
    axes = list(telegrams.values["position"])
    if not axes:
        raise NotRecorded(
            f"{source}: the telegrams have no positions of the axes (AIPos). Let the controller send them: "
            "DEF_AIPos in SEND of the configuration"
        )
    if joints is None and len(axes) != robot.dof:
        arm_axes = [axis for axis in axes if axis.startswith("A")]
        if len(arm_axes) != robot.dof:
            raise WrongShape(
                f"{source}: the telegrams have {len(axes)} axes ({listed(axes)}), {robot.name} has "
                f"{robot.dof} joints. Name the axis of each joint: --joints A1,A2,..."
            )
        axes = arm_axes  # without a rail or a positioner
    return find_joints(robot, axes, joints or axes, f"{source}")


def _time(clock: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Time since the first telegram, shape (t,) [s], and the index of each telegram, shape (t,).

    A repeated stamp counts once, and telegrams that overtook each other are sorted.
    """
    step = np.diff(clock)
    unwrapped = clock + WRAP * np.concatenate([[0], np.cumsum(step < -WRAP // 2)])
    step = np.diff(unwrapped)
    if step.min() >= -LATE:
        unwrapped, rows = np.unique(unwrapped, return_index=True)
    else:  # `check` refuses this, with advice
        rows = np.flatnonzero(np.concatenate([[True], step != 0]))
        unwrapped = unwrapped[rows]
    return (unwrapped - unwrapped[0]) * 1e-3, rows


def _values(telegrams: _Telegrams, signal: str, axes: Sequence[str], robot: Robot) -> np.ndarray | None:
    """A signal in the unit of `SIGNALS`, shape (t, n); None if some axis lacks it."""
    columns = telegrams.values[signal]
    if not set(axes) <= set(columns):
        return None
    values = np.column_stack([columns[axis] for axis in axes])
    scale = np.where(np.array(robot.units("rad")) == "rad", np.pi / 180, 1e-3)
    return values * scale if signal in ("position", "command") else values


def _damage(telegrams: _Telegrams) -> list[str]:
    """Warning about telegrams that cannot be read; empty if there are none."""
    if not telegrams.damaged:
        return []
    total = len(telegrams.damaged) + len(telegrams.clock)
    return [
        f"{len(telegrams.damaged)} of {total} telegrams are damaged and left out, the first in line "
        f"{telegrams.damaged[0]}"
    ]
