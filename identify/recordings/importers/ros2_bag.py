"""ROS 2 bags with sensor_msgs/msg/JointState, through the package rosbags (extra `exidyn[ros2]`)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import NotAFile, NotRecorded, RecordingError
from ...model import Model
from ...notebook import optional
from ..mcap.mcap_topics import ARRAY_TOPICS
from ..optional_signals import without_damaged
from ..recording import EFFORT, KnownPayload, Recording, Signal
from ..recording_checks import check
from .tables.columns import find_joints
from .tables.table import refused_as

STATE, ARRAY = "sensor_msgs/msg/JointState", "std_msgs/msg/Float64MultiArray"


@dataclass
class _Samples:
    """Messages of one topic and one list of joints: stamps [ns] by the bag and by the message, and rows."""

    width: int
    bag: list[int] = field(default_factory=list)
    stamp: list[int] = field(default_factory=list)
    rows: dict[str, list[np.ndarray]] = field(default_factory=dict)

    def add(self, bag: int, stamp: int, **values: np.ndarray) -> None:
        """One more message; a field that it lacks is NaN, and `check` drops such samples."""
        self.bag.append(bag)
        self.stamp.append(stamp)
        silent = np.full(self.width, np.nan)
        for name, row in values.items():
            if len(row) not in (0, self.width):
                raise RecordingError(f"{name} has {len(row)} values, but there are {self.width} joints")
            rows = self.rows.setdefault(name, [silent] * (len(self.bag) - 1))
            rows.append(np.asarray(row, float) if len(row) else silent)

    def signals(self, time: np.ndarray, places: Sequence[int] | slice = slice(None)) -> dict[str, Signal]:
        """Signals of those joints at these times; a field that no message has is none."""
        arrays = {name: np.array(rows)[:, places] for name, rows in self.rows.items()}
        return {n: Signal(time, a) for n, a in arrays.items() if n == "position" or not np.isnan(a).all()}


def import_ros2_bag(
    source: Path,
    model: Model | None = None,
    topic: str | None = None,
    joints: str | Sequence[str] | None = None,
    effort: str = "torque",
    payload: KnownPayload | None = None,
) -> list[Recording]:
    """Import joint states, and motor currents and the like from the topics that exidyn's own files have.

    Args:
        source: The bag's folder, or its .mcap or .db3 file.
        model: The nominal robot; its joints are looked up by name.
        topic: Topic of the joint states; needed if there are several.
        joints: What the joints are called in the bag: one name a joint, or a pattern such as "left_{joint}".
        effort: What the field effort holds, "torque" or "current".
        payload: What hung on the flange.

    Raises:
        RecordingError: The bag cannot be read or does not hold a run of this robot.
        MissingPackage: rosbags is not installed.
    """
    if model is None:
        raise RecordingError(
            f"{source}: a bag does not describe its robot; give the robot too (--robot FILE)"
        )
    if effort not in EFFORT:
        raise RecordingError(f"effort (--effort) '{effort}': valid are {', '.join(EFFORT)}")
    groups, arrays = _read(_folder(source), topic, effort)
    names = find_joints(
        model.robot, tuple(dict.fromkeys(name for group in groups for name in group)), joints, f"{source}"
    )
    chosen = {group: samples for group, samples in groups.items() if set(names) <= set(group)}
    if len(chosen) != 1:
        raise RecordingError(
            f"{source}: {len(chosen)} lists of joints in its messages have {', '.join(names)}; one is needed"
        )
    [(group, states)] = chosen.items()
    _require_positions(source, states)
    # The controller's own stamps count, if it gives any; the bag's are those of the host.
    own = np.array(states.stamp if any(states.stamp) else states.bag)
    start, late = own[0], states.bag[0] - own[0]
    signals = states.signals((own - start) * 1e-9, [group.index(name) for name in names])
    for samples in arrays.values():
        signals |= samples.signals((np.array(samples.bag) - late - start) * 1e-9)
    recording = Recording(
        name=source.stem,
        model=model,
        signals=signals,
        payload=payload,
        settings={"source": source.name},
        host_time=np.array(states.bag),
    )
    return [check(without_damaged(recording))]


def _require_positions(source: Path, states: _Samples) -> None:
    """Make sure that the joint states are of an arm whose positions were sent.

    Raises:
        NotRecorded: No message has them.
    """
    if np.isnan(states.rows["position"]).all():
        sent = [name for name, rows in states.rows.items() if not np.isnan(rows).all()]
        raise NotRecorded(
            f"{source}: the messages have no positions: of {len(states.bag)} joint states the field position "
            f"is empty in all; there: {' and '.join(sent) or 'nothing'}. Record a topic with positions, or "
            "name it: --topic TOPIC"
        )


def joints_of_bag(source: Path, topic: str | None = None) -> list[str]:
    """Names of all joints in the joint states of a bag.

    Raises:
        RecordingError: The bag cannot be read, or has several topics of joint states.
        MissingPackage: rosbags is not installed.
    """
    groups, _ = _read(_folder(source), topic, EFFORT[0])
    return list(dict.fromkeys(name for group in groups for name in group))


def _folder(source: Path) -> Path:
    """Of a .db3 file its folder, as a bag may have several files; the file where there is no metadata."""
    whole = source.suffix == ".db3" and (source.parent / "metadata.yaml").exists()
    return source.parent if whole else source


def _read(
    source: Path, topic: str | None, effort: str
) -> tuple[dict[tuple[str, ...], _Samples], dict[str, _Samples]]:
    """Joint states by the names in the message, as several nodes may share a topic; arrays by topic."""
    highlevel = optional("rosbags.highlevel", "a ROS 2 bag", "ros2")
    typesys = optional("rosbags.typesys", "a ROS 2 bag", "ros2")
    groups: dict[tuple[str, ...], _Samples] = {}
    arrays: dict[str, _Samples] = {}
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    with (
        refused_as(source, "a ROS 2 bag"),
        highlevel.AnyReader([source], default_typestore=store) as reader,
    ):
        chosen = _connections(source, reader.connections, topic)
        for connection, bag, raw in reader.messages(connections=chosen):
            message = reader.deserialize(raw, connection.msgtype)
            if connection.msgtype == STATE:
                order = np.argsort(message.name)  # which may differ from message to message
                names = tuple(message.name[place] for place in order)
                fields = {"position": message.position, "velocity": message.velocity}
                fields[effort] = message.effort
                rows = {n: row[order] if len(row) == len(order) else row for n, row in fields.items()}
                stamp = message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec
                groups.setdefault(names, _Samples(len(names))).add(bag, stamp, **rows)
            else:
                signal = next(n for n, topic in ARRAY_TOPICS.items() if topic == connection.topic)
                samples = arrays.setdefault(connection.topic, _Samples(len(message.data)))
                samples.add(bag, 0, **{signal: message.data})
    if not groups:
        raise NotAFile(f"{source}: there is not one joint state in it")
    return groups, arrays


def _connections(source: Path, connections: Sequence[Any], topic: str | None) -> list[Any]:
    """Those to read: one topic of joint states, and the arrays."""
    states = [connection for connection in connections if connection.msgtype == STATE]
    names = sorted({connection.topic for connection in states})
    topic = topic or (names[0] if len(names) == 1 else "/joint_states")
    if topic not in names:
        raise RecordingError(
            f"{source}: no joint states on {topic}. Topics with joint states: {', '.join(names) or 'none'}; "
            "choose one by --topic TOPIC"
        )
    arrays = [c for c in connections if c.msgtype == ARRAY and c.topic in ARRAY_TOPICS.values()]
    return [connection for connection in states if connection.topic == topic] + arrays
