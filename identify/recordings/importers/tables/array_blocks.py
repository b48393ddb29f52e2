"""Arrays with more columns than an arm has joints, such as those of two arms."""

from collections.abc import Sequence

from ....arm.robot import Robot
from .name_index import numbered


def which_columns(signal: str, array: Sequence[str], robot: Robot) -> str:
    """Question about an array with more columns than an arm has joints, with options that answer it."""
    n, m = robot.dof, len(array)
    half = m // 2
    begins = 0, half if m % 2 == 0 and half >= n else m - n
    blocks = [array[begin : begin + n] for begin in begins]
    words = [
        " to ".join(str(end[1]) for name in (block[0], block[-1]) if (end := numbered(name)))
        for block in blocks
    ]
    first, second = map(_range, blocks)
    return (
        f"{array_name(array)} has {m} columns for {n} joints ({named_joints(robot)}): which? For example "
        f"{words[0]}, or {words[1]}: --columns {signal}={first}, or {signal}={second}"
    )


def _range(array: Sequence[str]) -> str:
    """Consecutive columns as a value of `--columns`: q1..6; names without numbers are listed."""
    first, last = numbered(array[0]), numbered(array[-1])
    if first is None or last is None or last[1] - first[1] != len(array) - 1 or len(array) == 1:
        return ",".join(array)
    return f"{first[0]}{first[1]}..{last[1]}{first[2]}"


def named_joints(robot: Robot, most: int = 3) -> str:
    """Names of the joints; only the first and the last if there are many."""
    joints = robot.joints
    return ", ".join(joints) if len(joints) <= most else f"{joints[0]} to {joints[-1]}"


def array_name(array: Sequence[str]) -> str:
    """Common part of the names of an array's columns."""
    parts = numbered(array[0])
    return (parts[0].rstrip(" _[(.-") + parts[2].lstrip(")] ")) if parts else array[0]
