"""Surroundings of an arm, from the `[[obstacle]]` and `[[region]]` rows of a TOML file."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin

from ..errors import RobotError
from .description import is_description
from .geometry import read_hull
from .robot_file import builtin_names
from .toml_fields import check_keys, number, numbers, parse_toml, read_text, string, tables

SHAPES = ("box", "sphere", "cylinder", "plane", "mesh")
KEYS = ("name", *SHAPES, "scale", "at", "rpy")


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A solid that does not move."""

    name: str  # name in messages
    kind: str  # kind of the shape, one of `SHAPES`
    shape: Any  # shape for coal: the convex hull of a mesh, the half-space behind a plane
    placement: pin.SE3  # placement of the shape in the frame of the base


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Obstacles around an arm, and regions in which its points may be."""

    obstacles: tuple[Obstacle, ...] = ()  # solids around the arm
    # Tables of the `[[region]]` rows, which can only be parsed with the arm.
    regions: tuple[Mapping[str, Any], ...] = ()

    def __bool__(self) -> bool:
        """Whether there are obstacles or regions."""
        return bool(self.obstacles or self.regions)


def read_surroundings(sources: Iterable[str | Path]) -> Surroundings:
    """Surroundings from all files; files that cannot have such rows, such as a URDF, are skipped."""
    obstacles: list[Obstacle] = []
    regions: list[Mapping[str, Any]] = []
    for source in sources:
        if str(source) in builtin_names() or is_description(Path(source)):
            continue
        table = parse_toml(read_text(Path(source)), str(source))
        rows = tables(table["obstacle"], "obstacle") if "obstacle" in table else []
        for place, row in enumerate(rows):
            obstacles.append(_obstacle(row, f"{source}: obstacle {place + 1}", Path(source).parent))
        regions += tables(table["region"], "region") if "region" in table else []
    names = [obstacle.name for obstacle in obstacles]
    for name in names:
        if names.count(name) > 1:
            raise RobotError(f"{names.count(name)} obstacles are called '{name}'; give each its own name")
    return Surroundings(tuple(obstacles), tuple(regions))


def _obstacle(row: Mapping[str, Any], where: str, folder: Path) -> Obstacle:
    """Obstacle of a row.

    .. code-block:: toml

        [[obstacle]]
        name = "table"
        box = [1.2, 0.8, 0.05]     # sizes along x, y, z [m]; or one of
        # sphere = 0.1             # radius [m]
        # cylinder = [0.1, 0.5]    # radius, length along z [m]
        # plane = [0, 0, 1]        # solid behind it; the direction points to the free side
        # mesh = "fixture.stl"     # its convex hull; scale = 0.001 if it is in millimeters
        at = [0.6, 0, -0.025]      # position of its center, or origin, in the base frame [m]
        rpy = [0, 0, 0]            # roll, pitch, yaw [rad]
    """
    check_keys(row, KEYS, where)
    kinds = [kind for kind in SHAPES if kind in row]
    if len(kinds) != 1:
        raise RobotError(f"{where}: {len(kinds)} shapes; give one of {', '.join(SHAPES)}")
    if "scale" in row and kinds != ["mesh"]:
        raise RobotError(f"{where}: scale = {row['scale']} is for a mesh; this is a {kinds[0]}")
    at = numbers(row.get("at", [0.0] * 3), 3, f"{where} at")
    rotation = pin.rpy.rpyToMatrix(numbers(row.get("rpy", [0.0] * 3), 3, f"{where} rpy"))
    name = string(row.get("name", kinds[0]), f"{where} name")
    return Obstacle(name, kinds[0], _shape(row, kinds[0], where, folder), pin.SE3(rotation, at))


def _shape(row: Mapping[str, Any], kind: str, where: str, folder: Path) -> Any:
    at = f"{where} {kind}"
    if kind == "box":
        return coal.Box(*_sizes(row[kind], 3, at))
    if kind == "sphere":
        return coal.Sphere(*_sizes([row[kind]], 1, at))
    if kind == "cylinder":
        return coal.Cylinder(*_sizes(row[kind], 2, at))
    if kind == "plane":
        return coal.Halfspace(_direction(row[kind], at), 0.0)
    scale = number(row.get("scale", 1.0), f"{where} scale")
    return read_hull(folder / string(row[kind], at), _sizes([scale] * 3, 3, f"{where} scale"), at)


def _sizes(value: object, count: int, where: str) -> np.ndarray:
    sizes = numbers(value, count, where)
    if np.any(sizes <= 0):
        raise RobotError(f"{where} = {value}: every size must be above 0 m")
    return sizes


def _direction(value: object, where: str) -> np.ndarray:
    direction = numbers(value, 3, where)
    if not np.any(direction):
        raise RobotError(f"{where} = {value}: give the direction that points to its free side")
    return direction / np.linalg.norm(direction)


def with_obstacles(geometry: pin.GeometryModel, obstacles: Sequence[Obstacle]) -> pin.GeometryModel:
    """Copy of an arm's collision geometry with the obstacles as bodies of the base."""
    combined = geometry.copy()
    for obstacle in obstacles:
        body = pin.GeometryObject(obstacle.name, 0, 0, obstacle.placement, obstacle.shape)
        combined.addGeometryObject(body)
    return combined
