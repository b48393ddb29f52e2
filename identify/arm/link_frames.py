"""Where each link is, for viewers that show the arm: the transforms of ROS's /tf."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from .newton_euler import joints_of


class LinkFrame(NamedTuple):
    """The frame that one joint moves.

    Attributes:
        parent: Name of the link before the joint.
        child: Name of the link behind it.
        placement: Joint's frame in the parent link's frame at zero position.
    """

    parent: str
    child: str
    placement: pin.SE3


def link_frames(kinematics: pin.Model) -> list[LinkFrame]:
    """One frame a joint; links are called as in the URDF, or link1, link2, … where there was none."""
    return [_link_frame(kinematics, index) for index in range(1, kinematics.njoints)]


def _link_frame(kinematics: pin.Model, joint: int) -> LinkFrame:
    placement = kinematics.jointPlacements[joint]
    place = kinematics.getFrameId(kinematics.names[joint], pin.FrameType.JOINT)
    if place == kinematics.nframes:  # the tree was built joint by joint, and its links have no names
        parent = kinematics.parents[joint]
        return LinkFrame(f"link{parent}" if parent else "base", f"link{joint}", placement)
    links = {frame.parentFrame: frame for frame in kinematics.frames if frame.type == pin.FrameType.BODY}
    carrier = kinematics.frames[kinematics.frames[place].parentFrame]
    child = links[place].name if place in links else f"link{joint}"
    return LinkFrame(carrier.name, child, carrier.placement.inverse() * placement)


def link_poses(kinematics: pin.Model, position: np.ndarray) -> np.ndarray:
    """Pose of each child link in its parent link, shape (t, n, 7): x y z [m], quaternion x y z w [-]."""
    poses = np.empty((*position.shape, 7))
    frames = link_frames(kinematics)
    for index, (joint, frame) in enumerate(zip(joints_of(kinematics), frames, strict=True)):
        place, turn = frame.placement, pin.Quaternion(frame.placement.rotation).coeffs()
        moved = position[:, index, None]
        if joint.revolute:
            poses[:, index, :3] = place.translation
            poses[:, index, 3:] = _times(turn, _about(joint.axis, moved))
        else:
            poses[:, index, :3] = place.translation + moved * (place.rotation @ joint.axis)
            poses[:, index, 3:] = turn
    return poses


def flange_position(
    kinematics: pin.Model, flange: pin.SE3, position: np.ndarray, data: pin.Data | None = None
) -> np.ndarray:
    """Where the flange is in the base frame, shape (3,) [m].

    Args:
        kinematics: Of the arm.
        flange: Its frame in that of the last joint.
        position: Shape (n,) [rad] or [m].
        data: To compute in, for who calls it often.
    """
    data = data or kinematics.createData()
    pin.forwardKinematics(kinematics, data, position)
    place: np.ndarray = (data.oMi[kinematics.njoints - 1] * flange).translation
    return place.copy()


def _about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):  # a joint that is at no number, as recorded, points nowhere
        return np.concatenate([axis * np.sin(angle / 2), np.cos(angle / 2)], axis=1)


def _times(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Product of one quaternion with many, x y z w."""
    x, y, z, w = left
    by_right = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    return right @ by_right.T
