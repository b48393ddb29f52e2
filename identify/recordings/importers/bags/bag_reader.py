"""Joint states of a bag as arrays, by topic and list of joints.

Libraries decompress chunks, messages and files of any stated size, so they run in a separate process.
"""

from collections import Counter
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import BadTime, NotAFile
from ....notebook import optional
from ...mcap.mcap_topics import ARRAY_TOPICS
from ..read_apart import call_reader
from .bag_files import Bag, BagMessage
from .joint_messages import ARRAY, JointMessage

LATEST = 2**63
"""Time stamps are below this [ns since 1970]."""
SIGNAL_OF = {topic: signal for signal, topic in ARRAY_TOPICS.items()}
"""Topic of arrays -> signal."""
LISTED = 10
"""Maximum number of topics without joint states in an error."""


@dataclass(frozen=True)
class Group:
    """Messages of one topic with one list of joints.

    Attributes:
        topic: Name of the topic.
        kind: Type of the messages.
        names: Names of the n joints.
        received: Times at which the bag received the messages, shape (t,) [ns].
        stamp: Time stamps in the messages, shape (t,) [ns]; 0 if a message has none.
        rows: Field -> values, shape (t, n); NaN if a message lacks them.
        wrong: Field -> number of messages with fewer or more values than joints, and their number of values.
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
    """Content of a bag.

    Attributes:
        groups: Joint states; not empty.
        arrays: Signal -> times at which the bag received it, shape (t,) [ns], and values, shape (t, n).
        notes: Sentences about lost parts of the bag.
    """

    groups: list[Group]
    arrays: dict[str, tuple[np.ndarray, np.ndarray]]
    notes: list[str]


@dataclass
class _Collected:
    """Messages of a group while they are collected."""

    topic: str
    kind: str
    names: tuple[str, ...]
    received: list[int] = field(default_factory=list)
    stamp: list[int] = field(default_factory=list)
    rows: dict[str, list[np.ndarray]] = field(default_factory=dict)
    wrong: dict[str, list[int]] = field(default_factory=dict)

    def add(self, received: int, message: JointMessage, order: np.ndarray) -> None:
        """Add a message and sort its joints by `order`; fields of the wrong length are NaN."""
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
        """Fields of a `Group`, in the order in which the bag received the messages."""
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
    optional("rosbags.highlevel", "a ROS bag", "ros2")  # so that this process reports a missing package
    content = call_reader(f"{__name__}:read_messages", "rosbags or mcap", _folder(source))
    groups = [Group(**group | {"names": tuple(group["names"])}) for group in content["groups"]]
    arrays = {name: (received, values) for name, (received, values) in content["arrays"].items()}
    return Content(groups, arrays, content["notes"])


def _folder(source: Path) -> Path:
    """Folder of a .db3 file, since a bag may have several files; the file itself if there is no metadata."""
    divided = source.suffix == ".db3" and (source.parent / "metadata.yaml").exists()
    return source.parent if divided else source


def read_messages(source: str) -> dict[str, Any]:
    """Messages of a bag, as fields of `Content`; this runs in the separate process.

    Raises:
        NotAFile: The bag cannot be read, or has no joint states.
        BadTime: A time stamp is beyond the years 1970 to 2262.
    """
    bag, messages = Bag(Path(source)), _Messages()
    for message in bag.messages():
        states = None if message.kind == ARRAY else message.content
        _require_times(source, message.received, states.stamp if states else 0)
        if states is None:
            messages.add_array(message)
        elif len(states.names):
            messages.add_states(message, states)
        else:
            bag.others[message.topic] = f"{message.kind} without names of joints"
    if not messages.groups:
        raise NotAFile(_nothing(source, bag))
    return {
        "groups": [collected.group() for collected in messages.groups.values()],
        "arrays": {name: _equally_long(*arrays) for name, arrays in messages.arrays.items()},
        "notes": [*bag.notes, *messages.notes()],
    }


class _Messages:
    """Messages of a bag while they are collected."""

    def __init__(self) -> None:
        self.groups: dict[tuple[str, tuple[str, ...]], _Collected] = {}
        self.arrays: dict[str, tuple[list[int], list[np.ndarray]]] = {}
        self._repeated: dict[str, str] = {}

    def add_states(self, message: BagMessage, states: JointMessage) -> None:
        """Add joint states to those of the same topic and joints."""
        names, order = _sorted(tuple(states.names))
        if len(names) < len(states.names):
            self._repeated[message.topic] = Counter(states.names).most_common(1)[0][0]
        collected = _Collected(message.topic, message.kind, names)
        self.groups.setdefault((message.topic, names), collected).add(message.received, states, order)

    def add_array(self, message: BagMessage) -> None:
        """Add an array, if it is a signal."""
        if message.topic in SIGNAL_OF:
            times, values = self.arrays.setdefault(SIGNAL_OF[message.topic], ([], []))
            times.append(message.received)
            values.append(message.content)

    def notes(self) -> list[str]:
        """Sentences about repeated names in the messages."""
        return [
            f"messages of {topic} name {name} more than once; the first of its values counts"
            for topic, name in self._repeated.items()
        ]


@lru_cache
def _sorted(names: tuple[str, ...]) -> tuple[tuple[str, ...], np.ndarray]:
    """Unique names of joints in alphabetical order, and the place of the first occurrence of each."""
    alphabetical, places = np.unique(names, return_index=True)
    return tuple(alphabetical.tolist()), places


def _equally_long(times: list[int], values: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Times (t,) [ns] and values (t, n) of the arrays that are as long as the first."""
    matching = [row for row, array in enumerate(values) if len(array) == len(values[0])]
    return np.array(times, np.int64)[matching], np.array([values[row] for row in matching], float)


def _nothing(source: str, bag: Bag) -> str:
    """Message for a bag without joint states."""
    topics = [f"{topic} ({kind})" for topic, kind in sorted(bag.others.items())[:LISTED]]
    more = f" and {len(bag.others) - LISTED} others" if len(bag.others) > LISTED else ""
    nothing = (
        f"{source}: there are no joint states in it, such as sensor_msgs/JointState or JSON. "
        f"Topics: {', '.join(topics) or 'none'}{more}."
    )
    return " ".join([nothing, *bag.notes])


def _require_times(source: str, *stamps: int) -> None:
    """Refuse time stamps [ns] that a recording cannot hold: negative, or with more than 63 bits."""
    for stamp in stamps:
        if not 0 <= stamp < LATEST:
            raise BadTime(
                f"{source}: a message has the time stamp {stamp} ns; valid are 0 to {LATEST - 1} (the year "
                "2262). The bag is damaged, or its clock was not set"
            )
