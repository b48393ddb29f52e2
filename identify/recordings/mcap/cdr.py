"""ROS 2 messages as rows of numpy records: packing is a copy, unpacking a view.

A message is encoded in CDR (little endian, XCDR1). Four bytes identify the encoding. The fields follow, each
aligned to its size, counted from behind those four bytes. A string is its length including the closing zero,
followed by its bytes; a sequence is its count, followed by its elements. Joint names and counts are the same
in every message of a channel, so all its messages have the same layout and share a template of constants.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

_SEPARATOR = "=" * 80
_TIME = f"""{_SEPARATOR}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
_HEADER = f"""{_SEPARATOR}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_TIME}"""

SCHEMAS: dict[str, str] = {
    "sensor_msgs/msg/JointState": f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{_HEADER}""",
    "std_msgs/msg/Float64MultiArray": f"""std_msgs/MultiArrayLayout layout
float64[] data
{_SEPARATOR}
MSG: std_msgs/MultiArrayLayout
std_msgs/MultiArrayDimension[] dim
uint32 data_offset
{_SEPARATOR}
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
""",
    "std_msgs/msg/String": "string data\n",
    "rcl_interfaces/msg/Log": f"""byte DEBUG=10
byte INFO=20
byte WARN=30
byte ERROR=40
byte FATAL=50
builtin_interfaces/Time stamp
uint8 level
string name
string msg
string file
string function
uint32 line
{_TIME}""",
    "tf2_msgs/msg/TFMessage": f"""geometry_msgs/TransformStamped[] transforms
{_SEPARATOR}
MSG: geometry_msgs/TransformStamped
std_msgs/Header header
string child_frame_id
geometry_msgs/Transform transform
{_SEPARATOR}
MSG: geometry_msgs/Transform
geometry_msgs/Vector3 translation
geometry_msgs/Quaternion rotation
{_SEPARATOR}
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
{_SEPARATOR}
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
{_HEADER}""",
}
"""Definition of each message type in the notation that ROS 2 tools read from the file."""

INFO, WARN, ERROR = 20, 30, 40
"""Levels of a rcl_interfaces/msg/Log."""


@dataclass
class Layout:
    """Fields of a message in order, from which `template` makes a record."""

    names: list[str] = field(default_factory=list)
    formats: list[Any] = field(default_factory=list)
    offsets: list[int] = field(default_factory=list)
    constants: dict[str, Any] = field(default_factory=dict)
    size: int = 0

    def __post_init__(self) -> None:
        self._add("encapsulation", "V4", 1, b"\x00\x01\x00\x00")

    def _add(self, name: str, kind: Any, alignment: int, constant: Any = None) -> None:
        kind = np.dtype(kind)
        self.size += -(self.size - 4) % alignment
        self.names.append(name)
        self.formats.append(kind)
        self.offsets.append(self.size)
        self.size += kind.itemsize
        if constant is not None:
            self.constants[name] = constant

    def _constant(self, kind: Any, alignment: int, value: Any) -> None:
        self._add(f"constant{len(self.names)}", kind, alignment, value)

    def count(self, value: int) -> None:
        """An unsigned number that is the same in every message."""
        self._constant("<u4", 4, value)

    def text(self, value: str) -> None:
        """A string that is the same in every message."""
        data = value.encode(errors="replace") + b"\x00"
        self.count(len(data))
        self._constant(f"V{len(data)}", 1, data)

    def byte(self, value: int) -> None:
        """A small number that is the same in every message."""
        self._constant("u1", 1, value)

    def stamp(self, name: str) -> None:
        """A time, which `set_stamp` fills."""
        self._add(name, [("sec", "<i4"), ("nanosec", "<u4")], 4)

    def doubles(self, name: str, count: int) -> None:
        """`count` doubles without a preceding count; zero doubles take no space, not even for alignment."""
        if count:
            self._add(name, ("<f8", (count,)), 8)

    def sequence(self, name: str, count: int) -> None:
        """A sequence of `count` doubles."""
        self.count(count)
        self.doubles(name, count)

    def template(self) -> np.ndarray:
        """One record, shape (1,), with the constants in place and zeros elsewhere."""
        kind = np.dtype(
            {"names": self.names, "formats": self.formats, "offsets": self.offsets, "itemsize": self.size}
        )
        record = np.frombuffer(bytearray(self.size), kind)
        for name, value in self.constants.items():
            record[name] = np.void(value) if isinstance(value, bytes) else value
        return record


def joint_state(joints: Sequence[str], fields: Sequence[str]) -> np.ndarray:
    """Template of a JointState in which only `fields`, out of position, velocity and effort, are filled."""
    layout = Layout()
    layout.stamp("stamp")
    layout.text("")
    layout.count(len(joints))
    for joint in joints:
        layout.text(joint)
    for name in ("position", "velocity", "effort"):
        layout.sequence(name, len(joints) if name in fields else 0)
    return layout.template()


def double_array(count: int) -> np.ndarray:
    """Template of a Float64MultiArray of one dimension, whose numbers are the field `data`."""
    layout = Layout()
    layout.count(0)
    layout.count(0)
    layout.sequence("data", count)
    return layout.template()


def transforms(frames: Sequence[tuple[str, str]]) -> np.ndarray:
    """Template of a TFMessage: stampK and poseK (x y z, quaternion x y z w) for each (parent, child)."""
    layout = Layout()
    layout.count(len(frames))
    for index, (parent, child) in enumerate(frames):
        layout.stamp(f"stamp{index}")
        layout.text(parent)
        layout.text(child)
        layout.doubles(f"pose{index}", 7)
    return layout.template()


def text_message(value: str) -> bytes:
    """A std_msgs/msg/String."""
    layout = Layout()
    layout.text(value)
    return layout.template().tobytes()


class LogMessage(NamedTuple):
    """A rcl_interfaces/msg/Log without its line: stamp [ns], level like `INFO`, sender, text, function."""

    stamp: int
    level: int
    name: str
    text: str
    function: str


def log_message(stamp: int, level: int, name: str, text: str, function: str = "") -> bytes:
    """A rcl_interfaces/msg/Log; see `LogMessage`."""
    layout = Layout()
    layout.stamp("stamp")
    layout.byte(level)
    for value in (name, text, "", function):
        layout.text(value)
    layout.count(0)
    record = layout.template()
    set_stamp(record, "stamp", np.array([stamp]))
    return record.tobytes()


def read_log(message: bytes) -> LogMessage:
    """Message from `log_message`, or from another writer with the same byte order.

    Raises:
        ValueError: It is not such a message.
    """
    try:
        seconds, nanoseconds, level = struct.unpack_from("<iIB", message, 4)
        texts, place = [], 13
        for _ in range(4):
            place += -place % 4
            length = int.from_bytes(message[place : place + 4], "little")
            place += 4 + length
            if place > len(message):
                raise ValueError("a string goes beyond the end of its message")
            texts.append(message[place - length : place].rstrip(b"\x00").decode())
    except struct.error as error:
        raise ValueError(str(error)) from error
    name, text, _, function = texts
    return LogMessage(seconds * 1_000_000_000 + nanoseconds, level, name, text, function)


def set_stamp(records: np.ndarray, name: str, time: np.ndarray) -> None:
    """Fill the time `name` of all records from nanoseconds (t,); the seconds round down."""
    records[name]["sec"], records[name]["nanosec"] = np.divmod(time, 1_000_000_000)
