"""What a motion must keep clear of: the arm itself, obstacles, and the bounds of regions."""

from collections.abc import Callable, Iterable
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
    packages: Iterable[Path] = (),
    say: Callable[[str], None] = lambda _: None,
) -> tuple[Clearance, ...]:
    """Clearances of the arm of a robot.toml, URDF, MJCF or built-in name.

    Args:
        source: Where the robot is from.
        robot: As read from there.
        cell: Another file with `[[obstacle]]` and `[[region]]` rows.
        collision: Whether to look at the arm's geometry and at obstacles.
        distance: What bodies keep from each other and from obstacles [m].
        packages: Folders of meshes.
        say: Takes sentences on what is kept clear of what.

    Raises:
        RobotError: A file is wrong, or there are obstacles and no geometry of the arm to keep clear of them.
    """
    around = read_surroundings(sources_of(source, cell))
    regions = read_regions(list(around.regions), robot) if around.regions else []
    if not collision:
        return tuple(regions)
    geometry = read_geometry(source, packages)
    if geometry is None:
        _refuse(source, around.obstacles)
        say("no collision geometry in the robot: self-collision is not looked at")
        return tuple(regions)
    bodies = Collision.of(robot, with_obstacles(geometry, around.obstacles), distance)
    say(f"{len(bodies.names)} pairs of bodies are kept {distance:g} m apart")
    for sentence in _not_watched(bodies, around.obstacles):
        say(sentence)
    return (bodies, *regions)


def sources_of(source: str | Path, cell: Path | None) -> list[str | Path]:
    """Files that may say what stands around an arm.

    Raises:
        RobotError: The file of the cell has no such rows, or others.
    """
    if cell is None:
        return [source]
    table = parse_toml(read_text(cell), str(cell))
    check_keys(table, AROUND, str(cell))
    if not table:
        raise RobotError(f"{cell}: no [[obstacle]] and no [[region]] row in it")
    return [source, cell]


def _refuse(source: str | Path, obstacles: tuple[Obstacle, ...]) -> None:
    if obstacles:
        raise RobotError(
            f"obstacle '{obstacles[0].name}': {source} has no collision geometry that could be kept clear of "
            "it. Use a URDF with <collision>, an MJCF, or a [[region]] for the flange; --no-collision "
            "plans without obstacles"
        )


def _not_watched(bodies: Collision, obstacles: tuple[Obstacle, ...]) -> list[str]:
    """What of the obstacles is left out, and why."""
    names = {obstacle.name for obstacle in obstacles}
    return [
        f"{pair.first} to {pair.second} is not looked at: {pair.reason}"
        for pair in bodies.excluded
        if {pair.first, pair.second} & names
    ]
