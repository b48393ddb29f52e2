"""Writing a recording message by message, while it happens or afterwards."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import IO, NamedTuple

import numpy as np
import pinocchio as pin
from mcap.writer import CompressionType, Writer

from ...arm.newton_euler import link_frames, link_poses
from ...model import Model
from ...robot_files.robot_file import model_text, urdf_text
from ..recording import KnownPayload
from . import cdr
from .mcap_topics import DESCRIPTION, Topic, nanoseconds

FORMAT = "1"
EPOCH = 1_577_836_800_000_000_000
"""Controller time zero where no host clock was recorded [ns]: 2020-01-01, so that viewers show a date."""

CHUNK = 128 * 1024
"""Bytes before compression that a crash can cost: about 0.3 s of six joints at 500 Hz."""
TRANSFORM_RATE = 50.0
"""Poses of the links a second, enough for the eye [1/s]."""


@dataclass(frozen=True)
class Head:
    """What stands at the beginning of a file.

    Attributes:
        name: What people call the run.
        model: The nominal robot, with its effects.
        payload: What hangs on the flange.
        trajectory: Text of the trajectory's file.
        settings: Whatever else explains the run.
        warnings: Warnings that are known already.
        epoch: Host's clock at controller time zero [ns].
        host_clock: Whether log_time is a recorded host clock.
        samples: Samples of each signal that will follow; a file that ends early then shows what is missing.
            Empty, or zero for a signal of unknown length, while recording.
    """

    name: str
    model: Model
    payload: KnownPayload | None = None
    trajectory: str = ""
    settings: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    epoch: int = EPOCH
    host_clock: bool = False
    samples: Mapping[str, int] = field(default_factory=dict)

    def record(self) -> dict[str, str]:
        """The metadata record "exidyn"."""
        payload = {"name": self.payload.name, "known": self.payload.known} if self.payload else None
        return {
            "format": FORMAT,
            "name": self.name,
            "epoch_ns": str(self.epoch),
            "host_clock": json.dumps(self.host_clock),
            "payload": json.dumps(payload),
            "samples": json.dumps(dict(self.samples)),
            "warnings": json.dumps(self.warnings),
        }


class RecordingWriter:
    """Writes one file, message by message; a context manager that finishes the file.

    `start` is the time of the first message [ns since 1970], the head's epoch by default.
    """

    def __init__(self, stream: IO[bytes], head: Head, start: int | None = None) -> None:
        self.head = head
        self.joints = head.model.robot.joints
        self._writer = Writer(stream, chunk_size=CHUNK, compression=CompressionType.LZ4)
        self._writer.start(profile="ros2", library="exidyn")
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._explain(head.epoch if start is None else start)

    def _explain(self, start: int) -> None:
        urdf = urdf_text(self.head.model)
        self._writer.add_metadata("exidyn", self.head.record())
        self._writer.add_metadata("settings", dict(self.head.settings))
        self._attach("robot.toml", "application/toml", model_text(self.head.model))
        self._attach("robot.urdf", "application/xml", urdf)
        if self.head.trajectory:
            self._attach("trajectory", "text/plain", self.head.trajectory)
        self.write(DESCRIPTION, cdr.text_message(urdf), start, start)

    def _attach(self, name: str, kind: str, text: str) -> None:
        self._writer.add_attachment(0, 0, name, kind, text.encode())

    def add_topic(self, topic: Topic) -> int:
        """Announce a topic with its units and joints, before its first message; the channel's number."""
        if topic.schema not in self._schemas:
            definition = cdr.SCHEMAS[topic.schema].encode()
            self._schemas[topic.schema] = self._writer.register_schema(topic.schema, "ros2msg", definition)
        if topic.name not in self._channels:
            self._channels[topic.name] = self._writer.register_channel(
                topic.name, "cdr", self._schemas[topic.schema], topic.metadata(self.joints)
            )
        return self._channels[topic.name]

    def write(self, topic: Topic, message: bytes, published: int, logged: int) -> None:
        """Write one message, with the controller's and the host's clock [ns since 1970]."""
        channel = self._channels.get(topic.name) or self.add_topic(topic)
        self._writer.add_message(channel, logged, message, published)

    def flush(self) -> None:
        """Hand all that was written to the file: a crash costs what came after."""
        self._writer.flush()

    def add_outcome(self, outcome: Mapping[str, str]) -> None:
        """Write how the run ended; nothing, if that is unknown."""
        if outcome:
            self._writer.add_metadata("outcome", dict(outcome))

    def finish(self) -> None:
        """Write the index that viewers look for."""
        self._writer.finish()

    def __enter__(self) -> "RecordingWriter":
        return self

    def __exit__(self, *_: object) -> None:
        self.finish()


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
