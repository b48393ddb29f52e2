"""Arrays with more columns than an arm has joints, such as those of two arms: which columns are this arm's."""

from collections.abc import Sequence

from ....arm.robot import Robot
from .name_index import numbered


def which_columns(signal: str, array: Sequence[str], robot: Robot) -> str:
    """What is asked about an array with more columns than an arm has joints, with options that answer it."""
    n, m = robot.dof, len(array)
    half = m // 2
    numbers = [int(parts[1]) for name in array if (parts := numbered(name))]
    other = half if m % 2 == 0 and half >= n else m - n
    words = f"{numbers[0]} to {numbers[n - 1]}", f"{numbers[other]} to {numbers[other + n - 1]}"
    return (
        f"{array_name(array)} has {m} columns for {n} joints ({named_joints(robot)}): which? For example "
        f"--columns {signal}={','.join(array[:n])} ({words[0]}), or {words[1]} in their place"
    )


def named_joints(robot: Robot, most: int = 3) -> str:
    """Names of the joints; of many the first and the last."""
    joints = robot.joints
    return ", ".join(joints) if len(joints) <= most else f"{joints[0]} to {joints[-1]}"


def array_name(array: Sequence[str]) -> str:
    """What the columns of an array have in common."""
    parts = numbered(array[0])
    return "".join(parts[::2]) if parts else array[0]
