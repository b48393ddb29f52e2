"""Topics of an MCAP file, their signals and their messages.

Events, timing and the controller's state are topics too: /events, /timing, /controller_state. An event is a
rcl_interfaces/msg/Log, which viewers show as a line of text; its numbers are JSON in the field `function`.
The others are arrays of numbers, whose meaning is in the metadata of their channels.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..recording import SIGNALS, Event, Signal, Timing
from . import cdr

JOINT_STATE, ARRAY = "sensor_msgs/msg/JointState", "std_msgs/msg/Float64MultiArray"

STATE_FIELDS = {"position": "position", "velocity": "velocity", "torque": "effort"}
"""Signal -> field of /joint_states, for signals with the time stamps of the position."""

COMMAND_FIELDS = {"command": "position", "command_velocity": "velocity"}
"""Signal -> field of /joint_command."""

JOINT_TOPICS = {"/joint_states": STATE_FIELDS, "/joint_command": COMMAND_FIELDS}
"""Topic of joint states -> its fields; it exists if the first signal does, which gives the time stamps."""

ARRAY_TOPICS = {
    "velocity": "/joint_velocity",
    "torque": "/joint_torque",
    "current": "/motor_current",
    "temperature": "/motor_temperature",
    "link_position": "/link_position",
}
"""Signal -> its own topic, with arrays in the order of the joints."""


@dataclass(frozen=True)
class Topic:
    """A topic and the signals in its messages."""

    name: str  # name of the topic, such as "/joint_states"
    schema: str  # message type, a key of `cdr.SCHEMAS`
    fields: Mapping[str, str]  # signal name -> field of the message's record
    # Metadata of the channel, if the topic carries no signal.
    details: Mapping[str, str] = field(default_factory=dict)

    def template(self, joints: Sequence[str]) -> np.ndarray:
        """One empty message, shape (1,)."""
        if self.schema == JOINT_STATE:
            return cdr.joint_state(joints, tuple(self.fields.values()))
        return cdr.double_array(len(joints))

    def metadata(self, joints: Sequence[str]) -> dict[str, str]:
        """Metadata of the channel; `topic_of` uses its entry `signals`."""
        if not self.fields:
            return dict(self.details)
        return {
            "signals": ",".join(self.fields),
            "unit": ",".join(SIGNALS[signal] for signal in self.fields),
            "names": ",".join(joints),
        }

    def messages(self, joints: Sequence[str], signals: Mapping[str, Signal]) -> np.ndarray:
        """All messages of this topic, shape (t,), each a record whose bytes are the message."""
        first = signals[next(iter(self.fields))]
        records = np.repeat(self.template(joints), len(first))
        if self.schema == JOINT_STATE:
            cdr.set_stamp(records, "stamp", nanoseconds(first.time))
        for signal, place in self.fields.items():
            records[place] = signals[signal].values
        return records


DESCRIPTION = Topic("/robot_description", "std_msgs/msg/String", {})
TRANSFORMS = Topic("/tf", "tf2_msgs/msg/TFMessage", {})
"""Topics that show the arm in viewers and carry no signal."""
EVENTS = Topic("/events", "rcl_interfaces/msg/Log", {})
STATE = "/controller_state"
TIMING_FIELDS = ("lateness", "skipped", "stage")
NAME = "exidyn."
"""Prefix of an event's kind: viewers of logs show the sender."""

LEVELS = {"stop": cdr.ERROR, "fault": cdr.ERROR, "warning": cdr.WARN, "late": cdr.WARN}
"""Kind of an event -> log level; other kinds are INFO."""


def topic_of(name: str, metadata: Mapping[str, str]) -> Topic | None:
    """Topic of a channel of a file; None if it carries no signal."""
    signals = [signal for signal in metadata.get("signals", "").split(",") if signal in SIGNALS]
    if not signals:
        return None
    if name not in JOINT_TOPICS:
        return Topic(name, ARRAY, {signals[0]: "data"})
    fields = JOINT_TOPICS[name]
    return Topic(name, JOINT_STATE, {signal: fields[signal] for signal in signals if signal in fields})


def topics_of(signals: Mapping[str, Signal]) -> list[Topic]:
    """Topics for signals, /joint_states first."""
    topics = []
    for name, fields in JOINT_TOPICS.items():
        if (first := next(iter(fields))) in signals:
            stamps, present = signals[first].time, [signal for signal in fields if signal in signals]
            sharing = [signal for signal in present if np.array_equal(signals[signal].time, stamps)]
            topics.append(Topic(name, JOINT_STATE, {signal: fields[signal] for signal in sharing}))
    for signal, name in ARRAY_TOPICS.items():
        if signal in signals and signal not in topics[0].fields:
            topics.append(Topic(name, ARRAY, {signal: "data"}))
    return topics


def nanoseconds(time: np.ndarray) -> np.ndarray:
    """Seconds (t,) as whole nanoseconds."""
    return np.rint(time * 1e9).astype(np.int64)


def timing_topic(stages: Sequence[str]) -> Topic:
    """Topic /timing, with the names of the stages."""
    metadata = {"fields": ",".join(TIMING_FIELDS), "unit": "s,,", "stages": ",".join(stages)}
    return Topic("/timing", ARRAY, {}, metadata)


def timing_messages(timing: Timing) -> np.ndarray:
    """One message per cycle, shape (t,)."""
    return state_messages(np.stack([getattr(timing, name) for name in TIMING_FIELDS], axis=1))


def state_topic(words: Mapping[str, Mapping[int, str]]) -> Topic:
    """Topic /controller_state, with its names and the meaning of their codes."""
    return Topic(STATE, ARRAY, {}, {"fields": ",".join(words), "words": json.dumps(words)})


def state_messages(values: np.ndarray) -> np.ndarray:
    """One message per row of values (t, k), shape (t,)."""
    records = np.repeat(cdr.double_array(values.shape[1]), len(values))
    records["data"] = values
    return records


def event_message(event: Event) -> bytes:
    """Message of an event, stamped with its time."""
    stamp = int(nanoseconds(np.array(event.time)))
    level = LEVELS.get(event.kind, cdr.INFO)
    details = json.dumps(dict(event.details)) if event.details else ""
    return cdr.log_message(stamp, level, NAME + event.kind, event.text, details)


def event_of(body: bytes, time: float) -> Event:
    """Event at a time [s] of a message from `event_message`; ValueError if the message is damaged."""
    message = cdr.read_log(body)
    details = json.loads(message.function) if message.function else {}
    return Event(time, message.name.removeprefix(NAME), message.text, details)
