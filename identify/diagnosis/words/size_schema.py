"""Schema of a size in diagnosis.json."""

from typing import Literal

from msgspec import Struct

from ...schema import Finite, JointNumber, SizeOrNull

Unit = Literal["N m", "N"]


class PointRow(Struct, frozen=True):
    """Torque of a finding where what it depends on has one value; `which` is empty on a curve."""

    at: Finite
    torque: Finite
    std: Finite
    which: str = ""


class SizeRow(Struct, frozen=True):
    """A size as a row of the table of parameters."""

    words: str
    torque: Finite
    std: Finite


class SizeTable(Struct, frozen=True, kw_only=True):
    """Torque of a finding on one joint, with the standard deviation of all its numbers together.

    Attributes:
        joint: On which it shows best.
        unit: Of the torque.
        sentence: What is known of it, in words.
        head: What the rows are.
        rows: The same as rows of a table.
        beside_rms: Root mean square of what it gives that no other parameter can take over, fitted anew.
        beside_std: Its standard deviation.
        over: What the torque depends on, in words; empty where it follows nothing that was recorded.
        over_unit: Its unit.
        braking: Whether torques are against the motion.
        change: Whether torques are less that of the first point.
        points: At the smallest, usual (root mean square) and largest; or lowest, middle (median), highest.
        curve: Over all that was recorded.
    """

    joint: JointNumber
    unit: Unit
    sentence: str
    head: str
    rows: tuple[SizeRow, ...]
    beside_rms: SizeOrNull
    beside_std: SizeOrNull
    over: str = ""
    over_unit: str = ""
    braking: bool = False
    change: bool = False
    points: tuple[PointRow, ...] = ()
    curve: tuple[PointRow, ...] = ()
