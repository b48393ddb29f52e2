"""Clearances of a motion: from the arm itself, from obstacles, and from the bounds of regions."""

from argparse import Namespace
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

from ..arguments.command import print_warning


def read_clearances(args: Namespace, robot: Robot, distance: float = REQUIRED) -> tuple[Clearance, ...]:
    """Clearances of the arm of `args.robot` by the options of a command: --cell and --no-collision.

    Bodies keep a distance [m] from each other and from obstacles; with one above 0, warnings are printed on
    what is not checked.

    Raises:
        RobotError: If a file is wrong, or there are obstacles but the robot has no collision geometry.
    """
    surroundings = read_surroundings(sources_of(args.robot, args.cell))
    regions = read_regions(list(surroundings.regions), robot) if surroundings.regions else []
    if args.no_collision:
        return tuple(regions)
    if (geometry := read_geometry(args.robot)) is None:
        _refuse(args.robot, surroundings.obstacles)
        unchecked = ["the robot has no collision geometry: self-collision is not checked"]
        clearances = list[Clearance](regions)
    else:
        bodies = Collision.of(robot, with_obstacles(geometry, surroundings.obstacles), distance)
        unchecked, clearances = _unchecked_pairs(bodies, surroundings.obstacles), [bodies, *regions]
    for sentence in unchecked if distance else ():
        print_warning(sentence)
    return tuple(clearances)


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
