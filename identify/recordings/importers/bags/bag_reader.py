"""The joint states of a bag as arrays, by topic and list of joints.

Libraries decompress whatever size a chunk, a message or a file states: they run in a process apart.
"""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import BadTime, NotAFile
from ....notebook import optional
from ...mcap.mcap_topics import ARRAY_TOPICS
from ..read_apart import call_reader
from .bag_files import Bag
from .joint_messages import ARRAY, JointMessage

LATEST = 2**63
"""Time stamps are below this [ns since 1970]."""
LISTED = 10
"""Topics without joint states that an error lists, at most."""


@dataclass(frozen=True)
class Group:
    """Messages of one topic with one list of joints.

    Attributes:
        topic: The topic.
        kind: Type of the messages.
        names: Names of the joints, n of them.
        received: When the bag received each message, shape (t,) [ns].
        stamp: Time stamps by the messages, shape (t,) [ns]; 0 where a message has none.
        rows: Field -> values, shape (t, n); NaN where a message does not have them.
        wrong: Field -> number of messages that have fewer or more values than joints, and how many values.
    """

    topic: str
    kind: str
    names: tuple[str, ...]
    received: np.ndarray
    stamp: np.ndarray
    rows: dict[str, np.ndarray]
    wrong: dict[str, list[int]]


@dataclass(frozen=True)
class Content:
    """What a bag holds.

    Attributes:
        groups: Joint states; not empty.
        arrays: Signal -> times at which the bag received it, shape (t,) [ns], and values, shape (t, n).
        notes: What was lost of the bag, in sentences.
    """

    groups: list[Group]
    arrays: dict[str, tuple[np.ndarray, np.ndarray]]
    notes: list[str]


@dataclass
class _Collected:
    """The messages of a group while they are added."""

    topic: str
    kind: str
    names: tuple[str, ...]
    received: list[int] = field(default_factory=list)
    stamp: list[int] = field(default_factory=list)
    rows: dict[str, list[np.ndarray]] = field(default_factory=dict)
    wrong: dict[str, list[int]] = field(default_factory=dict)

    def add(self, received: int, message: JointMessage, order: np.ndarray) -> None:
        """Add a message, whose joints are in another order; a field that it lacks is NaN."""
        self.received.append(received)
        self.stamp.append(message.stamp)
        silent = np.full(len(self.names), np.nan)
        for name, values in message.fields.items():
            rows = self.rows.setdefault(name, [])
            complete = len(values) == len(message.names)
            rows.append(np.asarray(values, float)[order] if complete else silent)
            if not complete and len(values):
                count, _ = self.wrong.get(name, (0, 0))
                self.wrong[name] = [count + 1, len(values)]

    def group(self) -> dict[str, Any]:
        """The fields of a `Group`, in the order in which the bag received the messages."""
        order = np.argsort(self.received, kind="stable")
        return {
            "topic": self.topic,
            "kind": self.kind,
            "names": self.names,
            "wrong": self.wrong,
            "received": np.array(self.received, np.int64)[order],
            "stamp": np.array(self.stamp, np.int64)[order],
            "rows": {name: np.array(rows)[order] for name, rows in self.rows.items()},
        }


def read_bag(source: Path) -> Content:
    """Read a bag.

    Raises:
        NotAFile: The bag cannot be read, or has no joint states.
        BadTime: A time stamp is beyond the years 1970 to 2262.
        MissingPackage: rosbags is not installed.
    """
    optional("rosbags.highlevel", "a ROS bag", "ros2")  # missing, it is missed here and not there
    content = call_reader(f"{__name__}:read_messages", "rosbags or mcap", _folder(source))
    groups = [Group(**group | {"names": tuple(group["names"])}) for group in content["groups"]]
    arrays = {name: (received, values) for name, (received, values) in content["arrays"].items()}
    return Content(groups, arrays, content["notes"])


def _folder(source: Path) -> Path:
    """The folder of a .db3 file, as a bag may have several files; the file where there is no metadata."""
    divided = source.suffix == ".db3" and (source.parent / "metadata.yaml").exists()
    return source.parent if divided else source


def read_messages(source: str) -> dict[str, Any]:
    """The messages of a bag, in the process apart: fields of `Content`.

    Raises:
        NotAFile: The bag cannot be read, or has no joint states.
        BadTime: A time stamp is beyond the years 1970 to 2262.
    """
    bag = Bag(Path(source))
    groups: dict[tuple[str, tuple[str, ...]], _Collected] = {}
    arrays: dict[str, tuple[list[int], list[np.ndarray]]] = {}
    repeated: dict[str, str] = {}
    signals = {topic: signal for signal, topic in ARRAY_TOPICS.items()}
    for topic, kind, received, content in bag.messages():
        if kind == ARRAY:
            _require_times(source, received)
            if topic in signals:
                times, values = arrays.setdefault(signals[topic], ([], []))
                times.append(received)
                values.append(content)
            continue
        _require_times(source, received, content.stamp)
        if not len(content.names):
            bag.others[topic] = f"{kind} without names of joints"
            continue
        names, order = np.unique(content.names, return_index=True)  # whose order may differ
        if len(names) < len(content.names):
            repeated[topic] = Counter(content.names).most_common(1)[0][0]
        key = topic, tuple(names.tolist())
        groups.setdefault(key, _Collected(topic, kind, key[1])).add(received, content, order)
    if not groups:
        raise NotAFile(_nothing(source, bag))
    return {
        "groups": [collected.group() for collected in groups.values()],
        "arrays": {name: _equally_long(times, values) for name, (times, values) in arrays.items()},
        "notes": bag.notes + [_repeated(topic, name) for topic, name in repeated.items()],
    }


def _repeated(topic: str, name: str) -> str:
    return f"messages of {topic} name {name} more than once; the first of its values counts"


def _equally_long(times: list[int], values: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Times (t,) [ns] and values (t, n) of the arrays that are as long as the first."""
    kept = [row for row, array in enumerate(values) if len(array) == len(values[0])]
    return np.array(times, np.int64)[kept], np.array([values[row] for row in kept], float)


def _nothing(source: str, bag: Bag) -> str:
    """The error for a bag without joint states."""
    topics = [f"{topic} ({kind})" for topic, kind in sorted(bag.others.items())[:LISTED]]
    more = f" and {len(bag.others) - LISTED} others" if len(bag.others) > LISTED else ""
    return " ".join(
        [
            f"{source}: there is not one joint state in it, as sensor_msgs/JointState in ROS's encoding or JSON. "
            f"Topics: {', '.join(topics) or 'none'}{more}.",
            *bag.notes,
        ]
    )


def _require_times(source: str, *stamps: int) -> None:
    """Refuse time stamps [ns] that no recording can hold: below zero, or of more than 63 bits."""
    for stamp in stamps:
        if not 0 <= stamp < LATEST:
            raise BadTime(
                f"{source}: a message has the time stamp {stamp} ns; valid are 0 to {LATEST - 1} (the year "
                "2262). The bag is damaged, or its clock was not set"
            )
