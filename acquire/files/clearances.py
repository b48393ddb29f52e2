"""Clearances of a motion: from the arm itself, from obstacles, and from the bounds of regions."""

from collections.abc import Callable
from pathlib import Path

from exidyn.identification.arm.robot import Robot
from exidyn.identification.errors import RobotError
from exidyn.identification.robot_files.geometry import read_geometry
from exidyn.identification.robot_files.robot_file import AROUND
from exidyn.identification.robot_files.surroundings import Obstacle, read_surroundings, with_obstacles
from exidyn.identification.robot_files.toml_fields import check_keys, parse_toml, read_text
from exidyn.trajectories.clearances.clearance import Clearance
from exidyn.trajectories.clearances.collision import REQUIRED, Collision
from exidyn.trajectories.clearances.region import read_regions


def read_clearances(
    source: str | Path,
    robot: Robot,
    *,
    cell: Path | None = None,
    collision: bool = True,
    distance: float = REQUIRED,
    say: Callable[[str], None] = lambda _: None,
) -> tuple[Clearance, ...]:
    """Clearances of the arm of a robot.toml, URDF, MJCF or built-in name.

    Args:
        source: File or built-in name of the robot.
        robot: The robot that was read from the source.
        cell: Another file with `[[obstacle]]` and `[[region]]` rows.
        collision: Whether to check the arm's geometry and obstacles.
        distance: Smallest distance between bodies, and between bodies and obstacles [m].
        say: Function that takes sentences on what is not checked.

    Raises:
        RobotError: If a file is wrong, or there are obstacles but the robot has no collision geometry.
    """
    surroundings = read_surroundings(sources_of(source, cell))
    regions = read_regions(list(surroundings.regions), robot) if surroundings.regions else []
    if not collision:
        return tuple(regions)
    geometry = read_geometry(source)
    if geometry is None:
        _refuse(source, surroundings.obstacles)
        say("the robot has no collision geometry: self-collision is not checked")
        return tuple(regions)
    bodies = Collision.of(robot, with_obstacles(geometry, surroundings.obstacles), distance)
    for sentence in _unchecked_pairs(bodies, surroundings.obstacles):
        say(sentence)
    return (bodies, *regions)


def sources_of(source: str | Path, cell: Path | None) -> list[str | Path]:
    """Files that may describe obstacles and regions around an arm.

    Raises:
        RobotError: If the cell file has no such rows, or has other keys.
    """
    if cell is None:
        return [source]
    table = parse_toml(read_text(cell), str(cell))
    check_keys(table, AROUND, str(cell))
    if not table:
        raise RobotError(f"{cell} has neither [[obstacle]] nor [[region]] rows")
    return [source, cell]


def _refuse(source: str | Path, obstacles: tuple[Obstacle, ...]) -> None:
    if obstacles:
        raise RobotError(
            f"obstacle '{obstacles[0].name}' cannot be checked: {source} has no collision geometry. Use a "
            "URDF with <collision>, an MJCF, or a [[region]] for the flange; --no-collision plans without "
            "obstacles"
        )


def _unchecked_pairs(bodies: Collision, obstacles: tuple[Obstacle, ...]) -> list[str]:
    """Sentences on the pairs with obstacles that are not checked, and why."""
    names = {obstacle.name for obstacle in obstacles}
    return [
        f"{pair.first} to {pair.second} is not checked: {pair.reason}"
        for pair in bodies.excluded
        if {pair.first, pair.second} & names
    ]
