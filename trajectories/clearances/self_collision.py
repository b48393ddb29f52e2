"""Self-collision: distances between the arm's own bodies."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from exidyn.identify.arm.newton_euler import Joint, joints_of
from exidyn.identify.arm.robot import Robot

from .body_pairs import ExcludedPair, choose_pairs
from .clearance import Clearance
from .poses import joint_poses, moves, slopes
from .reach import cover, reach

REQUIRED = 0.02
"""Distance kept between bodies by default [m]: tracking error, and what a mesh leaves out."""
TOLERANCE = 1e-10
"""Of distances [m]. Coal's 1e-6 costs no less and leaves nearest points, and so gradients, in warning."""


@dataclass(frozen=True, eq=False)
class SelfCollision(Clearance):
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
    ) -> "SelfCollision":
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
