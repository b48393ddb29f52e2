"""Messages of several topics, merged into a file in the order in which they were recorded."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ...arm.link_frames import link_frames, link_poses
from . import cdr
from .mcap_topics import Topic, nanoseconds
from .mcap_writer import RecordingWriter

TRANSFORM_RATE = 50.0
"""Poses of the links a second, enough for the eye [1/s]."""


class Stream(NamedTuple):
    """Messages of one topic.

    Attributes:
        topic: Which.
        published: Controller's clock, shape (t,) [ns since 1970].
        logged: Host's clock, shape (t,) [ns since 1970].
        messages: Shape (t,), whatever has `tobytes`.
    """

    topic: Topic
    published: np.ndarray
    logged: np.ndarray
    messages: np.ndarray


def write_merged(streams: Sequence[Stream], writer: RecordingWriter) -> None:
    """All topics, in the order of the host's clock."""
    for stream in streams:
        writer.add_topic(stream.topic)
    which = np.concatenate([np.full(len(stream.logged), number) for number, stream in enumerate(streams)])
    row = np.concatenate([np.arange(len(stream.logged)) for stream in streams])
    for place in np.argsort(np.concatenate([stream.logged for stream in streams]), kind="stable"):
        stream, index = streams[which[place]], row[place]
        message = stream.messages[index].tobytes()
        writer.write(stream.topic, message, int(stream.published[index]), int(stream.logged[index]))


def of_any_length(messages: Sequence[bytes]) -> np.ndarray:
    """Messages that are not all of one length, shape (t,)."""
    array = np.empty(len(messages), object)
    array[:] = [memoryview(message) for message in messages]
    return array


def ticks(time: np.ndarray) -> np.ndarray:
    """Number of the pose shown last at each time (t,) [s]; a new one wherever it changes."""
    return np.floor(time * TRANSFORM_RATE)


def pose_messages(kinematics: pin.Model, time: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Where the links are at times (t,) [s] and positions (t, n), as messages of /tf, shape (t,)."""
    frames = link_frames(kinematics)
    records = np.repeat(cdr.transforms([(frame.parent, frame.child) for frame in frames]), len(time))
    poses = link_poses(kinematics, position)
    for which in range(len(frames)):
        cdr.set_stamp(records, f"stamp{which}", nanoseconds(time))
        records[f"pose{which}"] = poses[:, which]
    return records
