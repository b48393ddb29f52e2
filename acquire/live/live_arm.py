"""The arm of a live view: each link in the colour of the joint that moves it."""

from collections.abc import Sequence

import numpy as np
import rerun as rr

from exidyn.identify.arm.link_frames import link_frames, link_poses
from exidyn.identify.model import Model
from exidyn.identify.pages.views.view_arm import log_solid
from exidyn.identify.pages.views.view_parts import TIMELINE

ARM = "arm"


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
        log_solid(recording, model, name, colours)

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
