"""Joints of an MJCF that are held: at which positions, and where their bodies are.

A joint that no recording contains is held where the robot file states, where an equality locks it, where it
follows another held joint, or at its reference position.
"""

from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from ..arm.robot import Held
from ..errors import RobotError, UnknownJoint
from .mjcf_elements import joint_equalities, joint_name, joint_names, turns

EXPECTED = {
    7: "its position [m] and its orientation as a quaternion: [x, y, z, qw, qx, qy, qz]",
    4: "a quaternion: [qw, qx, qy, qz]",
    1: "one number [rad, m]",
}
"""Count of a joint's numbers -> their meaning."""


def held_positions(
    model: Any, moving: Collection[str] | None, held: Held = MappingProxyType({}), where: str = "MJCF"
) -> dict[int, np.ndarray]:
    """Positions in `qpos` of the joints that are held; `moving` and `held` are those of `read_kinematics`.

    Returns:
        Index of each held joint -> position, shape (1,) [rad, m], (4,) of a ball or (7,) of a free joint.
    """
    names = joint_names(model)
    for name in (*(moving or ()), *held):
        if name not in names:
            raise UnknownJoint(name, where, names)
    stated = {names.index(name): _stated(model, names.index(name), held[name], where) for name in held}
    resting = [joint for joint, name in enumerate(names) if moving is not None and name not in moving]
    positions = {joint: reference(model, joint) for joint in resting}
    locked = [(e, joint) for e, joint, leader in joint_equalities(model) if leader < 0]
    positions |= {joint: reference(model, joint) + float(model.eq_data[e][0]) for e, joint in locked}
    positions |= stated
    _follow(model, positions, stated)
    return positions


def reference(model: Any, joint: int) -> np.ndarray:
    """Reference position of a joint as it is in `qpos`; that of a free joint is the pose of its body."""
    start = int(model.jnt_qposadr[joint])
    return np.array(model.qpos0[start : start + _size(model, joint)])


def followed(model: Any, equality: int, leader: float) -> float:
    """Position of the joint that follows by an equality of joints, at its leader's position [rad, m]."""
    first, second = (int(getattr(model, f"eq_obj{end}id")[equality]) for end in (1, 2))
    away = leader - float(reference(model, second)[0])
    powers = np.polynomial.polynomial.polyval(away, model.eq_data[equality][:5])
    return float(reference(model, first)[0] + powers)


def held_placement(model: Any, joint: int, position: np.ndarray, placement: pin.SE3) -> pin.SE3:
    """Placement of a body behind a held joint, from its placement in front of it."""
    if _size(model, joint) == 7:
        return placement_of(position[:3], position[3:])
    anchor = pin.SE3(np.eye(3), model.jnt_pos[joint].copy())
    if _size(model, joint) == 4:
        return placement * anchor * placement_of(np.zeros(3), position) * anchor.inverse()
    away = float((position - reference(model, joint))[0])
    moved = joint_motion(model.jnt_axis[joint], away, turns(model, joint))
    return placement * anchor * moved * anchor.inverse()


def joint_motion(axis: np.ndarray, distance: float, hinge: bool) -> pin.SE3:
    """Motion of a hinge or slide along its axis (3,) by a distance [rad, m]."""
    if distance == 0.0:
        return pin.SE3.Identity()
    return pin.SE3(pin.exp3(axis * distance), np.zeros(3)) if hinge else pin.SE3(np.eye(3), axis * distance)


def placement_of(position: np.ndarray, quaternion: np.ndarray) -> pin.SE3:
    """Placement of a position (3,) [m] and a quaternion w, x, y, z."""
    w, x, y, z = quaternion
    return pin.SE3(pin.Quaternion(w, x, y, z).toRotationMatrix(), position.copy())


def _stated(model: Any, joint: int, value: float | tuple[float, ...], where: str) -> np.ndarray:
    """Stated position of a joint, with a quaternion of length 1."""
    position, size = np.atleast_1d(np.array(value, float)), _size(model, joint)
    if len(position) != size:
        raise RobotError(
            f"{where}: held: joint '{joint_name(model, joint)}' has {len(position)} numbers, expected "
            f"{EXPECTED[size]}"
        )
    if size > 1:
        length = float(np.linalg.norm(position[-4:]))
        if length == 0.0:
            raise RobotError(
                f"{where}: held: joint '{joint_name(model, joint)}' has a quaternion of length 0; no "
                "rotation is 1, 0, 0, 0"
            )
        position[-4:] /= length
    return position


def _follow(model: Any, positions: dict[int, np.ndarray], stated: Mapping[int, np.ndarray]) -> None:
    """Move held joints to where their held leaders put them, unless their position is stated."""
    equalities = joint_equalities(model)
    for _ in equalities:  # a leader may follow another joint
        for equality, follower, leader in equalities:
            if leader in positions and follower in positions and follower not in stated:
                place = followed(model, equality, float(positions[leader][0]))
                positions[follower] = np.array([place])


def _size(model: Any, joint: int) -> int:
    """Count of a joint's numbers in `qpos`."""
    addresses = [*model.jnt_qposadr, model.nq]
    return int(addresses[joint + 1] - addresses[joint])
