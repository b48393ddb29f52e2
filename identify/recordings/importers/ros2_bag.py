"""ROS 2 bags with sensor_msgs/msg/JointState, through the package rosbags (extra `exidyn[ros2]`).

The library decompresses whatever size a chunk, a message or a file states; it runs in a process apart.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import BadTime, NotAFile, NotRecorded, RecordingError
from ...model import Model
from ...notebook import optional
from ..mcap.mcap_topics import ARRAY_TOPICS
from ..optional_signals import without_damaged
from ..recording import EFFORT, KnownPayload, Recording, Signal
from ..recording_checks import check
from ..separate_runs import separate_runs
from .read_apart import call_reader
from .tables.columns import find_joints
from .tables.table import refused_as

LATEST = 2**63
"""Time stamps are below this [ns since 1970]."""
STATE, ARRAY = "sensor_msgs/msg/JointState", "std_msgs/msg/Float64MultiArray"


@dataclass(frozen=True)
class Samples:
    """Messages of one topic and one list of joints.

    Attributes:
        bag: Time stamps by the bag, shape (t,) [ns].
        stamp: Time stamps by the messages, shape (t,) [ns].
        rows: Field -> values of the joints, shape (t, n).
    """

    bag: np.ndarray
    stamp: np.ndarray
    rows: dict[str, np.ndarray]

    def signals(self, time: np.ndarray, places: Sequence[int] | slice = slice(None)) -> dict[str, Signal]:
        """Signals of those joints at these times; a field that no message has is none."""
        arrays = {name: rows[:, places] for name, rows in self.rows.items()}
        return {n: Signal(time, a) for n, a in arrays.items() if n == "position" or not np.isnan(a).all()}


@dataclass
class _Collected:
    """The same while messages are added; `width` is the number of joints."""

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

    def samples(self) -> Samples:
        """What was added."""
        stamps = np.array(self.bag, np.int64), np.array(self.stamp, np.int64)
        return Samples(*stamps, {name: np.array(rows) for name, rows in self.rows.items()})


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
    own = states.stamp if np.any(states.stamp) else states.bag
    start, late = own[0], states.bag[0] - own[0]
    signals = states.signals((own - start) * 1e-9, [group.index(name) for name in names])
    for samples in arrays.values():
        signals |= samples.signals((samples.bag - late - start) * 1e-9)
    if not any(name in signals for name in EFFORT):
        raise NotRecorded(
            f"{source}: the messages have no efforts: the field effort of all {len(states.bag)} joint states "
            "is empty or NaN. Record a topic with efforts or motor currents, or name it: --topic TOPIC"
        )
    recording = Recording(
        name=source.stem,
        model=model,
        signals=signals,
        payload=payload,
        settings={"source": source.name},
        host_time=states.bag,
    )
    return [check(run) for run, _ in separate_runs(without_damaged(recording), "message {}".format)]


def _require_positions(source: Path, states: Samples) -> None:
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
) -> tuple[dict[tuple[str, ...], Samples], dict[str, Samples]]:
    """Joint states by the names in the message, as several nodes may share a topic; arrays by topic."""
    optional("rosbags.highlevel", "a ROS 2 bag", "ros2")  # missing, it is missed here and not there
    content = call_reader(f"{__name__}:read_messages", "rosbags", source, topic, effort)
    groups = {tuple(group.pop("names")): Samples(**group) for group in content["groups"]}
    return groups, {name: Samples(**samples) for name, samples in content["arrays"].items()}


def read_messages(source: str, topic: str | None, effort: str) -> dict[str, Any]:
    """The messages of a bag, in the process apart: fields of `Samples`, with the names of the joints.

    Raises:
        NotAFile: The bag cannot be read, or has no joint states.
        BadTime: A time stamp is beyond the years 1970 to 2262.
    """
    groups, arrays = _messages(Path(source), topic, effort)
    return {
        "groups": [{"names": names, **asdict(group.samples())} for names, group in groups.items()],
        "arrays": {name: asdict(collected.samples()) for name, collected in arrays.items()},
    }


def _messages(
    source: Path, topic: str | None, effort: str
) -> tuple[dict[tuple[str, ...], _Collected], dict[str, _Collected]]:
    highlevel = optional("rosbags.highlevel", "a ROS 2 bag", "ros2")
    typesys = optional("rosbags.typesys", "a ROS 2 bag", "ros2")
    groups: dict[tuple[str, ...], _Collected] = {}
    arrays: dict[str, _Collected] = {}
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
                _require_times(source, bag, stamp)
                groups.setdefault(names, _Collected(len(names))).add(bag, stamp, **rows)
            else:
                signal = next(n for n, topic in ARRAY_TOPICS.items() if topic == connection.topic)
                _require_times(source, bag)
                collected = arrays.setdefault(connection.topic, _Collected(len(message.data)))
                collected.add(bag, 0, **{signal: message.data})
    if not groups:
        raise NotAFile(f"{source}: there is not one joint state in it")
    return groups, arrays


def _require_times(source: Path, *stamps: int) -> None:
    """Refuse time stamps [ns] that no recording can hold: below zero, or of more than 63 bits."""
    for stamp in stamps:
        if not 0 <= stamp < LATEST:
            raise BadTime(
                f"{source}: a message has the time stamp {stamp} ns; valid are 0 to {LATEST - 1} (the year "
                "2262). The bag is damaged, or its clock was not set"
            )


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
