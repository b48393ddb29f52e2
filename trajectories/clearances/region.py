"""Region: where a point of the arm may be, from the `[[region]]` rows of a TOML file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.newton_euler import joints_of
from exidyn.identification.arm.robot import Robot
from exidyn.identification.errors import RobotError
from exidyn.identification.robot_files.toml_fields import check_keys, number, numbers, string, tables

from ..errors import BadLimits
from .clearance import Clearance
from .poses import Cover, joint_poses, moves, reach, slopes

FLANGE = "flange"


class HalfSpace(NamedTuple):
    """Points p of the base frame with normal . p <= offset."""

    normal: np.ndarray  # unit vector that points out of the allowed side, shape (3,)
    offset: float  # offset of the wall from the base along the normal [m]
    name: str  # name in messages

    @classmethod
    def of(cls, normal: np.ndarray, offset: float) -> "HalfSpace":
        """Half-space from a normal of any length, which is normalized, and an offset [m], which is not.

        Raises:
            BadLimits: The normal has no direction.
        """
        length = float(np.linalg.norm(normal))
        if not np.isfinite(length) or length == 0 or not np.isfinite(offset):
            raise BadLimits(
                f"half-space: normal {list(normal)}, offset {offset}; expected a nonzero normal and a finite "
                "offset"
            )
        return cls(
            np.asarray(normal, float) / length, offset, f"wall {[float(x) for x in normal]} <= {offset:g} m"
        )


def box(lower: np.ndarray, upper: np.ndarray) -> list[HalfSpace]:
    """Half-spaces of a box in the base frame between two corners, shape (3,) [m]; infinite means no wall.

    Raises:
        BadLimits: The box is empty.
    """
    walls = []
    for place, name in enumerate("xyz"):
        if not lower[place] < upper[place]:
            raise BadLimits(
                f"region: lower {name} = {lower[place]:g} m is not below upper {upper[place]:g} m"
            )
        axis = np.eye(3)[place]
        walls.append(HalfSpace(-axis, -float(lower[place]), f"{name} >= {lower[place]:g} m"))
        walls.append(HalfSpace(axis, float(upper[place]), f"{name} <= {upper[place]:g} m"))
    return [wall for wall in walls if np.isfinite(wall.offset)]


@dataclass(frozen=True, eq=False)
class Region(Clearance):
    """A ball around a point of the arm, and the walls behind which it must stay."""

    kinematics: pin.Model  # Pinocchio model with n joints
    point: str  # name of the point
    body: int  # index of the joint that carries the point, -1 for the base
    place: np.ndarray  # position of the point in that joint's frame, shape (3,) [m]
    radius: float  # radius of the ball [m]
    walls: tuple[HalfSpace, ...]  # walls in the base frame, one for each row

    @classmethod
    def of(
        cls,
        robot: Robot,
        point: str,
        walls: Sequence[HalfSpace],
        offset: Sequence[float] = (0.0, 0.0, 0.0),
        radius: float = 0.0,
    ) -> "Region":
        """Region of a point in the frame of the flange, or of a joint, link or frame by name.

        Args:
            robot: Robot with the point.
            point: "flange", or the name of a joint, link or frame.
            walls: Walls from `box` and `HalfSpace.of`.
            offset: Offset of the point in that frame, shape (3,) [m].
            radius: Radius of the ball around it [m].

        Raises:
            RobotError: The robot has no such frame.
            BadLimits: There is no wall, or the radius is negative.
        """
        if not walls or not radius >= 0 or not np.all(np.isfinite([radius, *offset])):
            raise BadLimits(
                f"region of {point}: {len(walls)} walls, radius {radius} m, offset {list(offset)} m; "
                "expected at least one wall at a finite distance, and a radius of at least 0"
            )
        body, frame = _frame(robot, point)
        place = frame.rotation @ np.asarray(offset, float) + frame.translation
        return cls(robot.kinematics, point, body, place, radius, tuple(walls))

    @property
    def names(self) -> list[str]:
        return [f"{self.point} {wall.name}" for wall in self.walls]

    def points(self, position: np.ndarray) -> np.ndarray:
        """Position of the point in the base frame, shape (t, 3) [m]."""
        if self.body < 0:
            return np.broadcast_to(self.place, (len(position), 3))
        poses = joint_poses(joints_of(self.kinematics), position)
        return poses.rotation[:, self.body] @ self.place + poses.origin[:, self.body]

    def margins(self, position: np.ndarray) -> np.ndarray:
        return self._room(self.points(position))

    def gradient(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        joints, point = joints_of(self.kinematics), self.points(position)
        shape = (len(position), len(self.walls), 3)
        at, inward = np.broadcast_to(point[:, None], shape), np.broadcast_to(-self._normals, shape)
        slope = slopes(joints, joint_poses(joints, position), at, inward)
        return self._room(point), slope * moves(joints, self.body)

    def reach(self, travel: np.ndarray) -> np.ndarray:
        joints, ball = joints_of(self.kinematics), Cover(self.body, self.place[None])
        carried = moves(joints, self.body)
        far = [reach(joints, j, ball, travel) if carried[j] else 0.0 for j in range(len(joints))]
        return np.broadcast_to(np.array(far), (len(self.walls), len(joints)))

    @property
    def _normals(self) -> np.ndarray:
        return np.array([wall.normal for wall in self.walls])

    def _room(self, point: np.ndarray) -> np.ndarray:
        """Distance between the ball around points, shape (t, 3), and each wall, shape (t, m) [m]."""
        return np.array([wall.offset for wall in self.walls]) - point @ self._normals.T - self.radius


def _frame(robot: Robot, point: str) -> tuple[int, pin.SE3]:
    """Index of the joint that carries a named frame, -1 for the base, and the frame's placement there."""
    model = robot.kinematics
    if point == FLANGE:  # takes precedence over a frame of that name, from which a file may move the flange
        return robot.dof - 1, robot.flange
    if point in robot.joints:
        return robot.joints.index(point), pin.SE3.Identity()
    for frame in model.frames:
        if frame.name == point:
            return frame.parentJoint - 1, frame.placement
    names = dict.fromkeys([FLANGE, *robot.joints, *(frame.name for frame in model.frames)])
    raise RobotError(f"{robot.name} has no point '{point}'. Valid: {', '.join(names)}")


KEYS = ("point", "offset", "radius", "lower", "upper", "half_space")
WALL_KEYS = ("normal", "offset")


def read_regions(rows: object, robot: Robot) -> list[Region]:
    """Regions from `[[region]]` rows, each for one point.

    .. code-block:: toml

        [[region]]
        point = "flange"           # or a joint, link or frame
        offset = [0, 0, 0.1]       # of the point in that frame [m]
        radius = 0.05              # of the ball around it [m]
        lower = [-inf, -1, 0.2]    # box in the base frame [m]
        upper = [inf, 1, 1.5]
        half_space = [{ normal = [1, 1, 0], offset = 0.8 }]    # wall 0.8 m from the base that way

    Raises:
        RobotError: A row is wrong; the message names the key, its value and what is valid.
        BadLimits: A region has no walls, or is empty.
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
