"""Telegrams of a KUKA controller as a program on the other end of RSI logged them: XML, in a file of text.

A telegram is `<Rob ...> ... </Rob>`. What stands between telegrams, such as the answers (`<Sen ...>`) or the
time of the host, is not read: the controller's clock IPOC counts.
"""

import gzip
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
from ..decompression_limits import require_gzip
from ..optional_signals import without_damaged
from ..recording import EFFORT, KnownPayload, Recording, Signal
from ..recording_checks import check, without_stale
from ..units import to_axes_of_robot
from .tables.columns import find_joints
from .tables.table import refused_as

ELEMENTS: dict[str, tuple[str, ...]] = {
    "position": ("AIPos", "EIPos"),
    "command": ("ASPos", "ESPos"),
    "current": ("MACur", "MECur"),
    "torque": ("GearTorque",),
}
"""Signal -> elements that hold it: of the arm's axes A1 to A6, and of external axes E1 to E6."""
WRAP = 2**32
"""The clock IPOC begins again there [ms]."""
LATE = 1000
"""By how much a telegram may be logged too late [ms]; a controller stops long before: more is another run."""
USUAL = 0.5
"""Share of the telegrams above which one has a value; a name that few have is damaged."""

TELEGRAM, END = re.compile(r"<Rob(?=[\s>])"), "</Rob>"
CLOCK = re.compile(r"<IPOC>\s*(-?\d{1,18})\s*</IPOC>")
ELEMENT = re.compile(rf"<({'|'.join(name for names in ELEMENTS.values() for name in names)})\s([^<>]*)>")
ATTRIBUTE = re.compile(r'(\w+)\s*=\s*"([^"]*)"')


class _Telegrams(NamedTuple):
    """The telegrams of a file.

    Attributes:
        clock: IPOC of each, shape (t,) [ms].
        values: "element.axis" -> values as they were sent, shape (t,); NaN where a telegram lacks it.
        damaged: Line of each telegram that cannot be read, the first line being 1.
    """

    clock: np.ndarray
    values: dict[str, np.ndarray]
    damaged: list[int]

    def column(self, signal: str, axis: str) -> np.ndarray | None:
        """Values of an axis, shape (t,); None where no telegram has them."""
        names = (f"{element}.{axis}" for element in ELEMENTS[signal])
        return next((self.values[name] for name in names if name in self.values), None)

    def axes(self) -> list[str]:
        """Axes with a position, in the order in which the controller sends them."""
        pairs = [name.split(".") for name in self.values]
        return [axis for element, axis in pairs if element in ELEMENTS["position"]]


def import_rsi_telegrams(
    source: Path,
    model: Model | None = None,
    joints: str | Sequence[str] | None = None,
    sign: Sequence[float] | None = None,
    zero: Sequence[float] | None = None,
    payload: KnownPayload | None = None,
) -> list[Recording]:
    """Import telegrams: positions in degrees, or mm where a joint slides; currents in A or torques in N m.

    Args:
        source: The file.
        model: The nominal robot.
        joints: Axis of each of the robot's joints, such as "A1", or a pattern; by default all in order.
        sign: 1 or -1 a joint, where the controller counts the other way than the robot's description.
        zero: Position in the robot's description where the controller shows zero [rad], one a joint.
        payload: What hung on the flange.

    Raises:
        RecordingError: The file does not hold a run of this robot; the message gives the reason.
    """
    if model is None:
        raise NotRecorded(f"{source}: telegrams do not name their robot; give the robot too (--robot FILE)")
    telegrams = _read(source)
    axes = _axes(source, telegrams, model.robot, joints)
    time, rows = _time(telegrams.clock)
    signals = {
        name: Signal(time, values[rows])
        for name in ELEMENTS
        if (values := _values(telegrams, name, axes, model.robot)) is not None
    }
    _require_efforts(source, telegrams, signals)
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
    """All telegrams of a file.

    Raises:
        NotAFile: It has none that can be read.
    """
    with refused_as(source, "telegrams of RSI"):
        if source.name.endswith(".gz"):
            require_gzip(source)
        opener = gzip.open if source.name.endswith(".gz") else open
        with opener(source, "rt", encoding="utf-8-sig", errors="replace") as file:
            text = file.read()
    clock: list[int] = []
    rows: list[dict[str, float]] = []
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
    counts = Counter(name for row in rows for name in row)
    names = [name for name, count in counts.items() if count > USUAL * len(rows)]
    values = {name: np.array([row.get(name, np.nan) for row in rows]) for name in names}
    return _Telegrams(np.array(clock), values, damaged)


def _telegram(text: str) -> tuple[int, dict[str, float]] | None:
    """Clock [ms] and values of one telegram; None for one that is damaged."""
    stamp = CLOCK.search(text)
    try:
        values = {
            f"{element[1]}.{name}": float(number)
            for element in ELEMENT.finditer(text)
            for name, number in ATTRIBUTE.findall(element[2])
        }
    except ValueError:
        return None
    return (int(stamp[1]), values) if stamp else None


def _axes(source: Path, telegrams: _Telegrams, robot: Robot, joints: str | Sequence[str] | None) -> list[str]:
    """Axis of each joint.

    Raises:
        NotRecorded: The telegrams have no positions of axes.
        WrongShape: The axes are more or fewer than the joints, and are not named.
    """
    there = telegrams.axes()
    if not there:
        raise NotRecorded(
            f"{source}: the telegrams have no positions of the axes (AIPos). Let the controller send them: "
            "DEF_AIPos in SEND of the configuration"
        )
    if joints is None and len(there) != robot.dof:
        own = [axis for axis in there if axis.startswith("A")]
        if len(own) != robot.dof:
            raise WrongShape(
                f"{source}: the telegrams have {len(there)} axes ({listed(there)}), {robot.name} has "
                f"{robot.dof} joints. Name the axis of each joint: --joints A1,A2,..."
            )
        there = own  # without a rail or a positioner
    return find_joints(robot, there, joints or there, f"{source}")


def _time(clock: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Time since the first telegram, shape (t,) [s], and which telegrams those are, shape (t,).

    A stamp that is repeated counts once, and a telegram that was overtaken by the next is put in its place.
    """
    step = np.diff(clock)
    whole = clock + WRAP * np.concatenate([[0], np.cumsum(step < -WRAP // 2)])
    step = np.diff(whole)
    if step.min() >= -LATE:
        whole, rows = np.unique(whole, return_index=True)
    else:  # which `check` refuses, with its advice
        rows = np.flatnonzero(np.concatenate([[True], step != 0]))
        whole = whole[rows]
    return (whole - whole[0]) * 1e-3, rows


def _values(telegrams: _Telegrams, signal: str, axes: Sequence[str], robot: Robot) -> np.ndarray | None:
    """A signal in the unit of `SIGNALS`, shape (t, n); None where no telegram has it of all axes."""
    columns = [column for axis in axes if (column := telegrams.column(signal, axis)) is not None]
    if len(columns) < len(axes):
        return None
    scale = np.where(np.array(robot.units("rad")) == "rad", np.pi / 180, 1e-3)
    return np.column_stack(columns) * (scale if signal in ("position", "command") else 1.0)


def _require_efforts(source: Path, telegrams: _Telegrams, signals: dict[str, Signal]) -> None:
    """Make sure that motor currents or torques were sent.

    Raises:
        NotRecorded: They were not.
    """
    if not any(name in signals for name in EFFORT):
        there = dict.fromkeys(name.partition(".")[0] for name in telegrams.values)
        raise NotRecorded(
            f"{source}: the telegrams have neither motor currents (MACur) nor torques (GearTorque) of all "
            f"axes; there: {listed(there)}. Let the controller send them: DEF_MACur in SEND of the "
            "configuration"
        )


def _damage(telegrams: _Telegrams) -> list[str]:
    """What could not be read, in a sentence; none where all could."""
    if not telegrams.damaged:
        return []
    total = len(telegrams.damaged) + len(telegrams.clock)
    return [
        f"{len(telegrams.damaged)} of {total} telegrams are damaged and left out, the first in line "
        f"{telegrams.damaged[0]}"
    ]
