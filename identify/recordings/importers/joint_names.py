"""What the joints of a robot are called in a log."""

from collections.abc import Sequence

from ...arm.robot import Robot
from ...errors import RecordingError, WrongShape, listed


def names_in_log(robot: Robot, joints: str | Sequence[str] | None = None) -> list[str]:
    """A log's name of each joint: the robot's own, or as given.

    Args:
        robot: Whose joints are looked for.
        joints: One name a joint, in the robot's order; or a pattern with {joint} or {number} in it.

    Raises:
        WrongShape: Not one name a joint.
    """
    if isinstance(joints, str) and "{" in joints:
        return filled(robot.joints, joints, range(1, robot.dof + 1))
    names = [joints] if isinstance(joints, str) else list(joints or robot.joints)
    if len(names) != robot.dof:
        raise WrongShape(f"joints (--joints): {len(names)} names, but {robot.name} has {robot.dof} joints")
    return names


def filled(names: Sequence[str], pattern: str, numbers: Sequence[int]) -> list[str]:
    """A pattern for each joint: {number} counts from 1, {index} from 0, {joint} is its name."""
    return [
        pattern.replace("{number}", str(number)).replace("{index}", str(number - 1)).replace("{joint}", name)
        for number, name in zip(numbers, names, strict=True)
    ]


def find_joints(
    robot: Robot, there: Sequence[str], joints: str | Sequence[str] | None, where: str
) -> list[str]:
    """A log's name of each joint, out of all names in it; of one arm of several all may begin the same.

    Args:
        robot: Whose joints are looked for.
        there: Names in the log.
        joints: As in `names_in_log`.
        where: What errors call the place where the names are.

    Raises:
        RecordingError: A joint is not there, or those of several arms are.
    """
    wanted = names_in_log(robot, joints)
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
