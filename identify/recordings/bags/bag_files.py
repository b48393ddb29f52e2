"""Messages of bags in all formats: ROS 1 (.bag), ROS 2 (.db3, .mcap, folder), MCAP of other tools.

The package rosbags reads .bag and .db3 files, and decodes messages of ROS. The package mcap reads MCAP files,
since they come from many tools and may have been cut off by a recorder that crashed.
"""

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Channel, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader

from ...notebook import optional
from ..tables.table import refused_as
from .joint_messages import ARRAY, DYNAMIC_JOINT_STATE, JOINT_READERS, JSON, read_json

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
        reader = optional(f"rosbags.rosbag{1 if first else 2}", "a ROS bag", "ros2").Reader(file)
        with reader:
            chosen = [connection for connection in reader.connections if self._reads(connection.msgtype)]
            self.others |= {c.topic: c.msgtype for c in reader.connections if c not in chosen}
            decoders = {
                connection.id: _decoder(
                    connection.msgtype, "ros1" if first else "cdr", connection.msgdef.data,
                    connection.msgdef.format.name == "IDL",
                )
                for connection in chosen
            }  # fmt: skip
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
