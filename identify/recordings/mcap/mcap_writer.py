"""Writing a recording message by message, while it happens or afterwards."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import IO, NamedTuple

import numpy as np
import pinocchio as pin
from mcap.writer import CompressionType, Writer
from msgspec import to_builtins

from ...arm.newton_euler import link_frames, link_poses
from ...model import Model
from ...robot_files.robot_file import model_text, urdf_text
from ..recording import KnownPayload
from . import cdr
from .mcap_topics import DESCRIPTION, Topic, nanoseconds

FORMAT = "1"
EPOCH = 1_577_836_800_000_000_000
"""Controller time zero if no host clock was recorded [ns]: 2020-01-01, so that viewers show a date."""

CHUNK = 128 * 1024
"""Maximum loss in a crash, before compression [B]: about 0.3 s of six joints at 500 Hz."""
TRANSFORM_RATE = 50.0
"""Rate of the poses of the links, enough for the eye [Hz]."""


@dataclass(frozen=True)
class Head:
    """Description at the beginning of a file."""

    name: str  # name of the run
    model: Model  # nominal model
    payload: KnownPayload | None = None  # payload on the flange
    trajectory: str = ""  # text of the trajectory's file
    settings: Mapping[str, str] = field(default_factory=dict)  # further information about the run
    warnings: tuple[str, ...] = ()  # warnings before the run
    epoch: int = EPOCH  # host clock at controller time zero [ns]
    host_clock: bool = False  # whether log_time is a recorded host clock
    # Number of samples of each signal that will follow, which shows losses of a file that ends early. While
    # recording it is empty, or zero for a signal of unknown length.
    samples: Mapping[str, int] = field(default_factory=dict)

    def record(self) -> dict[str, str]:
        """Metadata record "exidyn"."""
        return {
            "format": FORMAT,
            "name": self.name,
            "epoch_ns": str(self.epoch),
            "host_clock": json.dumps(self.host_clock),
            "payload": json.dumps(to_builtins(self.payload, enc_hook=float)),
            "samples": json.dumps(dict(self.samples)),
            "warnings": json.dumps(self.warnings),
        }


class RecordingWriter:
    """Writer of one file, message by message; as a context manager it finishes the file.

    `start` is the time of the first message [ns since 1970], by default the epoch of the head.
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
        """Register a topic with its units and joints, before its first message; return the channel number."""
        if topic.schema not in self._schemas:
            definition = cdr.SCHEMAS[topic.schema].encode()
            self._schemas[topic.schema] = self._writer.register_schema(topic.schema, "ros2msg", definition)
        if topic.name not in self._channels:
            self._channels[topic.name] = self._writer.register_channel(
                topic.name, "cdr", self._schemas[topic.schema], topic.metadata(self.joints)
            )
        return self._channels[topic.name]

    def write(self, topic: Topic, message: bytes, published: int, logged: int) -> None:
        """Write one message, with the times of the controller and of the host [ns since 1970]."""
        channel = self._channels.get(topic.name) or self.add_topic(topic)
        self._writer.add_message(channel, logged, message, published)

    def flush(self) -> None:
        """Write all messages to the file, so that a crash can lose only later messages."""
        self._writer.flush()

    def add_outcome(self, outcome: Mapping[str, str]) -> None:
        """Write the outcome of the run, unless it is unknown."""
        if outcome:
            self._writer.add_metadata("outcome", dict(outcome))

    def finish(self) -> None:
        """Write the index that viewers need."""
        self._writer.finish()

    def __enter__(self) -> "RecordingWriter":
        return self

    def __exit__(self, *_: object) -> None:
        self.finish()


class Stream(NamedTuple):
    """Messages of one topic."""

    topic: Topic  # topic of the messages
    published: np.ndarray  # controller clock, shape (t,) [ns since 1970]
    logged: np.ndarray  # host clock, shape (t,) [ns since 1970]
    messages: np.ndarray  # objects with a method `tobytes`, shape (t,)


def write_merged(streams: Sequence[Stream], writer: RecordingWriter) -> None:
    """Write the messages of all topics, in the order of the host clock."""
    for stream in streams:
        writer.add_topic(stream.topic)
    stream_of = np.concatenate([np.full(len(stream.logged), number) for number, stream in enumerate(streams)])
    row = np.concatenate([np.arange(len(stream.logged)) for stream in streams])
    for place in np.argsort(np.concatenate([stream.logged for stream in streams]), kind="stable"):
        stream, index = streams[stream_of[place]], row[place]
        message = stream.messages[index].tobytes()
        writer.write(stream.topic, message, int(stream.published[index]), int(stream.logged[index]))


def of_any_length(messages: Sequence[bytes]) -> np.ndarray:
    """Messages of different lengths as an array, shape (t,)."""
    array = np.empty(len(messages), object)
    array[:] = [memoryview(message) for message in messages]
    return array


def ticks(time: np.ndarray) -> np.ndarray:
    """Number of the latest pose at each time (t,) [s]; a pose is written when it changes."""
    return np.floor(time * TRANSFORM_RATE)


def pose_messages(kinematics: pin.Model, time: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Poses of the links at times (t,) [s] and positions (t, n), as messages of /tf, shape (t,)."""
    frames = link_frames(kinematics)
    records = np.repeat(cdr.transforms([(frame.parent, frame.child) for frame in frames]), len(time))
    poses = link_poses(kinematics, position)
    for index in range(len(frames)):
        cdr.set_stamp(records, f"stamp{index}", nanoseconds(time))
        records[f"pose{index}"] = poses[:, index]
    return records
