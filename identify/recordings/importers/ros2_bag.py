"""ROS 2 bags with sensor_msgs/msg/JointState, through the package rosbags (extra `exidyn[ros2]`)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...arm.robot import Robot
from ...errors import ExidynError, NotAFile, RecordingError, UnknownJoint
from ...model import Model
from ..mcap.mcap_topics import ARRAY_TOPICS
from ..recording import KnownPayload, Recording, Signal
from ..recording_checks import check

STATE, ARRAY = "sensor_msgs/msg/JointState", "std_msgs/msg/Float64MultiArray"


@dataclass
class _Samples:
    """Content of one topic: stamps [ns] by the bag and by the message, and rows by signal."""

    bag: list[int] = field(default_factory=list)
    stamp: list[int] = field(default_factory=list)
    rows: dict[str, list[np.ndarray]] = field(default_factory=dict)


def import_ros2_bag(
    source: Path,
    model: Model | None = None,
    topic: str | None = None,
    effort: str = "torque",
    payload: KnownPayload | None = None,
) -> list[Recording]:
    """Import joint states, and motor currents and the like from the topics that exidyn's own files have.

    Args:
        source: The bag's folder, or its .mcap or .db3 file.
        model: The nominal robot; its joints are looked up by name.
        topic: Topic of the joint states; needed if there are several.
        effort: What the field effort holds, "torque" or "current".
        payload: What hung on the flange.

    Raises:
        RecordingError: The bag cannot be read or does not hold a run of this robot; or rosbags is missing.
    """
    if model is None:
        raise RecordingError(
            f"{source}: a bag does not describe its robot; give the robot too (--robot FILE)"
        )
    if effort not in ("torque", "current"):
        raise RecordingError(f"effort='{effort}': valid are torque, current")
    folder = source.parent if source.suffix == ".db3" else source
    topics = _read(folder, model.robot, topic, effort)
    states = topics.pop(STATE)
    # The controller's own stamps count, if it gives any; the bag's are those of the host.
    own = np.array(states.stamp if any(states.stamp) else states.bag)
    start, late = own[0], states.bag[0] - own[0]
    time = (own - start) * 1e-9
    signals = {name: Signal(time, np.array(rows)) for name, rows in states.rows.items()}
    for samples in topics.values():
        at = (np.array(samples.bag) - late - start) * 1e-9
        signals |= {name: Signal(at, np.array(rows)) for name, rows in samples.rows.items()}
    recording = Recording(
        name=source.stem,
        model=model,
        signals=signals,
        payload=payload,
        settings={"source": source.name},
        host_time=np.array(states.bag),
    )
    return [check(recording)]


def _read(source: Path, robot: Robot, topic: str | None, effort: str) -> dict[str, _Samples]:
    """Samples of the joint states, under `STATE`, and of each array topic."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise RecordingError(
            'ROS 2 bags need the package rosbags. In the folder of exidyn: pip install ".[ros2]"'
        ) from error
    try:
        with AnyReader([source], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            chosen = _connections(source, reader.connections, topic)
            found: dict[str, _Samples] = {STATE: _Samples()}
            for connection, bag, raw in reader.messages(connections=chosen):
                message = reader.deserialize(raw, connection.msgtype)
                if connection.msgtype == STATE:
                    _take_state(found[STATE], robot, bag, message, effort)
                else:
                    samples = found.setdefault(connection.topic, _Samples())
                    _take_array(samples, robot, bag, message, connection.topic)
    except ExidynError:
        raise
    except Exception as error:  # the library raises many kinds, of its own and of its parsers
        raise NotAFile(f"{source} cannot be read as a ROS 2 bag: {error}") from error
    if not found[STATE].bag:
        raise NotAFile(f"{source}: there is not one joint state in it")
    return found


def _connections(source: Path, connections: Sequence[Any], topic: str | None) -> list[Any]:
    """Those to read: one topic of joint states, and the arrays."""
    states = [connection for connection in connections if connection.msgtype == STATE]
    names = sorted({connection.topic for connection in states})
    topic = topic or (names[0] if len(names) == 1 else "/joint_states")
    if topic not in names:
        raise RecordingError(
            f"{source}: no joint states on {topic}. Topics with joint states: {', '.join(names) or 'none'}"
        )
    arrays = [c for c in connections if c.msgtype == ARRAY and c.topic in ARRAY_TOPICS.values()]
    return [connection for connection in states if connection.topic == topic] + arrays


def _take_state(samples: _Samples, robot: Robot, bag: int, message: Any, effort: str) -> None:
    missing = [joint for joint in robot.joints if joint not in message.name]
    if missing:
        raise UnknownJoint(missing[0], "the bag's joint state", tuple(message.name))
    places = [message.name.index(joint) for joint in robot.joints]
    samples.bag.append(bag)
    samples.stamp.append(message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec)
    for name, values in (
        ("position", message.position),
        ("velocity", message.velocity),
        (effort, message.effort),
    ):
        if len(values) or name in samples.rows or name == "position":
            _append(samples, name, robot, values[places] if len(values) else values)


def _take_array(samples: _Samples, robot: Robot, bag: int, message: Any, topic: str) -> None:
    name = next(name for name, its_topic in ARRAY_TOPICS.items() if its_topic == topic)
    samples.bag.append(bag)
    _append(samples, name, robot, message.data)


def _append(samples: _Samples, name: str, robot: Robot, values: np.ndarray) -> None:
    """One more row; samples that lacked a field are NaN throughout, and `check` drops them."""
    silent = np.full(robot.dof, np.nan)
    rows = samples.rows.setdefault(name, [silent] * (len(samples.bag) - 1))
    if len(values) not in (0, robot.dof):
        raise RecordingError(f"{name} has {len(values)} values, but {robot.name} has {robot.dof} joints")
    rows.append(np.asarray(values, float) if len(values) else silent)
