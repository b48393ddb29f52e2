"""Drawings of a motion: the path of the flange among obstacles and walls, from above and from the sides."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from markupsafe import Markup
from scipy.spatial import ConvexHull

from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.arm.robot import Robot
from exidyn.identification.document.document import Figure
from exidyn.identification.pages.svg import Panel, Span, legend, path, picture, text
from exidyn.identification.robot_files.surroundings import Obstacle

from ..clearances.clearance import Clearance
from ..clearances.region import HalfSpace, Region
from ..trajectory import Trajectory

VIEWS = (("from above", 0, 1), ("along y", 0, 2), ("along x", 1, 2))
"""Name of each view, and its horizontal and vertical axes."""
AXES = "xyz"
LEFT, TOP, WIDTH, BOTTOM, RIGHT = 58.0, 24.0, 380.0, 32.0, 12.0
"""Margins and width of a panel [px]."""
SPACING = 0.02
"""Time between the points of the path [s]: a flange at 2 m/s moves by 4 cm."""
ROUND = 48
"""Number of points of a circle."""


class Space(NamedTuple):
    """The path of a motion and its surroundings."""

    path: np.ndarray  # path of the flange in the base frame, shape (t, 3) [m]
    # Name and points in the base frame, shape (k, 3) [m], of each bounded obstacle.
    solids: tuple[tuple[str, np.ndarray], ...]
    walls: tuple[HalfSpace, ...]  # walls of planes and regions


def space_of(
    trajectory: Trajectory, robot: Robot, obstacles: Sequence[Obstacle], clearances: Sequence[Clearance]
) -> Space:
    """The path of a robot's flange and its surroundings."""
    data = robot.kinematics.createData()
    positions = trajectory.every(SPACING).position
    points = [flange_position(robot.kinematics, robot.flange, position, data) for position in positions]
    bounded = [obstacle for obstacle in obstacles if obstacle.kind != "plane"]
    solids = tuple((obstacle.name, outline_points(obstacle)) for obstacle in bounded)
    walls = [wall for region in clearances if isinstance(region, Region) for wall in region.walls]
    for plane in (obstacle for obstacle in obstacles if obstacle.kind == "plane"):
        normal = plane.placement.rotation @ np.array(plane.shape.n)
        walls.append(HalfSpace(-normal, -float(normal @ plane.placement.translation), plane.name))
    return Space(np.array(points), solids, tuple(walls))


def outline_points(obstacle: Obstacle) -> np.ndarray:
    """Points in the base frame whose hull is the obstacle, approximately if round; shape (k, 3) [m]."""
    shape, angle = obstacle.shape, np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
    if obstacle.kind == "mesh":
        points = np.array(shape.points(), float).reshape(-1, 3)
    elif obstacle.kind == "box":
        points = shape.halfSide * np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    else:
        high = shape.halfLength if obstacle.kind == "cylinder" else 0.0
        circle = shape.radius * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
        rings = (circle - [0, 0, high], circle + [0, 0, high])
        if obstacle.kind == "sphere":
            rings = tuple(np.roll(circle, turn, axis=1) for turn in range(3))
        points = np.concatenate(rings)
    return points @ obstacle.placement.rotation.T + obstacle.placement.translation


def space_figures(space: Space) -> list[Figure]:
    """A figure of each view."""
    return [Figure(name, "", _view(space, name, across, up)) for name, across, up in VIEWS]


def _view(space: Space, name: str, across: int, up: int) -> Markup:
    axes = [across, up]
    seen = np.concatenate([space.path, np.zeros((1, 3)), *(points for _, points in space.solids)])[:, axes]
    x, y = _square(Span.around(seen[:, 0]), Span.around(seen[:, 1]))
    panel = Panel(x, y, LEFT, TOP, WIDTH, WIDTH)
    keys = [("moved", "path of the flange"), ("limit", "obstacles, walls")]
    parts = [legend(LEFT, 14, keys if space.solids or space.walls else keys[:1])]
    parts.append(panel.axes(f"{AXES[across]} [m]", f"{AXES[up]} [m]"))
    parts += [_wall(panel, wall, across, up) for wall in space.walls]
    parts += [_solid(panel, name, points[:, axes]) for name, points in space.solids]
    parts.append(path(panel.pixels(*space.path[:, axes].T), "moved"))
    parts.append(panel.dots(np.zeros(1), np.zeros(1), "base"))
    return picture(LEFT + WIDTH + RIGHT, TOP + panel.height + BOTTOM, f"path {name}", "".join(parts))


def _square(*spans: Span) -> list[Span]:
    """Spans of equal length about the same centers, so that both axes have the same scale."""
    half = 0.5 * max(axis.size for axis in spans)
    return [Span(0.5 * (axis.low + axis.high) - half, 0.5 * (axis.low + axis.high) + half) for axis in spans]


def _solid(panel: Panel, name: str, points: np.ndarray) -> str:
    outline = points[ConvexHull(points).vertices]
    edge = panel.pixels(*outline.T)
    x, y = np.mean(edge, axis=0) / 10.0
    shape = path(edge, "forbidden", closed=True) + path(edge, "limit", closed=True)
    return shape + text(float(x), float(y), name, "tick middle")


def _wall(panel: Panel, wall: HalfSpace, across: int, up: int) -> str:
    """The line of a wall seen edgewise; empty if it is not edgewise, or lies outside the picture."""
    normal = wall.normal[[across, up]]
    if np.linalg.norm(normal) < 1.0 - 1e-6:
        return ""
    corners = np.array([[panel.x.low, panel.y.low], [panel.x.high, panel.y.high]])
    middle = np.mean(corners, axis=0)
    middle = middle + (wall.offset - normal @ middle) * normal
    along = np.array([-normal[1], normal[0]]) * np.linalg.norm(corners[1] - corners[0])
    ends = _clipped(np.stack([middle - along, middle + along]), corners)
    return path(panel.pixels(*ends.T), "limit") if len(ends) else ""


def _clipped(ends: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Ends of the part of a line that is inside a rectangle, shape (2, 2), or (0, 2) if there is none."""
    start, step = ends[0], ends[1] - ends[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = (corners - start) / step
    sides = np.where(np.isnan(sides), [[-np.inf], [np.inf]], sides)
    enter, leave = np.max(np.min(sides, axis=0)), np.min(np.max(sides, axis=0))
    parallel_outside = (step == 0.0) & ((start < corners[0]) | (start > corners[1]))
    if enter >= leave or np.any(parallel_outside):
        return np.zeros((0, 2))
    return np.stack([start + enter * step, start + leave * step])
