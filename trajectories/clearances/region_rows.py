"""Read regions from the `[[region]]` rows of a TOML file."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from exidyn.identify.arm.robot import Robot
from exidyn.identify.robot_files.toml_fields import check_keys, number, numbers, string, tables

from .region import FLANGE, HalfSpace, Region, box

KEYS = ("point", "offset", "radius", "lower", "upper", "half_space")
WALL_KEYS = ("normal", "offset")


def read_regions(rows: object, robot: Robot) -> list[Region]:
    """Regions of `[[region]]` rows, each for one point.

    .. code-block:: toml

        [[region]]
        point = "flange"           # or a joint, link or frame
        offset = [0, 0, 0.1]       # of the point in that frame [m]
        radius = 0.05              # of the ball around it [m]
        lower = [-inf, -1, 0.2]    # box in the base frame [m]
        upper = [inf, 1, 1.5]
        half_space = [{ normal = [1, 1, 0], offset = 0.8 }]    # wall 0.8 m from the base that way

    Raises:
        RobotError: A row is wrong; the message names the key, what was found and what is valid.
        BadLimits: A region without walls, or that holds no point.
    """
    return [_region(row, f"region {place + 1}", robot) for place, row in enumerate(tables(rows, "region"))]


def _region(row: Mapping[str, Any], where: str, robot: Robot) -> Region:
    check_keys(row, KEYS, where)
    lower = numbers(row.get("lower", -np.inf), 3, f"{where} lower", infinite=True)
    upper = numbers(row.get("upper", np.inf), 3, f"{where} upper", infinite=True)
    walls = box(lower, upper)
    if "half_space" in row:
        walls += [_wall(wall, where) for wall in tables(row["half_space"], f"{where} half_space")]
    offset = numbers(row.get("offset", [0.0] * 3), 3, f"{where} offset")
    radius = number(row.get("radius", 0.0), f"{where} radius", 0.0)
    return Region.of(robot, string(row.get("point", FLANGE), f"{where} point"), walls, list(offset), radius)


def _wall(row: Mapping[str, Any], where: str) -> HalfSpace:
    check_keys(row, WALL_KEYS, f"{where} half_space")
    normal = numbers(row.get("normal"), 3, f"{where} half_space normal")
    return HalfSpace.of(normal, number(row.get("offset"), f"{where} half_space offset"))
