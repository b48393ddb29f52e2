"""The arm of a live view: each link in the colour of the joint that moves it."""

from collections.abc import Sequence

import numpy as np
import rerun as rr

from exidyn.identify.arm.link_frames import link_frames, link_poses
from exidyn.identify.model import Model
from exidyn.identify.pages.views.view_arm import arm_tree
from exidyn.identify.pages.views.view_parts import TIMELINE

ARM = "arm"
GREY = (140, 140, 140)
"""Of what no joint moves, seen on dark ground and on light."""


class LiveArm:
    """Draws an arm once, and moves it.

    Args:
        recording: Where to.
        model: What the arm looks like.
        colours: One a joint.
        name: One part of an entity path, and the prefix of the link frames.
    """

    def __init__(
        self, recording: rr.RecordingStream, model: Model, colours: Sequence[tuple], name: str = ARM
    ) -> None:
        self._recording, self._kinematics, self._name = recording, model.robot.kinematics, name
        self._frames = link_frames(self._kinematics)
        tree = arm_tree(model, name)
        tree.log_urdf_to_recording(recording)
        owners = {frame.child: colour for frame, colour in zip(self._frames, colours, strict=True)}
        for link in {frame.parent for frame in self._frames} | set(owners):
            solid = rr.Cylinders3D.from_fields(colors=owners.get(link, GREY), fill_mode="solid")
            for path in tree.get_visual_geometry_paths(link):
                recording.log(path, solid, static=True)

    def move(self, time: np.ndarray, position: np.ndarray) -> None:
        """Move it along positions (t, n) at times (t,) [s]; one message for all joints, which spares half."""
        poses = link_poses(self._kinematics, position).reshape(-1, 7)
        columns = rr.Transform3D.columns(
            translation=poses[:, :3],
            quaternion=poses[:, 3:],
            parent_frame=[f"{self._name}/{frame.parent}" for frame in self._frames] * len(time),
            child_frame=[f"{self._name}/{frame.child}" for frame in self._frames] * len(time),
        )
        index = rr.TimeColumn(TIMELINE, duration=np.repeat(time, len(self._frames)))
        entity = rr.new_entity_path([self._name, "moves"])
        self._recording.send_columns(entity, indexes=[index], columns=columns)
