"""Which columns of a table are which signal: by usual names, by a preset, or as named on the command line.

A recording is also written as one table, with the names by which `exidyn import` reads it again.
"""

import io
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ....arm.robot import Robot
from ....errors import RecordingError, WrongShape, listed
from ....notebook import optional
from ...optional_signals import NEEDED
from ...recording import SIGNALS, Recording
from ...servo_error import LAW
from .signal_words import UNITS_ONLY, WORDS
from .table import Table

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

Names = str | Sequence[str]
"""Columns of a signal: one a joint, a pattern for `_filled`, or what stands before the joints' numbers."""


class Columns:
    """The columns of a table, looked up for one robot.

    `joints` are what the robot's are called in the table, as `_names_in_log` takes it.

    Attributes:
        left_out: Optional columns that were not read since text is in them, a sentence each.
    """

    def __init__(self, source: Path, table: Table, robot: Robot, joints: Names | None = None) -> None:
        self.source, self.table, self.robot = source, table, robot
        self.left_out: list[str] = []
        self._joints, self._numbers = _names_in_log(robot, joints), list(range(1, robot.dof + 1))
        there = table.joints
        if there and (joints or len(there) != robot.dof or set(self._joints) <= set(there)):
            self._joints = find_joints(robot, there, joints, str(source))
            self._numbers = [there.index(name) + 1 for name in self._joints]

    def has(self, signal: str, names: Names, joints: int | None = None) -> bool:
        """Whether columns called so are there, of "time" or of a signal's first joints; of all by default."""
        choices = [[str(names)]] if signal == "time" else self._choices(signal, {signal: names})[:joints]
        return all(any(name in self.table.names for name in each) for each in choices)

    def time(self, given: Mapping[str, Names], where: str) -> int:
        """Number of the column of time.

        Raises:
            WrongShape: There is none, or text is in it.
        """
        times = [str(given["time"])] if "time" in given else list(TIMES)
        place = self._place(times)
        if place < 0:
            raise WrongShape(
                f"{where}: no column of time ({', '.join(times)}) among {listed(self.table.names, 't')}; "
                'name it by --columns time=NAME (columns={"time": NAME})'
            )
        return place

    def signals(
        self, given: Mapping[str, Names], chosen: Mapping[str, Names], usual: bool, where: str
    ) -> dict[str, list[int]]:
        """Each signal that is there, and its column of each joint; -1 for a joint without one.

        Args:
            given: Names by signal or "time".
            chosen: Those of them that were chosen for this file: it may be of a robot with more joints.
            usual: Whether other signals are looked up by usual names.
            where: What errors call the file.

        Raises:
            WrongShape: A column that is needed or was named is not there, is text, or is of another robot.
        """
        known = {signal: self._choices(signal, given) for signal in SIGNALS if usual or signal in given}
        # A column that was named for one signal is no other one, whatever its name is taken for by default.
        taken = {name for signal in given if signal in known for names in known[signal] for name in names}
        found = {}
        for signal, choices in known.items():
            if signal not in given:
                choices = [[name for name in names if name not in taken] for names in choices]
            if signal not in NEEDED:
                choices = [
                    self._readable(signal, *each) for each in zip(self.robot.joints, choices, strict=True)
                ]
            places = [self._place(names) for names in choices]
            if signal in given or signal == "position":
                missing = [
                    names[0] for names, place in zip(choices, places, strict=True) if names and place < 0
                ]
                if missing:
                    raise WrongShape(
                        f"{where}: no column {listed(missing)} for {signal}. Columns: "
                        f"{listed(self.table.names, missing[0])}; "
                        f"name others by --columns {signal}=NAME,NAME,... (columns={{...}})"
                    )
            if max(places) >= 0:
                if signal not in chosen and not self.table.joints:
                    self._refuse_more(signal, given)
                found[signal] = places
        return found

    def _readable(self, signal: str, joint: str, names: Sequence[str]) -> list[str]:
        """Those names of an optional column that is no text; of others it is noted that they are left out."""
        text = [self.table.text[name] for name in names if name in self.table.text]
        self.left_out += [f"{signal} of {joint} is left out: {where}" for where in text]
        return [name for name in names if name not in self.table.text]

    def _place(self, names: Sequence[str]) -> int:
        """Number of the first of some columns that is there; -1 if none is."""
        for name in names:
            if name in self.table.text:
                raise WrongShape(self.table.text[name])
            if name in self.table.names:
                return self.table.names.index(name)
        return -1

    def _choices(self, signal: str, given: Mapping[str, Names]) -> list[list[str]]:
        """Names that the column of each joint may have."""
        names = given.get(signal, "")
        if not isinstance(names, str):
            if len(names) != self.robot.dof:
                raise WrongShape(
                    f"columns (--columns): {signal} has {len(names)} columns, {self.robot.name} "
                    f"{self.robot.dof} joints"
                )
            return [[name] for name in names]
        patterns = _patterns(signal, given)
        if self.robot.dof == 1:  # an array of one joint has no number
            patterns += [one.removesuffix("{number}") for one in patterns]
        filled = [_filled(self._joints, one, self._numbers) for one in patterns]
        return [list(choices) for choices in zip(*filled, strict=True)]

    def _refuse_more(self, signal: str, given: Mapping[str, Names]) -> None:
        """Refuse a table with more joints than the robot: it is of another one."""
        beyond = range(self.robot.dof + 1, len(self.table.names) + 1)
        for pattern in _patterns(signal, given)[: len(PREFIXES[signal])]:
            numbered = _filled([""] * len(beyond), pattern, beyond) if "{" in pattern else []
            more = [column for column in numbered if column in self.table.names]
            if more:
                raise WrongShape(
                    f"{self.source}: column {more[-1]}, but {self.robot.name} has {self.robot.dof} joints: "
                    f"{', '.join(self.robot.joints)}"
                )


def _patterns(signal: str, given: Mapping[str, Names]) -> list[str]:
    """What columns of a signal may be called: as given, or else as usual."""
    if signal in given:
        names = given[signal]
        return [names if "{" in names else f"{names}{{number}}"] if isinstance(names, str) else []
    words = sorted(WORDS.get(signal, frozenset()) - UNITS_ONLY - {signal, *PREFIXES[signal]})
    usual = [*PREFIXES[signal], signal, *words]
    by_joint = [f"{one}_{{joint}}" for one in usual]
    by_joint += [
        f"{{joint}}{between}{one}" for one in (signal, *words, *PREFIXES[signal]) for between in "_./"
    ]
    return [f"{one}{{number}}" for one in usual] + by_joint


def _filled(names: Sequence[str], pattern: str, numbers: Sequence[int]) -> list[str]:
    """A pattern for each joint: {number} counts from 1, {index} from 0, {joint} is its name."""
    return [
        pattern.replace("{number}", str(number)).replace("{index}", str(number - 1)).replace("{joint}", name)
        for number, name in zip(numbers, names, strict=True)
    ]


def _names_in_log(robot: Robot, joints: Names | None) -> list[str]:
    """A log's name of each joint: the robot's own, or one a joint as given, or by a pattern for `_filled`."""
    if isinstance(joints, str) and "{" in joints:
        return _filled(robot.joints, joints, range(1, robot.dof + 1))
    names = [joints] if isinstance(joints, str) else list(joints or robot.joints)
    if len(names) != robot.dof:
        raise WrongShape(f"joints (--joints): {len(names)} names, but {robot.name} has {robot.dof} joints")
    return names


def find_joints(robot: Robot, there: Sequence[str], joints: Names | None, where: str) -> list[str]:
    """A log's name of each joint, out of all names in it; of one arm of several all may begin the same.

    `joints` are one name a joint, in the robot's order, or a pattern with {joint} or {number} in it.

    Raises:
        WrongShape: Not one name a joint.
        RecordingError: A joint is not there, or those of several arms are.
    """
    wanted = _names_in_log(robot, joints)
    missing = [name for name in wanted if name not in there]
    if not missing:
        return wanted
    if joints is None:
        first = robot.joints[0]
        begins = [name.removesuffix(first) for name in sorted(there) if name.endswith(first)]
        arms = {begin: [begin + joint for joint in robot.joints] for begin in begins}
        arms = {begin: arm for begin, arm in arms.items() if set(arm) <= set(there)}
        if len(arms) == 1:
            return next(iter(arms.values()))
        if arms:
            choices = listed(f"--joints '{begin}{{joint}}'" for begin in arms)
            raise RecordingError(f"{where} has the joints of {len(arms)} arms; choose one by {choices}")
    raise RecordingError(
        f"{where} has no joint '{missing[0]}'. Valid joints: {listed(there, missing[0])}; name the robot's "
        "joints there by --joints NAME,NAME,... or a pattern with {joint}"
    )


def columns_of(recording: Recording) -> dict[str, np.ndarray]:
    """Time `t` [s] and each signal of each joint, `q1`, `q2`, …, in the units of `SIGNALS`, shape (t,) each.

    A row for every time at which anything was measured; NaN for what was not measured then. Joints on which
    a signal was never measured have no column, and nor has an effort that was made of commands.
    """
    made = ("current",) if LAW in recording.settings else ()
    signals = {name: signal for name, signal in recording.signals.items() if name not in made}
    time = np.unique(np.concatenate([signal.time for signal in signals.values()]))
    found = {"t": time}
    for name, signal in signals.items():
        rows = np.searchsorted(time, signal.time)
        for joint, values in enumerate(signal.values.T):
            if not np.isnan(values).all():
                column = found[f"{PREFIXES[name][0]}{joint + 1}"] = np.full(len(time), np.nan)
                column[rows] = values
    return found


def _csv_bytes(recording: Recording) -> bytes:
    """Text with commas, a line of names, and every digit; empty where nothing was measured."""
    table = columns_of(recording)
    cells = np.column_stack([*table.values()]).tolist()
    rows = [",".join("" if np.isnan(cell) else repr(cell) for cell in row) for row in cells]
    return "\n".join([",".join(table), *rows, ""]).encode()


def _parquet_bytes(recording: Recording) -> bytes:
    """Columns of double precision; null where nothing was measured.

    Raises:
        MissingPackage: pyarrow is not installed.
    """
    arrow = optional("pyarrow", "a Parquet file", "parquet")
    parquet = optional("pyarrow.parquet", "a Parquet file", "parquet")
    file = io.BytesIO()
    table = {name: arrow.array(values, from_pandas=True) for name, values in columns_of(recording).items()}
    parquet.write_table(arrow.table(table), file)
    return file.getvalue()


TABLES: dict[str, Callable[[Recording], bytes]] = {"csv": _csv_bytes, "parquet": _parquet_bytes}
"""Format, and ending of such files -> how a recording is written."""


def left_out(recording: Recording) -> list[str]:
    """What a recording has and a table has not, a sentence each."""
    held = {
        "the robot and its nominal values: import needs --robot": True,
        f"the payload {recording.payload and recording.payload.name}": recording.payload,
        "the trajectory": recording.trajectory,
        "events, timing and outcome of the run": recording.events or recording.timing or recording.outcome,
        "the host's clock": recording.host_time is not None,
    }
    return [sentence for sentence, there in held.items() if there]
