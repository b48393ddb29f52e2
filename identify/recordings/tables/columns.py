"""Columns of each signal in a table: by usual names, by a preset, or as named on the command line."""

import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np

from ...arm.robot import Robot
from ...errors import RecordingError, WrongShape, listed
from ..incomplete_samples import NEEDED
from ..recording import EFFORT, SIGNALS
from ..time_order import ROUNDED
from .column_names import MEASURED, Family, families, words_of
from .name_index import (
    TIMES,
    UNITS_ONLY,
    WORDS,
    NameIndex,
    array_name,
    column_words,
    columns_of_array,
    which_columns,
)
from .table import Table

PREFIXES: dict[str, tuple[str, ...]] = {
    "position": ("q",),
    "velocity": ("dq", "qd"),
    "current": ("i",),
    "torque": ("tau",),
    "temperature": ("temp",),
    "link_position": ("ql",),
    "command": ("q_ref", "q_cmd", "action"),
    "command_velocity": ("dq_ref", "dq_cmd"),
}
"""Prefixes of the joint number in a column's name; the name of the signal is always valid too."""

RISING = 0.99
"""Minimum share of the steps in which a column that may be time increases."""
EFFORTS = frozenset(("effort", "efforts"))
"""Words for a torque or a current."""
EFFORT_MEANS = "torque"
"""Signal that an effort stands for by default."""

Names = str | Sequence[str]
"""Columns of a signal: one name per joint, a pattern for `_filled`, or the prefix of the joints' numbers."""


class Columns:
    """Columns of a table, looked up for one robot.

    `joints` are the names of the robot's joints in the table, in any form that `_names_in_log` accepts, and
    `effort` is the signal that a column of effort stands for.
    """

    def __init__(
        self,
        source: Path,
        table: Table,
        robot: Robot,
        joints: Names | None = None,
        effort: str = EFFORT_MEANS,
    ) -> None:
        self.source, self.table, self.robot = source, table, robot
        # Words for an effort belong to the signal that it stands for.
        self._words = {signal: words - EFFORTS for signal, words in WORDS.items()}
        self._words[effort] |= EFFORTS
        self.left_out: list[str] = []  # sentences about columns of text that were not read, and other facts
        self._index = NameIndex(table.names)
        self._joints, self._numbers = _names_in_log(robot, joints), list(range(1, robot.dof + 1))
        log_joints = table.joints
        if log_joints and (joints or len(log_joints) != robot.dof or set(self._joints) <= set(log_joints)):
            self._joints = find_joints(robot, log_joints, joints, str(source))
            self._numbers = [log_joints.index(name) + 1 for name in self._joints]

    def has(self, signal: str, names: Names, joints: int | None = None) -> bool:
        """Whether the table has columns with these names for "time", or for the first joints of a signal.

        By default, all joints need a column.
        """
        choices = [[str(names)]] if signal == "time" else self._choices(signal, {signal: names})[:joints]
        return all(any(map(self._index.exact, each)) for each in choices)

    def time(self, stated: Mapping[str, Names], where: str) -> int:
        """Index of the time column; raises `WrongShape` if there is none, or if it contains text."""
        times = [str(stated["time"])] if "time" in stated else list(TIMES)
        place = self._place(times, ("s",))
        if place < 0:
            usual = ", ".join(times[:3])
            steps = np.diff(self.table.values, axis=0)
            rising = len(steps) > 0 and bool(np.any(np.mean(steps > 0, axis=0) > RISING))
            name = 'name it by exidyn import --columns time=NAME (columns={"time": NAME}), or ' * rising
            raise WrongShape(
                f"{where}: no column of time ({usual}) among {column_words(self.table.names, 't')}; "
                f"{name}state the sampling rate: exidyn import --rate HZ (rate=HZ)"
            )
        return place

    def signals(
        self,
        stated: Mapping[str, Names],
        chosen: Mapping[str, Names],
        usual: Collection[str],
        where: str,
        words: bool = True,
    ) -> dict[str, list[int]]:
        """Signals in the table, and the index of the column of each joint; -1 for a joint without a column.

        `stated` are names of columns by signal or "time", of which those in `chosen` are of this file, whose
        robot may have more joints. Signals in `usual` are looked up by usual names, or with `words` by names
        that contain words for the signal. `where` is the name of the file in messages. Raises `WrongShape` if
        a column that is needed or was named is missing, is text, or belongs to another robot.
        """
        stated = {signal: expanded(names) for signal, names in stated.items()}
        block = self._block(stated.get("position", ()))
        known = {signal: self._choices(signal, stated) for signal in SIGNALS if signal in (*usual, *stated)}
        # A column that was named for one signal is never used for another by its usual name. The same holds
        # for columns of the same array, which may belong to another arm.
        named = {self._index.place(names) for signal in stated for names in known.get(signal, ())} - {-1}
        arrays = {
            name for place in named for name in columns_of_array(self.table.names, self.table.names[place])
        }
        reserved = {place for place, name in enumerate(self.table.names) if name in arrays}
        columns = {}
        for signal, choices in known.items():
            if signal not in NEEDED:
                choices = [
                    self._readable(signal, *each) for each in zip(self.robot.joints, choices, strict=True)
                ]
            if signal in stated:
                places = [self._place(names) for names in choices]
            else:
                quantities = set(self.robot.units(SIGNALS[signal]))
                places = [self._place(names, quantities, reserved) for names in choices]
                if max(places) < 0 and words:
                    places = self._by_words(signal, quantities, reserved) or places
            if signal in stated or signal == "position":
                self._require_all(signal, choices, places, where)
            names = stated.get(signal, "")
            # The columns of its array may have to be those that correspond to the positions.
            follows = isinstance(names, str) and (
                signal not in chosen or (block is not None and "{" not in names)
            )
            if max(places) >= 0 and follows and not self.table.joints:
                places = self._of_arm(signal, places, block)
            if max(places) >= 0:
                self._note_doubles(signal, places)
                columns[signal] = places
        return columns

    def _require_all(
        self, signal: str, choices: Sequence[Sequence[str]], places: Sequence[int], where: str
    ) -> None:
        """Refuse a signal that lacks the column of a joint."""
        missing = [names[0] for names, place in zip(choices, places, strict=True) if names and place < 0]
        if missing:
            raise WrongShape(
                f"{where}: no column {listed(missing)} for {signal}. Columns: "
                f"{column_words(self.table.names, missing[0])}; "
                f"name others by exidyn import --columns {signal}=NAME,NAME,... (columns={{...}})"
            )

    def _readable(self, signal: str, joint: str, names: Sequence[str]) -> list[str]:
        """Names of an optional column without those of columns of text, whose omission is noted."""
        text = [self.table.text[name] for name in names if name in self.table.text]
        self.left_out += [f"{signal} of {joint} is left out: {where}" for where in text]
        return [name for name in names if name not in self.table.text]

    def _place(
        self, names: Sequence[str], quantities: Collection[str] = (), reserved: Collection[int] = ()
    ) -> int:
        """Index of the first column with one of these names; -1 if there is none."""
        place = self._index.place(names, quantities, reserved)
        if place >= 0 and (name := self.table.names[place]) in self.table.text:
            raise WrongShape(self.table.text[name])
        return place

    def _by_words(
        self, signal: str, quantities: Collection[str], reserved: Collection[int]
    ) -> list[int] | None:
        """Indices of the only columns whose words mean a signal; of several, those that were measured."""
        alike = [
            family
            for family in families(self.table.names, self._joints, self.table.joints)
            if self._signal_of(family) == signal
            and not {*family.places} & {*reserved}
            and all(self._index.fits(place, quantities) for place in family.places)
            and (signal in NEEDED or not {*family.names} & {*self.table.text})
        ]
        if len(alike) > 1:
            alike = [family for family in alike if MEASURED.intersection(words_of(family.pattern))]
        return [self._place([name]) for name in alike[0].names] if len(alike) == 1 else None

    def _signal_of(self, family: Family) -> str:
        words = EFFORTS.intersection(words_of(family.pattern))
        means_effort = words and family.signal in EFFORT
        return next(s for s in EFFORT if words <= self._words[s]) if means_effort else family.signal

    def _choices(self, signal: str, stated: Mapping[str, Names]) -> list[list[str]]:
        """Names that the column of each joint may have."""
        names = stated.get(signal, "")
        if not isinstance(names, str):
            if len(names) != self.robot.dof:
                raise WrongShape(
                    f"columns (--columns): {signal} has {len(names)} columns, {self.robot.name} "
                    f"{self.robot.dof} joints"
                )
            return [[name] for name in names]
        patterns = self._patterns(signal, stated)
        if self.robot.dof == 1:  # an array of one joint has no number
            patterns += [pattern.removesuffix("{number}") for pattern in patterns]
        numbers = [self._numbers] * len(patterns)
        if signal not in stated and not self.table.joints:
            numbers = [self._numbers_of(pattern) for pattern in patterns]
        filled = [_filled(self._joints, *each) for each in zip(patterns, numbers, strict=True)]
        return [list(choices) for choices in zip(*filled, strict=True)]

    def _patterns(self, signal: str, stated: Mapping[str, Names]) -> list[str]:
        """Patterns of the names of a signal's columns: as stated, or else as usual."""
        if signal in stated:
            names = stated[signal]
            return [names if "{" in names else f"{names}{{number}}"] if isinstance(names, str) else []
        usual = [*PREFIXES[signal], signal]
        by_joint = [f"{word}_{{joint}}" for word in usual]
        by_joint += [f"{{joint}}{between}{word}" for word in (signal, *PREFIXES[signal]) for between in "_./"]
        arrays = [*usual, *sorted(self._words.get(signal, frozenset()) - UNITS_ONLY - {*usual})]
        return [f"{word}{{number}}" for word in arrays] + by_joint

    def _numbers_of(self, pattern: str) -> list[int]:
        """Numbers of the joints in names of a pattern, which may count from 0."""
        if "{number}" not in pattern:
            return self._numbers
        first, last = (pattern.replace("{number}", str(number)) for number in (0, self.robot.dof))
        from_zero = self._index.place([first]) >= 0 > self._index.place([last])
        return [number - from_zero for number in self._numbers]

    def _block(self, names: Names) -> tuple[int, int] | None:
        """First place of the positions in a larger array, and its size; None if there is no such array."""
        if isinstance(names, str) or len(names) != self.robot.dof:
            return None
        array = columns_of_array(self.table.names, names[0])
        begin = array.index(names[0]) if names[0] in array else 0
        consecutive = array[begin : begin + len(names)] == list(names)
        return (begin, len(array)) if consecutive and len(array) > len(names) else None

    def _of_arm(self, signal: str, places: list[int], block: tuple[int, int] | None) -> list[int]:
        """Columns of this arm in an array that may have more columns than the arm has joints."""
        names = [self.table.names[place] for place in places if place >= 0]
        array = columns_of_array(self.table.names, names[0])
        if len(array) <= self.robot.dof or not set(names) <= set(array):
            return places
        if block is not None and block[1] == len(array):
            return [self.table.names.index(name) for name in array[block[0] : block[0] + self.robot.dof]]
        if signal in NEEDED:
            raise WrongShape(f"{self.source}: {which_columns(signal, array, self.robot)}")
        self.left_out.append(
            f"{signal} is left out: {array_name(array)} has {len(array)} columns for {self.robot.dof} joints"
        )
        return [-1] * self.robot.dof

    def _note_doubles(self, signal: str, places: Sequence[int]) -> None:
        """Note columns whose name another column with other numbers has too."""
        names = self.table.names
        for name, place in ((names[place], place) for place in places if place >= 0):
            other = f"{name}.1"
            if other not in names:
                continue
            first, second = self.table.values[:, place], self.table.values[:, names.index(other)]
            if not np.array_equal(first, second, equal_nan=True):
                self.left_out.append(
                    f"{signal}: two columns are called {name}; the first is read, {other} is not"
                )


def own_time(table: Table) -> str:
    """Name of a column that is usually time and whose stamps have enough digits; "" if there is none."""
    place = NameIndex(table.names).place(TIMES, ("s",))
    steps = np.diff(table.values[:, place]) if place >= 0 else np.zeros(0)
    return table.names[place] if np.any(steps > 0) and np.mean(steps == 0) < ROUNDED else ""


def expanded(names: Names) -> Names:
    """Names of columns, in which `q1..6` is expanded to `q1` to `q6`."""
    if not isinstance(names, str) or (match := re.fullmatch(r"(.*?)(\d+)\.\.(\d+)(\D*)", names)) is None:
        return names
    numbers = range(int(match[2]), int(match[3]) + 1)
    return [f"{match[1]}{number}{match[4]}" for number in numbers]


def _filled(names: Sequence[str], pattern: str, numbers: Sequence[int]) -> list[str]:
    """A pattern filled in for each joint: {number} counts from 1, {index} from 0, {joint} is its name."""
    return [
        pattern.replace("{number}", str(number)).replace("{index}", str(number - 1)).replace("{joint}", name)
        for number, name in zip(numbers, names, strict=True)
    ]


def _names_in_log(robot: Robot, joints: Names | None) -> list[str]:
    """Name of each joint in a log: the robot's own, or as stated, one per joint or by a pattern."""
    if isinstance(joints, str) and "{" in joints:
        return _filled(robot.joints, joints, range(1, robot.dof + 1))
    names = [joints] if isinstance(joints, str) else list(joints or robot.joints)
    if len(names) != robot.dof:
        raise WrongShape(f"joints (--joints): {len(names)} names, but {robot.name} has {robot.dof} joints")
    return names


def find_joints(robot: Robot, log_joints: Sequence[str], joints: Names | None, where: str) -> list[str]:
    """Name of each joint in a log with `log_joints`; a prefix that all joints of an arm share is recognized.

    `joints` are the names there: one per joint, in the robot's order, or a pattern with {joint} or {number}.
    `where` is the name of the log in messages.
    """
    wanted = _names_in_log(robot, joints)
    missing = [name for name in wanted if name not in log_joints]
    if not missing:
        return wanted
    if joints is None:
        first = robot.joints[0]
        begins = [name.removesuffix(first) for name in sorted(log_joints) if name.endswith(first)]
        arms = {begin: [begin + joint for joint in robot.joints] for begin in begins}
        arms = {begin: arm for begin, arm in arms.items() if set(arm) <= set(log_joints)}
        if len(arms) == 1:
            return next(iter(arms.values()))
        if arms:
            choices = listed(f"--joints '{begin}{{joint}}'" for begin in arms)
            raise RecordingError(f"{where} has the joints of {len(arms)} arms; choose one by {choices}")
    raise RecordingError(
        f"{where} has no joint '{missing[0]}'. Valid joints: {listed(log_joints, missing[0])}; name the "
        "robot's joints there by --joints NAME,NAME,... or a pattern with {joint}"
    )
