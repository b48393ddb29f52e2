"""Collision: distances between the arm's own bodies and to obstacles, and which pairs need no watching."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.newton_euler import Joint, joints_of
from exidyn.identification.arm.robot import Robot
from exidyn.identification.errors import RobotError

from .clearance import Clearance
from .configurations import random_positions
from .poses import cover, joint_poses, moves, reach, slopes

TRIED = 200
"""Random positions: the share of them is then known to 1.5 % where it is 95 %."""
SHARE = 0.95
"""Of random positions, in which two bodies that are together by design are near each other."""
BY_DESIGN = 0.025
"""Gap under which two bodies count as together [m]: what a housing leaves around its joint."""


class ExcludedPair(NamedTuple):
    """Two bodies that are not watched.

    Attributes:
        first: Name of a body: its link and a number.
        second: Name of the other.
        reason: Why.
        near: Share of random positions in which they are near each other; NaN where it was not tried.
    """

    first: str
    second: str
    reason: str
    near: float = np.nan


def choose_pairs(
    robot: Robot, geometry: pin.GeometryModel, required: float, ignored: Collection[tuple[str, str]]
) -> tuple[pin.GeometryModel, list[ExcludedPair]]:
    """A copy of the geometry with the pairs to watch, and the pairs left out.

    Bodies fixed to each other are no pair at all. Links next to each other are left out, and so are
    bodies that are nearer than the required distance, or 25 mm, in more than 95 % of random positions:
    they are together by design, as the third joint of a wrist is with the first. From obstacles only bodies
    are left out that no more than one joint moves, as the column of an arm on its table.

    Raises:
        RobotError: The geometry is of another robot, or a link to be ignored has no body.
    """
    _check(robot, geometry)
    bodies, watched = geometry.geometryObjects, geometry.copy()
    watched.removeAllCollisionPairs()
    asked, excluded = _asked(robot, geometry, ignored), []
    for first, second in combinations(range(len(bodies)), 2):
        one, other = bodies[first], bodies[second]
        links = frozenset((_link(robot, one), _link(robot, other)))
        if one.parentJoint == other.parentJoint:
            continue
        if links in asked:
            excluded.append(ExcludedPair(one.name, other.name, "asked for"))
        elif _adjacent(robot, geometry, one, other):
            excluded.append(ExcludedPair(one.name, other.name, "neighbours"))
        else:
            watched.addCollisionPair(pin.CollisionPair(first, second))
    return watched, excluded + _remove_together(robot, watched, max(required, BY_DESIGN))


def _check(robot: Robot, geometry: pin.GeometryModel) -> None:
    model = robot.kinematics
    for body in geometry.geometryObjects:
        fits = body.parentFrame < model.nframes and body.parentJoint < model.njoints
        if not fits or model.frames[body.parentFrame].parentJoint != body.parentJoint:
            raise RobotError(
                f"{robot.name}: body '{body.name}' belongs to frame {body.parentFrame} of joint "
                f"{body.parentJoint}, which this robot does not have; read robot and geometry from one file"
            )


def _link(robot: Robot, body: pin.GeometryObject) -> str:
    """Name of the link; an obstacle's own, which belongs to none."""
    return str(robot.kinematics.frames[body.parentFrame].name if body.parentFrame else body.name)


def _asked(
    robot: Robot, geometry: pin.GeometryModel, ignored: Collection[tuple[str, str]]
) -> set[frozenset[str]]:
    links = sorted({_link(robot, body) for body in geometry.geometryObjects})
    for name in (name for pair in ignored for name in pair):
        if name not in links:
            raise RobotError(
                f"{robot.name}: no link '{name}' with collision geometry to ignore. Links: {', '.join(links)}"
            )
    return {frozenset(pair) for pair in ignored}


def _adjacent(
    robot: Robot, geometry: pin.GeometryModel, one: pin.GeometryObject, other: pin.GeometryObject
) -> bool:
    """Whether one link carries the other with no third body on the way."""
    frames = robot.kinematics.frames
    with_body = {body.parentFrame for body in geometry.geometryObjects}
    for upper, lower in ((one, other), (other, one)):
        at = lower.parentFrame
        while at > 0:
            at = frames[at].parentFrame
            if at in with_body:
                break
        if at == upper.parentFrame and at > 0:
            return True
    return False


def _may_part(robot: Robot, geometry: pin.GeometryModel, pair: tuple[int, int]) -> bool:
    """Whether a pair is of an obstacle and a body that several joints move, and so can be elsewhere."""
    bodies, parents = [geometry.geometryObjects[place] for place in pair], robot.kinematics.parents
    moved = any(body.parentJoint and parents[body.parentJoint] for body in bodies)
    return moved and any(body.parentFrame == 0 for body in bodies)


def _remove_together(robot: Robot, watched: pin.GeometryModel, gap: float) -> list[ExcludedPair]:
    """Take out pairs that are together by design, and name them."""
    data, placed = robot.kinematics.createData(), watched.createData()
    pairs = [(pair.first, pair.second) for pair in watched.collisionPairs]
    near = np.zeros(len(pairs), int)
    for position in random_positions(robot, TRIED):
        pin.computeDistances(robot.kinematics, data, watched, placed, position)
        near += np.array([result.min_distance < gap for result in placed.distanceResults], bool)
    excluded = []
    for pair, count in zip(pairs, near, strict=True):
        if count > SHARE * TRIED and not _may_part(robot, watched, pair):
            first, second = (watched.geometryObjects[body].name for body in pair)
            excluded.append(ExcludedPair(first, second, f"under {gap:g} m by design", float(count) / TRIED))
            watched.removeCollisionPair(pin.CollisionPair(*pair))
    return excluded


REQUIRED = 0.02
"""Distance kept between bodies by default [m]: tracking error, and what a mesh leaves out."""
TOLERANCE = 1e-10
"""Of distances [m]. Coal's 1e-6 costs no less and leaves nearest points, and so gradients, in warning."""


@dataclass(frozen=True, eq=False)
class Collision(Clearance):
    """Distances between bodies of one arm, less the distance they must keep.

    Meshes count as their convex hulls, so bodies are never nearer than computed.

    Attributes:
        kinematics: Pinocchio model with n joints.
        geometry: Bodies, and the m pairs that are watched.
        required: Distance that each pair must keep [m].
        excluded: Pairs that are not watched, and why.
    """

    kinematics: pin.Model
    geometry: pin.GeometryModel
    required: float = REQUIRED
    excluded: tuple[ExcludedPair, ...] = ()

    @classmethod
    def of(
        cls,
        robot: Robot,
        geometry: pin.GeometryModel,
        required: float = REQUIRED,
        ignored: Collection[tuple[str, str]] = (),
    ) -> "Collision":
        """All pairs that can collide, but for neighbours.

        Args:
            robot: Whose joints carry the bodies.
            geometry: As `read_geometry` gives it for the same robot.
            required: Distance to keep [m].
            ignored: Names of two links each that need not be watched.

        Raises:
            RobotError: The geometry is of another robot, or an ignored link has none.
        """
        watched, excluded = choose_pairs(robot, geometry, required, ignored)
        return cls(robot.kinematics, watched, required, tuple(excluded))

    @property
    def kept(self) -> float:
        return self.required

    @property
    def names(self) -> list[str]:
        names = [body.name for body in self.geometry.geometryObjects]
        return [f"{names[first]} to {names[second]}" for first, second in self._pairs]

    @property
    def _pairs(self) -> np.ndarray:
        """Places of both bodies of each pair, shape (m, 2)."""
        return np.array([[p.first, p.second] for p in self.geometry.collisionPairs], int).reshape(-1, 2)

    def distances(self, position: np.ndarray) -> np.ndarray:
        """Distance of each pair, negative by the depth where they overlap; shape (t, m) [m]."""
        found = np.empty((len(position), len(self.geometry.collisionPairs)))
        for row, results in enumerate(self._measured(position)):
            found[row] = [result.min_distance for result in results]
        return found

    def distances_and_gradient(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances, shape (t, m) [m], and their change with each joint, shape (t, m, n) [m/rad].

        A distance changes by the velocity of the nearest points along the normal; where bodies overlap
        the same holds of the points where they are deepest.
        """
        count = len(self.geometry.collisionPairs)
        distance = np.empty((len(position), count))
        point, normal = np.empty((2, len(position), count, 3))
        for row, results in enumerate(self._measured(position)):
            for pair, result in enumerate(results):
                distance[row, pair] = result.min_distance
                normal[row, pair] = result.normal  # from the first to the second
                point[row, pair] = result.getNearestPoint2()
        joints = joints_of(self.kinematics)
        slope = slopes(joints, joint_poses(joints, position), point, normal)
        return distance, slope * self._between(joints)

    def margins(self, position: np.ndarray) -> np.ndarray:
        return self.distances(position) - self.required

    def gradient(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        distance, slope = self.distances_and_gradient(position)
        return distance - self.required, slope

    def some_margins(self, position: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        data, placed = self.kinematics.createData(), _workspace(self.geometry)
        found = np.full(wanted.shape, np.inf)
        for row, one in enumerate(position):
            pin.updateGeometryPlacements(self.kinematics, data, self.geometry, placed, one)
            for pair in np.flatnonzero(wanted[row]):
                result = pin.computeDistance(self.geometry, placed, int(pair))
                found[row, pair] = result.min_distance - self.required
        return found

    def reach(self, travel: np.ndarray) -> np.ndarray:
        joints = joints_of(self.kinematics)
        covers = [cover(body) for body in self.geometry.geometryObjects]
        # either body may be seen as the one at rest; the bound that is tighter holds
        far = np.array([[reach(joints, j, c, travel) for j in range(len(joints))] for c in covers])
        nearer = np.min(far[self._pairs], axis=1)
        return nearer * np.abs(self._between(joints))

    def _between(self, joints: list[Joint]) -> np.ndarray:
        """1 where a joint moves a pair's second body only, -1 the first only, 0 both; shape (m, n)."""
        bodies = self.geometry.geometryObjects
        carried = np.array([moves(joints, body.parentJoint - 1) for body in bodies], int)
        first, second = np.moveaxis(carried.reshape(-1, len(joints))[self._pairs], 1, 0)
        return second - first

    def _measured(self, position: np.ndarray) -> Iterator[pin.StdVec_DistanceResult]:
        """Results of all pairs, sample by sample; each is overwritten by the next."""
        data, placed = self.kinematics.createData(), _workspace(self.geometry)
        for row in position:
            pin.computeDistances(self.kinematics, data, self.geometry, placed, row)
            yield placed.distanceResults


def _workspace(geometry: pin.GeometryModel) -> pin.GeometryData:
    placed = geometry.createData()
    for request in placed.distanceRequests:
        request.gjk_tolerance = TOLERANCE
    return placed
