"""Which bodies of an arm could collide, and which pairs need no watching."""

from collections.abc import Collection
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identify.arm.robot import Robot
from exidyn.identify.errors import RobotError

from .configurations import random_positions

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
    they are together by design, as the third joint of a wrist is with the first.

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
    return str(robot.kinematics.frames[body.parentFrame].name)


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
        if at == upper.parentFrame:
            return True
    return False


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
        if count > SHARE * TRIED:
            first, second = (watched.geometryObjects[body].name for body in pair)
            excluded.append(ExcludedPair(first, second, f"under {gap:g} m by design", float(count) / TRIED))
            watched.removeCollisionPair(pin.CollisionPair(*pair))
    return excluded
