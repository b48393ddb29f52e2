"""An arm in Rerun: drawn as cylinders, and moved along positions."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
import rerun.urdf

from ...arm.link_frames import link_frames
from ...errors import UnknownJoint
from ...model import Model
from ...robot_files.urdf_text import urdf_text
from .view_parts import GREY, JOINTS, TIMELINE


def log_arm(
    recording: rr.RecordingStream, model: Model, name: str, time: np.ndarray, position: np.ndarray
) -> None:
    """The arm, moving.

    Args:
        recording: Open.
        model: What the arm looks like.
        name: One part of an entity path, and the prefix of the link frames.
        time: Shape (t,) [s].
        position: Shape (t, n) [rad].
    """
    tree = log_solid(recording, model, name, JOINTS)
    index = rr.TimeColumn(TIMELINE, duration=time)
    for place, joint_name in enumerate(model.robot.joints):
        joint = tree.get_joint_by_name(joint_name)
        if joint is None:
            raise UnknownJoint(joint_name, "the robot as drawn", [drawn.name for drawn in tree.joints()])
        columns = joint.compute_transform_columns(position[:, place].tolist(), clamp=False)
        recording.send_columns(
            rr.new_entity_path([name, "moves", joint_name]), indexes=[index], columns=columns
        )


def log_solid(
    recording: rr.RecordingStream, model: Model, name: str, colours: Sequence[tuple[int, ...]]
) -> rerun.urdf.UrdfTree:
    """Draw the arm, each link in the colour of the joint that moves it, and solid."""
    tree, frames = arm_tree(model, name), link_frames(model.robot.kinematics)
    tree.log_urdf_to_recording(recording)
    owners = {frame.child: colours[place % len(colours)] for place, frame in enumerate(frames)}
    for link in {frame.parent for frame in frames} | set(owners):
        solid = rr.Cylinders3D.from_fields(colors=owners.get(link, GREY), fill_mode="solid")
        for path in tree.get_visual_geometry_paths(link):
            recording.log(path, solid, static=True)
    return tree


def arm_view(model: Model, name: str) -> rrb.Spatial3DView:
    """The arm from a place where all of it is in sight, however it stretches."""
    lengths = [np.linalg.norm(place.translation) for place in model.robot.kinematics.jointPlacements]
    reach = float(np.sum(lengths)) or 1.0
    eye = rrb.EyeControls3D(
        position=[1.3 * reach, -1.1 * reach, 0.95 * reach], look_target=[0, 0, 0.2 * reach]
    )
    ground = rrb.SpatialInformation(target_frame=f"{name}/{arm_tree(model, name).root_link().name}")
    origin = rr.new_entity_path([name])
    return rrb.Spatial3DView(origin=origin, name="arm", spatial_information=ground, eye_controls=eye)


def arm_tree(model: Model, name: str) -> rerun.urdf.UrdfTree:
    """The arm, its entities and frames apart from those of arms with other names."""
    with tempfile.TemporaryDirectory() as folder:  # Rerun reads URDF from files only
        path = Path(folder) / "arm.urdf"
        path.write_text(urdf_text(model), encoding="utf-8")
        return rerun.urdf.UrdfTree.from_file_path(
            path,
            name,
            frame_prefix=f"{name}/",
            static_transform_entity_path=rr.new_entity_path([name, "fixed"]),
        )
