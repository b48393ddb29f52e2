"""Bags of every kind, from the same messages."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer

START = 1_700_000_000_000_000_000
"""When the runs begin [ns since 1970]."""
STATE = "sensor_msgs/msg/JointState"


class Sent(NamedTuple):
    """A joint state: when it was received and stamped [ns], where, and what it holds."""

    received: int
    stamp: int
    topic: str
    names: Sequence[str]
    position: Sequence[float]
    velocity: Sequence[float]
    effort: Sequence[float]


def moves(name: str, time: float) -> float:
    """Position of a joint at a time [s]."""
    return 0.6 * float(np.sin(3.0 * time + len(name) + sum(map(ord, name))))


def turns(name: str, time: float) -> float:
    """Its velocity [rad/s]."""
    return 1.8 * float(np.cos(3.0 * time + len(name) + sum(map(ord, name))))


def pulls(name: str, time: float) -> float:
    """Its effort, which changes as slowly."""
    return 5.0 * float(np.cos(2.0 * time + sum(map(ord, name))))


def sent(
    names: Sequence[str],
    rate: float = 100.0,
    late: float = 0.0,
    topic: str = "/joint_states",
    stamped: bool = True,
    duration: float = 3.0,
) -> list[Sent]:
    """Messages of some joints, at a rate [Hz] and so late after the start [s]."""
    messages = []
    for time in np.arange(round(duration * rate)) / rate + late:
        moment = START + round(1e9 * float(time))
        values = [[what(name, float(time)) for name in names] for what in (moves, turns, pulls)]
        messages.append(Sent(moment, moment if stamped else 0, topic, names, *values))
    return messages


def _types(first: bool):
    typesys = pytest.importorskip("rosbags.typesys")
    return typesys.get_typestore(typesys.Stores.ROS1_NOETIC if first else typesys.Stores.ROS2_HUMBLE)


def _message(store, message: Sent, number: int = 0):
    time = store.types["builtin_interfaces/msg/Time"](*divmod(message.stamp, 10**9))
    kind = store.types["std_msgs/msg/Header"]
    header = kind(number, time, "") if "seq" in kind.__dataclass_fields__ else kind(time, "")
    arrays = [np.array(values, float) for values in (message.position, message.velocity, message.effort)]
    return store.types[STATE](header, list(message.names), *arrays)


def write_ros2(path: Path, messages: Iterable[Sent]) -> Path:
    """A folder with a .db3 file."""
    store, rosbag2 = _types(False), pytest.importorskip("rosbags.rosbag2")
    with rosbag2.Writer(path, version=9) as writer:
        connections: dict[str, object] = {}
        for message in sorted(messages):
            if message.topic not in connections:
                connections[message.topic] = writer.add_connection(message.topic, STATE, typestore=store)
            raw = store.serialize_cdr(_message(store, message), STATE)
            writer.write(connections[message.topic], message.received, raw)
    return path


def write_ros1(path: Path, messages: Iterable[Sent]) -> Path:
    """A .bag file."""
    store, rosbag1 = _types(True), pytest.importorskip("rosbags.rosbag1")
    with rosbag1.Writer(path) as writer:
        connections: dict[str, object] = {}
        for number, message in enumerate(sorted(messages)):
            if message.topic not in connections:
                connections[message.topic] = writer.add_connection(message.topic, STATE, typestore=store)
            raw = store.serialize_ros1(_message(store, message, number), STATE)
            writer.write(connections[message.topic], message.received, raw)
    return path


def as_ros(encoding: str):
    """Schema, its encoding, and what turns a message into bytes, as an MCAP file of ROS 1 or 2 has them."""
    store = _types(encoding == "ros1")
    text, _ = store.generate_msgdef(STATE, ros_version=1 if encoding == "ros1" else 2)
    serialize = store.serialize_ros1 if encoding == "ros1" else store.serialize_cdr
    name = "sensor_msgs/JointState" if encoding == "ros1" else STATE

    def data(message: Sent) -> bytes:
        return bytes(serialize(_message(store, message), STATE))

    return name, "ros1msg" if encoding == "ros1" else "ros2msg", text.encode(), data


def as_json(names: tuple[str, str] = ("sec", "nsec")):
    """The same for JSON, with these names for the parts of a stamp."""

    def data(message: Sent) -> bytes:
        stamp = dict(zip(names, divmod(message.stamp, 10**9), strict=True))
        fields = {key: list(getattr(message, key)) for key in ("position", "velocity", "effort")}
        return json.dumps({"header": {"stamp": stamp}, "name": list(message.names), **fields}).encode()

    return "JointState", "jsonschema", b'{"type": "object"}', data


def write_mcap(path: Path, messages: Iterable[Sent], encoding: str, form, profile: str = "") -> Path:
    """An MCAP file of another writer, its messages encoded as `as_ros` or `as_json` do."""
    name, schema_encoding, schema, data = form
    with open(path, "wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD, chunk_size=20_000)
        writer.start(profile=profile, library="another")
        held = writer.register_schema(name, schema_encoding, schema)
        channels: dict[str, int] = {}
        for message in sorted(messages):
            if message.topic not in channels:
                channels[message.topic] = writer.register_channel(message.topic, encoding, held)
            received = message.received
            writer.add_message(channels[message.topic], received, data(message), received)
        writer.finish()
    return path
