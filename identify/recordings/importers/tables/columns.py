"""Which columns of a table are which signal: by usual names, by a preset, or as named on the command line."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from ....arm.robot import Robot
from ....errors import WrongShape, listed
from ...recording import SIGNALS
from ..joint_names import filled, find_joints, names_in_log
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
"""Columns of a signal: one a joint, a pattern for `filled`, or what stands before the joints' numbers."""


class Columns:
    """The columns of a table, looked up for one robot.

    Args:
        source: What errors call the file.
        table: With all columns.
        robot: Whose signals are looked for.
        joints: What its joints are called in the table, as `names_in_log` takes it.
        chosen: Names by signal or "time", as given with the file.
        preset: Names by signal or "time", as all files of a kind have them.
        by: Name of that preset.
        usual: Whether other signals are looked up by usual names; not where numbers count joints that
            the robot does not have.
    """

    def __init__(
        self,
        source: Path,
        table: Table,
        robot: Robot,
        joints: Names | None = None,
        chosen: Mapping[str, Names] = MappingProxyType({}),
        preset: Mapping[str, Names] = MappingProxyType({}),
        by: str = "",
        usual: bool = True,
    ) -> None:
        self.source, self.table, self.robot = source, table, robot
        self.where = f"{source} (preset {Path(by).name})" if by else str(source)
        self.chosen, self.given = chosen, {**preset, **chosen}
        self.usual = usual
        self.names, self.numbers = names_in_log(robot, joints), list(range(1, robot.dof + 1))
        there = table.joints
        if there and (joints or len(there) != robot.dof or set(self.names) <= set(there)):
            self.names = find_joints(robot, there, joints, str(source))
            self.numbers = [there.index(name) + 1 for name in self.names]

    def time(self) -> int:
        """Number of the column of time.

        Raises:
            WrongShape: There is none, or text is in it.
        """
        times = self._times()
        place = self._place(times)
        if place < 0:
            raise WrongShape(
                f"{self.where}: no column of time ({', '.join(times)}) among "
                f"{listed(self.table.names, 't')}; "
                'name it by --columns time=NAME (columns={"time": NAME})'
            )
        return place

    def signals(self) -> Iterator[tuple[str, list[int]]]:
        """Each signal that is there, and its column of each joint; -1 for a joint without one.

        Raises:
            WrongShape: A column that is needed or was named is not there, is text, or is of another robot.
        """
        known = {signal: self._choices(signal) for signal in SIGNALS if self.usual or signal in self.given}
        # A column that was named for one signal is no other one, whatever its name is taken for by default.
        taken = {
            name for signal in self.given if signal in known for names in known[signal] for name in names
        }
        for signal, choices in known.items():
            if signal not in self.given:
                choices = [[name for name in names if name not in taken] for names in choices]
            places = [self._place(names) for names in choices]
            if signal in self.given or signal == "position":
                missing = [names[0] for names, place in zip(choices, places, strict=True) if place < 0]
                if missing:
                    raise WrongShape(
                        f"{self.where}: no column {listed(missing)} for {signal}. Columns: "
                        f"{listed(self.table.names, missing[0])}; "
                        f"name others by --columns {signal}=NAME,NAME,... (columns={{...}})"
                    )
            if max(places) >= 0:
                self._refuse_more(signal)
                yield signal, places

    def has(self, signal: str, joints: int | None = None) -> bool:
        """Whether the columns of a signal, or of "time", are there; those of the first joints will do."""
        choices = [self._times()] if signal == "time" else self._choices(signal)[:joints]
        return all(any(name in self.table.names for name in names) for names in choices)

    def _times(self) -> list[str]:
        return [str(self.given["time"])] if "time" in self.given else list(TIMES)

    def _place(self, names: Sequence[str]) -> int:
        """Number of the first of some columns that is there; -1 if none is."""
        for name in names:
            if name in self.table.text:
                raise WrongShape(self.table.text[name])
            if name in self.table.names:
                return self.table.names.index(name)
        return -1

    def _choices(self, signal: str) -> list[list[str]]:
        """Names that the column of each joint may have."""
        names = self.given.get(signal, "")
        if not isinstance(names, str):
            if len(names) != self.robot.dof:
                raise WrongShape(
                    f"columns (--columns): {signal} has {len(names)} columns, {self.robot.name} "
                    f"{self.robot.dof} joints"
                )
            return [[name] for name in names]
        patterns = _patterns(signal, self.given)
        if self.robot.dof == 1:  # an array of one joint has no number
            patterns += [one.removesuffix("{number}") for one in patterns]
        filled_in = [filled(self.names, one, self.numbers) for one in patterns]
        return [list(choices) for choices in zip(*filled_in, strict=True)]

    def _refuse_more(self, signal: str) -> None:
        """A table with more joints than the robot is of another robot, unless its columns were chosen."""
        if signal in self.chosen or self.table.joints:
            return
        beyond = range(self.robot.dof + 1, len(self.table.names) + 1)
        for pattern in _patterns(signal, self.given)[: len(PREFIXES[signal])]:
            every = filled([""] * len(beyond), pattern, beyond) if "{" in pattern else []
            more = [column for column in every if column in self.table.names]
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
    usual = [*PREFIXES[signal], signal]
    by_joint = [f"{one}_{{joint}}" for one in usual] + [f"{{joint}}{between}{signal}" for between in "_./"]
    return [f"{one}{{number}}" for one in usual] + by_joint
