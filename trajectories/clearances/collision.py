"""Collision: distances between the arm's bodies and to obstacles, and the pairs that are not checked."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.newton_euler import Joint, joints_of
from exidyn.identification.arm.robot import Robot
from exidyn.identification.errors import RobotError

from .clearance import Clearance, random_positions
from .poses import cover, joint_poses, moves, reach, slopes

TRIED = 200
"""Number of random positions: the standard error of a share of 95 % is then 1.5 %."""
SHARE = 0.95
"""Share of random positions in which two bodies must be near each other to count as near by design."""
BY_DESIGN = 0.025
"""Gap below which two bodies count as near each other [m]: the gap of a housing around its joint."""


class ExcludedPair(NamedTuple):
    """Two bodies whose distance is not checked."""

    first: str  # name of a body: its link and a number
    second: str  # name of the other body
    reason: str  # reason for the exclusion


def _choose_pairs(
    robot: Robot, geometry: pin.GeometryModel, required: float, ignored: Collection[tuple[str, str]]
) -> tuple[pin.GeometryModel, list[ExcludedPair]]:
    """A copy of the geometry with the pairs to check, and the excluded pairs; see `Collision.of`."""
    _check(robot, geometry)
    bodies, checked = geometry.geometryObjects, geometry.copy()
    checked.removeAllCollisionPairs()
    ignored_links, excluded = _ignored_links(robot, geometry, ignored), list[ExcludedPair]()
    for first, second in combinations(range(len(bodies)), 2):
        body, other = bodies[first], bodies[second]
        links = frozenset((_link(robot, body), _link(robot, other)))
        if body.parentJoint == other.parentJoint:
            continue
        if links in ignored_links:
            excluded.append(ExcludedPair(body.name, other.name, "ignored"))
        elif _adjacent(robot, geometry, body, other):
            excluded.append(ExcludedPair(body.name, other.name, "adjacent"))
        else:
            checked.addCollisionPair(pin.CollisionPair(first, second))
    return checked, excluded + _remove_together(robot, checked, max(required, BY_DESIGN))


def _check(robot: Robot, geometry: pin.GeometryModel) -> None:
    model = robot.kinematics
    for body in geometry.geometryObjects:
        fits = body.parentFrame < model.nframes and body.parentJoint < model.njoints
        if not fits or model.frames[body.parentFrame].parentJoint != body.parentJoint:
            raise RobotError(
                f"{robot.name}: body '{body.name}' belongs to frame {body.parentFrame} of joint "
                f"{body.parentJoint}, which this robot does not have. Read robot and geometry from one file"
            )


def _link(robot: Robot, body: pin.GeometryObject) -> str:
    """Name of the body's link, or of the obstacle itself, which belongs to no link."""
    return str(robot.kinematics.frames[body.parentFrame].name if body.parentFrame else body.name)


def _ignored_links(
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
    robot: Robot, geometry: pin.GeometryModel, first: pin.GeometryObject, second: pin.GeometryObject
) -> bool:
    """Whether one link carries the other with no body in between."""
    frames = robot.kinematics.frames
    with_body = {body.parentFrame for body in geometry.geometryObjects}
    for upper, lower in ((first, second), (second, first)):
        at = lower.parentFrame
        while at > 0:
            at = frames[at].parentFrame
            if at in with_body:
                break
        if at == upper.parentFrame and at > 0:
            return True
    return False


def _can_separate(robot: Robot, geometry: pin.GeometryModel, pair: tuple[int, int]) -> bool:
    """Whether a pair consists of an obstacle and a body that several joints can move away from it."""
    bodies, parents = [geometry.geometryObjects[place] for place in pair], robot.kinematics.parents
    moved = any(body.parentJoint and parents[body.parentJoint] for body in bodies)
    return moved and any(body.parentFrame == 0 for body in bodies)


def _remove_together(robot: Robot, checked: pin.GeometryModel, gap: float) -> list[ExcludedPair]:
    """Remove pairs that are near each other by design, and return them."""
    data, placed = robot.kinematics.createData(), checked.createData()
    pairs = [(pair.first, pair.second) for pair in checked.collisionPairs]
    near_counts = np.zeros(len(pairs), int)
    for position in random_positions(robot, TRIED):
        pin.computeDistances(robot.kinematics, data, checked, placed, position)
        near_counts += np.array([result.min_distance < gap for result in placed.distanceResults], bool)
    excluded = []
    for pair, count in zip(pairs, near_counts, strict=True):
        if count > SHARE * TRIED and not _can_separate(robot, checked, pair):
            first, second = (checked.geometryObjects[body].name for body in pair)
            excluded.append(ExcludedPair(first, second, f"under {gap:g} m by design"))
            checked.removeCollisionPair(pin.CollisionPair(*pair))
    return excluded


REQUIRED = 0.02
"""Default required distance between bodies [m], for tracking error and details that meshes omit."""
TOLERANCE = 1e-10
"""Tolerance of distances [m]. Coal's default of 1e-6 is no faster, and makes nearest points inaccurate, and
with them the gradients."""


@dataclass(frozen=True, eq=False)
class Collision(Clearance):
    """Distances between bodies of one arm, less the required distance.

    Meshes are replaced by their convex hulls, so bodies are never nearer than computed.
    """

    kinematics: pin.Model  # Pinocchio model with n joints
    geometry: pin.GeometryModel  # bodies, and the m pairs that are checked
    required: float = REQUIRED  # required distance of each pair [m]
    excluded: tuple[ExcludedPair, ...] = ()  # pairs that are not checked, and why

    @classmethod
    def of(
        cls,
        robot: Robot,
        geometry: pin.GeometryModel,
        required: float = REQUIRED,
        ignored: Collection[tuple[str, str]] = (),
    ) -> "Collision":
        """Collision with all pairs that can collide.

        Bodies fixed to each other form no pair. Adjacent links are excluded. So are bodies that are nearer
        than the required distance, or 25 mm, in more than 95 % of random positions: they are near each other
        by design, like the first and third joint of a wrist. A pair with an obstacle is excluded only if at
        most one joint moves the body, such as the column of an arm on its table.

        The required distance is in m; pairs of links that are ignored are not checked.

        Raises:
            RobotError: The geometry belongs to another robot, or an ignored link has no body.
        """
        checked, excluded = _choose_pairs(robot, geometry, required, ignored)
        return cls(robot.kinematics, checked, required, tuple(excluded))

    @property
    def required_distance(self) -> float:
        return self.required

    @property
    def names(self) -> list[str]:
        names = [body.name for body in self.geometry.geometryObjects]
        return [f"{names[first]} to {names[second]}" for first, second in self._pairs]

    @property
    def _pairs(self) -> np.ndarray:
        """Indices of both bodies of each pair, shape (m, 2)."""
        return np.array([[p.first, p.second] for p in self.geometry.collisionPairs], int).reshape(-1, 2)

    def distances(self, position: np.ndarray) -> np.ndarray:
        """Distance of each pair, shape (t, m) [m]; minus the penetration depth if they overlap."""
        distances = np.empty((len(position), len(self.geometry.collisionPairs)))
        for row, results in enumerate(self._measured(position)):
            distances[row] = [result.min_distance for result in results]
        return distances

    def distances_and_gradient(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances, shape (t, m) [m], and their derivatives by joint position, shape (t, m, n) [m/rad].

        The derivative is the relative velocity of the nearest points along the normal, or of the points of
        deepest penetration if the bodies overlap.
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
        margins = np.full(wanted.shape, np.inf)
        for row, configuration in enumerate(position):
            pin.updateGeometryPlacements(self.kinematics, data, self.geometry, placed, configuration)
            for pair in np.flatnonzero(wanted[row]):
                result = pin.computeDistance(self.geometry, placed, int(pair))
                margins[row, pair] = result.min_distance - self.required
        return margins

    def reach(self, travel: np.ndarray) -> np.ndarray:
        joints = joints_of(self.kinematics)
        covers = [cover(body) for body in self.geometry.geometryObjects]
        # either body may be regarded as the one at rest; the tighter bound holds
        far = np.array([[reach(joints, j, c, travel) for j in range(len(joints))] for c in covers])
        nearer = np.min(far[self._pairs], axis=1)
        return nearer * np.abs(self._between(joints))

    def _between(self, joints: list[Joint]) -> np.ndarray:
        """1 if a joint moves only the second body of a pair, -1 only the first, 0 both or neither; (m, n)."""
        bodies = self.geometry.geometryObjects
        carried = np.array([moves(joints, body.parentJoint - 1) for body in bodies], int)
        first, second = np.moveaxis(carried.reshape(-1, len(joints))[self._pairs], 1, 0)
        return second - first

    def _measured(self, position: np.ndarray) -> Iterator[pin.StdVec_DistanceResult]:
        """Results of all pairs, sample by sample; the next sample overwrites them."""
        data, placed = self.kinematics.createData(), _workspace(self.geometry)
        for row in position:
            pin.computeDistances(self.kinematics, data, self.geometry, placed, row)
            yield placed.distanceResults


def _workspace(geometry: pin.GeometryModel) -> pin.GeometryData:
    placed = geometry.createData()
    for request in placed.distanceRequests:
        request.gjk_tolerance = TOLERANCE
    return placed
