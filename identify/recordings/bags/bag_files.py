"""Messages of bags in all formats: ROS 1 (.bag), ROS 2 (.db3, .mcap, folder), MCAP of other tools.

The package rosbags reads .bag and .db3 files, and decodes messages of ROS. The package mcap reads MCAP files,
since they come from many tools and may have been cut off by a recorder that crashed. Joint states are in
messages of several types; their `effort` may be a torque or a current, which the import states.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Channel, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader

from ...notebook import optional
from ..tables.rows import NAMES, stamp_of
from ..tables.table import refused_as

ARRAY = "std_msgs/msg/Float64MultiArray"
JSON = "JSON"
"""Type of messages that are JSON objects."""
INTERFACES = ("position", "velocity", "effort", "torque", "current", "temperature")
"""Interfaces of a DynamicJointState that are read, each as a field of the same name."""
DYNAMIC_JOINT_STATE = """std_msgs/Header header
string[] joint_names
control_msgs/InterfaceValue[] interface_values
================================================================================
MSG: control_msgs/InterfaceValue
string[] interface_names
float64[] values
"""
"""Definition of the type in bags from before ROS 2 Iron, which do not contain definitions."""

FIELDS = {
    "position": ("position", "positions"),
    "velocity": ("velocity", "velocities"),
    "effort": ("effort", "efforts"),
}


class JointMessage(NamedTuple):
    """Joint states of one message."""

    names: Sequence[str]  # names of the joints
    # Field -> values in the order of the names; the message may have too few or too many.
    fields: Mapping[str, Sequence[float]]
    stamp: int  # time stamp of the message [ns]; 0 if it has none


def _stamp(message: Any) -> int:
    return int(message.header.stamp.sec) * 1_000_000_000 + int(message.header.stamp.nanosec)


def _joint_state(message: Any) -> JointMessage:
    fields = {name: getattr(message, name) for name in ("position", "velocity", "effort")}
    return JointMessage(message.name, fields, _stamp(message))


def _dynamic_joint_state(message: Any) -> JointMessage:
    """Joint states of a message in which each joint lists its interfaces; NaN if a joint lacks one."""
    values = [
        dict(zip(joint.interface_names, joint.values, strict=False)) for joint in message.interface_values
    ]
    fields = {name: [joint.get(name, float("nan")) for joint in values] for name in INTERFACES}
    return JointMessage(message.joint_names, fields, _stamp(message))


def _controller_state(message: Any) -> JointMessage:
    """Measured and commanded states, each of which has two names in different versions of the message."""
    measured = _first(message, "feedback", "actual")
    commanded = _first(message, "reference", "desired")
    fields = {
        "position": measured.positions,
        "velocity": measured.velocities,
        "effort": measured.effort,
        "command": commanded.positions,
        "command_velocity": commanded.velocities,
    }
    return JointMessage(message.joint_names, fields, _stamp(message))


def _first(message: Any, *names: str) -> Any:
    """The first of several trajectory points that has positions."""
    points = [getattr(message, name) for name in names if hasattr(message, name)]
    return next((point for point in points if len(point.positions)), points[0])


JOINT_READERS: dict[str, Callable[[Any], JointMessage]] = {
    "sensor_msgs/msg/JointState": _joint_state,
    "control_msgs/msg/DynamicJointState": _dynamic_joint_state,
    "control_msgs/msg/JointTrajectoryControllerState": _controller_state,
}
"""Type of a message -> function that reads joint states; the first type in a bag is preferred."""


def read_json(content: Any) -> JointMessage | None:
    """Joint states in a JSON object, like a JointState or as a list of joints; None if there are none."""
    if not isinstance(content, Mapping):
        return None
    joints = next((content[key] for key in NAMES if isinstance(content.get(key), list)), None)
    if not joints:
        return None
    if all(isinstance(joint, Mapping) for joint in joints):
        names = [next((joint[key] for key in NAMES if key in joint), "") for joint in joints]
        fields = {field: [_number(_value(joint, keys)) for joint in joints] for field, keys in FIELDS.items()}
    else:
        names = joints
        fields = {field: _numbers(_value(content, keys)) for field, keys in FIELDS.items()}
    if not all(isinstance(name, str) and name for name in names) or not any(fields.values()):
        return None
    header = content.get("header")
    stamp = _value(header if isinstance(header, Mapping) else content, ("stamp", "timestamp", "time"))
    return JointMessage(names, fields, (stamp_of(stamp) if isinstance(stamp, Mapping) else None) or 0)


def _value(content: Mapping[str, Any], keys: Sequence[str]) -> Any:
    return next((content[key] for key in keys if key in content), None)


def _numbers(values: Any) -> list[float]:
    return [_number(value) for value in values] if isinstance(values, list) else []


def _number(value: Any) -> float:
    """Number of a JSON value; NaN if it is not a number, such as null."""
    return float(value) if isinstance(value, int | float) else float("nan")


WANTED = (*JOINT_READERS, ARRAY)
"""Types of messages that are decoded."""
IDL = re.compile(r"=+\nIDL: .*\n")
"""Text before each type in a definition in IDL."""


class BagMessage(NamedTuple):
    """A message of a bag."""

    topic: str  # name of the topic
    kind: str  # type of the message in ROS 2; `JSON` for a JSON object
    received: int  # time at which the bag received the message [ns]
    content: Any  # joint states (`JointMessage`), the numbers of an array, or another message


Decoder = Callable[[bytes], Any]
"""Function from the bytes of a message to the content of a `BagMessage`."""


class Bag:
    """A bag in a file or folder; with `others`, of all messages but those of the types in `WANTED`."""

    def __init__(self, source: Path, others: bool = False) -> None:
        self.source, self._others = source, others
        # Complete once all messages are read.
        self.others: dict[str, str] = {}  # topics that are not read -> type of their messages
        self.notes: list[str] = []  # sentences about lost parts of the bag

    def messages(self) -> Iterator[BagMessage]:
        """All messages with joint states or arrays of numbers; or those of other types."""
        with refused_as(self.source, "a ROS bag"):
            for file in _files(self.source):
                yield from self._of_mcap(file) if file.suffix.lower() == ".mcap" else self._of_rosbags(file)

    def _reads(self, kind: str) -> bool:
        return (kind in WANTED) != self._others

    def _of_rosbags(self, file: Path) -> Iterator[BagMessage]:
        first = file.is_file() and ".bag" in map(str.lower, file.suffixes)
        encoding, version = ("ros1", 1) if first else ("cdr", 2)
        with optional(f"rosbags.rosbag{version}", "a ROS bag", "ros2").Reader(file) as reader:
            chosen = [connection for connection in reader.connections if self._reads(connection.msgtype)]
            self.others |= {c.topic: c.msgtype for c in reader.connections if c not in chosen}
            decoders = {
                c.id: _decoder(c.msgtype, encoding, c.msgdef.data, c.msgdef.format.name == "IDL")
                for c in chosen
            }
            for connection, received, raw in reader.messages(connections=chosen) if chosen else ():
                if (content := decoders[connection.id](raw)) is not None:
                    yield BagMessage(connection.topic, connection.msgtype, received, content)

    def _of_mcap(self, file: Path) -> Iterator[BagMessage]:
        schemas: dict[int, Schema] = {}
        channels: dict[int, tuple[Channel, str, Decoder | None]] = {}
        for record in self._records(file):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel) and record.id not in channels:
                channels[record.id] = (record, *self._mcap_decoder(record, schemas.get(record.schema_id)))
            elif isinstance(record, Message) and record.channel_id in channels:
                channel, kind, decode = channels[record.channel_id]
                content = decode(record.data) if decode else None
                if content is None:
                    self.others.setdefault(channel.topic, kind)
                else:
                    yield BagMessage(channel.topic, kind, record.log_time, content)

    def _records(self, file: Path) -> Iterator[McapRecord]:
        """All records of an MCAP file, up to the place where it is cut off."""
        with open(file, "rb") as stream:
            try:
                yield from StreamReader(stream).records
            except MemoryError:
                raise
            except Exception:  # the type depends on the record that is cut off
                if stream.read(1):
                    raise
                self.notes.append(
                    f"{file.name} ends abruptly: its recorder crashed or its copy was cut off. The part "
                    "before the end is read"
                )

    def _mcap_decoder(self, channel: Channel, schema: Schema | None) -> tuple[str, Decoder | None]:
        """Type of the messages of a channel, and their decoder; None for messages that are not read."""
        name, encoding = (schema.name, schema.encoding) if schema else ("", "")
        if channel.message_encoding == "json":
            return JSON, lambda data: json.loads(data) if self._others else read_json(json.loads(data))
        package, _, kind = name.partition("/")
        kind = f"{package}/msg/{kind.rpartition('/')[2]}"
        if self._reads(kind) and schema and channel.message_encoding in ("cdr", "ros1"):
            text = schema.data.decode()
            return kind, _decoder(kind, channel.message_encoding, text, encoding in ("ros2idl", "omgidl"))
        return f"{name or 'unknown type'} in {channel.message_encoding}", None


def _files(source: Path) -> list[Path]:
    """Files of a bag, each with its own messages; the folder itself if its metadata names them."""
    files = sorted(source.glob("*.mcap"))
    if not files and not (source / "metadata.yaml").exists():
        files = sorted(source.glob("*.db3"))
    return files or [source]


def _decoder(kind: str, encoding: str, text: str, idl: bool) -> Decoder:
    """Decoder of messages of one type; `encoding` is "ros1", or "cdr" for ROS 2.

    `text` is the definition of the type and its parts, in IDL if `idl`; empty in bags from before ROS 2 Iron.
    Messages whose type is unknown then, or whose definition cannot be read, are None.
    """
    try:
        store = _types(kind, text, idl)
    except Exception:
        if kind in WANTED:
            raise
        return lambda data: None
    deserialize = store.deserialize_ros1 if encoding == "ros1" else store.deserialize_cdr
    if kind not in store.types:
        return lambda data: None
    if kind == ARRAY:
        return lambda data: deserialize(data, kind).data
    read = JOINT_READERS.get(kind, lambda message: message)
    return lambda data: read(deserialize(data, kind))


def _types(kind: str, text: str, idl: bool) -> Any:
    """Type store of rosbags with the types of a message."""
    typesys = optional("rosbags.typesys", "a ROS bag", "ros2")
    if not text:
        store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        dynamic = typesys.get_types_from_msg(DYNAMIC_JOINT_STATE, "control_msgs/msg/DynamicJointState")
        store.register(dynamic)
        return store
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    types: dict[str, Any] = {}
    if idl:
        for part in filter(str.strip, IDL.split(text)):
            types |= typesys.get_types_from_idl(part)
    else:
        types = typesys.get_types_from_msg(text, kind)
    store.register(types)
    return store
