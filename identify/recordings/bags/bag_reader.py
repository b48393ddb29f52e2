"""Joint states of a bag as arrays, by topic and list of joints.

Libraries decompress chunks, messages and files of any stated size, so they run in a separate process.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import BadTime, NotAFile
from ...notebook import optional
from ..mcap.mcap_topics import ARRAY_TOPICS
from ..reading_limits import call_reader
from ..tables.rows import fields_of, table_of_rows
from ..tables.table import Table
from .bag_files import ARRAY, Bag, BagMessage

LATEST = 2**63
"""Time stamps are below this [ns since 1970]."""
SIGNAL_OF = {topic: signal for signal, topic in ARRAY_TOPICS.items()}
"""Topic of arrays -> signal."""
STAMP = "header.stamp"
"""Field of the time stamp of a message, in columns."""
LISTED = 10
"""Maximum number of topics without joint states in an error."""


@dataclass(frozen=True)
class Group:
    """Joint states of the same joints."""

    topic: str  # name of the topic, or names of several
    names: tuple[str, ...]  # names of the n joints
    received: np.ndarray  # times at which the bag received the messages, shape (t,) [ns]
    stamp: np.ndarray  # time stamps in the messages, shape (t,) [ns]; 0 if a message has none
    rows: dict[str, np.ndarray]  # field -> values, shape (t, n); NaN if a message lacks them
    kind: str = ""  # type of the messages
    # Field -> number of messages with fewer or more values than joints, and their number of values.
    wrong: dict[str, list[int]] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{', '.join(self.names)} on {self.topic}"


@dataclass(frozen=True)
class Content:
    """Content of a bag."""

    groups: list[Group]  # joint states
    # Signal -> times at which the bag received it, shape (t,) [ns], and values, shape (t, n).
    arrays: dict[str, tuple[np.ndarray, np.ndarray]]
    notes: list[str]  # sentences about lost parts of the bag
    tables: list[Table]  # fields of the other messages, by topic, if there are no joint states; else empty


def read_bag(source: Path) -> Content:
    """Read a bag."""
    optional("rosbags.highlevel", "a ROS bag", "ros2")  # so that this process reports a missing package
    # A bag may have several files, which the metadata in their folder name.
    divided = source.suffix == ".db3" and (source.parent / "metadata.yaml").exists()
    folder = source.parent if divided else source
    content = call_reader(f"{__name__}:read_messages", "rosbags or mcap", folder)
    groups = [Group(**group | {"names": tuple(group["names"])}) for group in content["groups"]]
    arrays = {name: (received, values) for name, (received, values) in content["arrays"].items()}
    return Content(groups, arrays, content["notes"], [Table(**table) for table in content["tables"]])


def read_messages(source: str) -> dict[str, Any]:
    """Messages of a bag, as fields of `Content`; this runs in the separate process."""
    bag = Bag(Path(source))
    states: dict[tuple[str, str, tuple[str, ...]], list[BagMessage]] = {}
    arrays: dict[str, list[BagMessage]] = {}
    known: dict[tuple[str, ...], tuple[str, ...]] = {}  # messages share their names, which need most memory
    for message in bag.messages():
        _require_times(source, message.received, 0 if message.kind == ARRAY else message.content.stamp)
        if message.kind == ARRAY:
            if message.topic in SIGNAL_OF:
                arrays.setdefault(SIGNAL_OF[message.topic], []).append(message)
        elif len(message.content.names):
            names = tuple(message.content.names)
            shared = message._replace(content=message.content._replace(names=known.setdefault(names, names)))
            states.setdefault((message.topic, message.kind, _sorted(names)[0]), []).append(shared)
        else:
            bag.others[message.topic] = f"{message.kind} without names of joints"
    tables = [] if states else _field_tables(Path(source))
    if not states and not tables:
        raise NotAFile(_nothing(source, bag))
    return {
        "groups": [vars(_group(*key, messages)) for key, messages in states.items()],
        "arrays": {name: _equally_long(messages) for name, messages in arrays.items()},
        "notes": [*bag.notes, *_repeated(states.values())],
        "tables": [table._asdict() for table in tables],
    }


def _field_tables(source: Path) -> list[Table]:
    """Fields of all messages that are no joint states, by topic, whose name is that of the run."""
    rows: dict[str, list[Any]] = {}
    for message in Bag(source, others=True).messages():
        _require_times(str(source), message.received)
        rows.setdefault(message.topic, []).append([message.received, message.content])
    tables = [_field_table(source, topic, messages) for topic, messages in rows.items()]
    return [table for table in tables if len(table.names) > 1]


def _field_table(source: Path, topic: str, messages: Sequence[Any]) -> Table:
    """Fields of the messages of a topic; their time is their stamp, or when the bag received them."""
    received = np.array([received for received, _ in messages], np.int64)
    contents = [dict(fields_of(content)) for _, content in messages]
    stamps = np.array([content.get(STAMP, 0.0) for content in contents])
    if np.any(np.diff(stamps) > 0.0):
        return table_of_rows(source, contents, run=topic)
    times = (1e-9 * received).tolist()
    return table_of_rows(
        source,
        ({"time": time, **content, STAMP: time} for time, content in zip(times, contents, strict=True)),
        run=topic,
    )


def _group(topic: str, kind: str, names: tuple[str, ...], messages: list[BagMessage]) -> Group:
    """Joint states of the same joints from their messages; values of the wrong number are NaN."""
    messages = sorted(messages, key=lambda message: message.received)
    rows, wrong, silent = {}, {}, np.full(len(names), np.nan)
    for field_name in messages[0].content.fields:
        values, counts = [], []
        for _, _, _, states in messages:
            row = states.fields[field_name]
            complete = len(row) == len(states.names)
            values.append(np.asarray(row, float)[_sorted(states.names)[1]] if complete else silent)
            counts += [] if complete or not len(row) else [len(row)]
        rows[field_name] = np.array(values)
        if counts:
            wrong[field_name] = [len(counts), counts[-1]]
    received = np.array([message.received for message in messages], np.int64)
    stamp = np.array([message.content.stamp for message in messages], np.int64)
    return Group(topic, names, received, stamp, rows, kind, wrong)


def _repeated(groups: Iterable[list[BagMessage]]) -> list[str]:
    """Sentences about topics whose messages name a joint more than once."""
    repeated: dict[str, str] = {}
    for message in (message for messages in groups for message in messages):
        if len(set(message.content.names)) < len(message.content.names):
            repeated[message.topic] = Counter(message.content.names).most_common(1)[0][0]
    return [
        f"messages of {topic} name {name} more than once; the first of its values counts"
        for topic, name in repeated.items()
    ]


@lru_cache
def _sorted(names: tuple[str, ...]) -> tuple[tuple[str, ...], np.ndarray]:
    """Unique names of joints in alphabetical order, and the place of the first occurrence of each."""
    alphabetical, places = np.unique(names, return_index=True)
    return tuple(alphabetical.tolist()), places


def _equally_long(messages: list[BagMessage]) -> tuple[np.ndarray, np.ndarray]:
    """Times (t,) [ns] and values (t, n) of the arrays that are as long as the first."""
    matching = [message for message in messages if len(message.content) == len(messages[0].content)]
    times = np.array([message.received for message in matching], np.int64)
    return times, np.array([message.content for message in matching], float)


def _nothing(source: str, bag: Bag) -> str:
    """Message for a bag without joint states and other fields that can be read."""
    topics = [f"{topic} ({kind})" for topic, kind in sorted(bag.others.items())[:LISTED]]
    more = f" and {len(bag.others) - LISTED} others" if len(bag.others) > LISTED else ""
    nothing = (
        f"{source}: there are no joint states in it, such as sensor_msgs/JointState, and no other messages "
        f"whose definition is in the bag. Topics: {', '.join(topics) or 'none'}{more}."
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
