"""Joint states in messages of several types: names of the joints, and values of each field.

`effort` may be a torque or a current; messages do not say which, so the import states it.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from ..tables.rows import NAMES, stamp_of

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
