"""ROS 2 messages as rows of numpy records: packing is a copy, unpacking a view.

A message is encoded in CDR (little endian, XCDR1). Four bytes identify the encoding. The fields follow, each
aligned to its size, counted from behind those four bytes. A string is its length including the closing zero,
followed by its bytes; a sequence is its count, followed by its elements. Joint names and counts are the same
in every message of a channel, so all its messages have the same layout and share a template of constants.
"""

import struct
from collections.abc import Iterable, Sequence
from typing import NamedTuple

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


STAMP = np.dtype([("sec", "<i4"), ("nanosec", "<u4")])
"""A time, which `set_stamp` fills."""
Part = int | bytes | tuple[str, np.dtype, int]
"""Part of a message: an unsigned number or bytes, the same in every message; or a field that is filled later,
with its name, type and alignment."""


def _template(parts: Iterable[Part]) -> np.ndarray:
    """One record of a message, shape (1,), with the constant parts in place and zeros elsewhere."""
    fields: dict[str, tuple[np.dtype, int]] = {}
    constants: dict[str, int | np.void] = {}
    size = 0
    for part in (b"\x00\x01\x00\x00", *parts):
        name, kind, alignment = f"constant{len(fields)}", np.dtype("<u4"), 4
        if isinstance(part, tuple):
            name, kind, alignment = part
        elif isinstance(part, bytes):
            kind, alignment = np.dtype(f"V{len(part)}"), 1
            constants[name] = np.void(part)
        else:
            constants[name] = part
        size += -(size - 4) % alignment
        fields[name] = kind, size
        size += kind.itemsize
    kinds, offsets = zip(*fields.values(), strict=True)
    record = np.frombuffer(
        bytearray(size),
        np.dtype({"names": list(fields), "formats": kinds, "offsets": offsets, "itemsize": size}),
    )
    for name, value in constants.items():
        record[name] = value
    return record


def _text(value: str) -> list[Part]:
    """Parts of a text."""
    data = value.encode(errors="replace") + b"\x00"
    return [len(data), data]


def _stamp(name: str) -> Part:
    return name, STAMP, 4


def _doubles(name: str, count: int) -> list[Part]:
    """Part of `count` doubles; zero doubles take no space, not even for alignment."""
    return [(name, np.dtype(("<f8", (count,))), 8)] if count else []


def joint_state(joints: Sequence[str], fields: Sequence[str]) -> np.ndarray:
    """Template of a JointState in which only `fields`, out of position, velocity and effort, are filled."""
    parts = [_stamp("stamp"), *_text(""), len(joints), *(part for joint in joints for part in _text(joint))]
    for name in ("position", "velocity", "effort"):
        count = len(joints) if name in fields else 0
        parts += [count, *_doubles(name, count)]
    return _template(parts)


def double_array(count: int) -> np.ndarray:
    """Template of a Float64MultiArray of one dimension, whose numbers are the field `data`."""
    return _template([0, 0, count, *_doubles("data", count)])


def transforms(frames: Sequence[tuple[str, str]]) -> np.ndarray:
    """Template of a TFMessage: stampK and poseK (x y z, quaternion x y z w) for each (parent, child)."""
    parts: list[Part] = [len(frames)]
    for index, (parent, child) in enumerate(frames):
        parts += [_stamp(f"stamp{index}"), *_text(parent), *_text(child), *_doubles(f"pose{index}", 7)]
    return _template(parts)


def text_message(value: str) -> bytes:
    """A std_msgs/msg/String."""
    return _template(_text(value)).tobytes()


class LogMessage(NamedTuple):
    """A rcl_interfaces/msg/Log without its line: stamp [ns], level like `INFO`, sender, text, function."""

    stamp: int
    level: int
    name: str
    text: str
    function: str


def log_message(stamp: int, level: int, name: str, text: str, function: str = "") -> bytes:
    """A rcl_interfaces/msg/Log; see `LogMessage`."""
    texts = [part for value in (name, text, "", function) for part in _text(value)]
    record = _template([_stamp("stamp"), bytes([level]), *texts, 0])
    set_stamp(record, "stamp", np.array([stamp]))
    return record.tobytes()


def read_log(message: bytes) -> LogMessage:
    """Message from `log_message` or a writer with the same byte order; ValueError if it is none."""
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
