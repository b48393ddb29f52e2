"""Events, timing and controller's state as topics of an MCAP file: /events, /timing, /controller_state.

An event is a rcl_interfaces/msg/Log, which viewers show as a line of text; its numbers are JSON
in its field `function`. The others are arrays of numbers, whose meaning is in their channels' metadata.
"""

import json
from collections.abc import Mapping, Sequence

import numpy as np

from ..run_log import ControllerState, Event, Timing
from . import cdr
from .mcap_records import Contents
from .mcap_topics import ARRAY, Topic, nanoseconds

EVENTS = Topic("/events", "rcl_interfaces/msg/Log", {})
STATE = "/controller_state"
TIMING_FIELDS = ("lateness", "skipped", "stage")
NAME = "exidyn."
"""Prefix of an event's kind: viewers of logs show the sender."""

LEVELS = {"stop": cdr.ERROR, "fault": cdr.ERROR, "warning": cdr.WARN, "late": cdr.WARN}
"""How serious an event is, by its kind; all others only inform."""

MOST = 1e9
"""Number in the timing of a cycle, at most: seconds late, cycles missed; what is above is damage."""


def timing_topic(stages: Sequence[str]) -> Topic:
    """/timing, with the names of the stages."""
    metadata = {"fields": ",".join(TIMING_FIELDS), "unit": "s,,", "stages": ",".join(stages)}
    return Topic("/timing", ARRAY, {}, metadata)


def timing_messages(timing: Timing) -> np.ndarray:
    """One message a cycle, shape (t,)."""
    records = np.repeat(cdr.double_array(len(TIMING_FIELDS)), len(timing))
    records["data"] = np.stack([getattr(timing, name) for name in TIMING_FIELDS], axis=1)
    return records


def state_topic(words: Mapping[str, Mapping[int, str]]) -> Topic:
    """/controller_state, with its names and what their codes mean."""
    return Topic(STATE, ARRAY, {}, {"fields": ",".join(words), "words": json.dumps(words)})


def state_messages(values: np.ndarray) -> np.ndarray:
    """One message a row of values (t, k), shape (t,)."""
    records = np.repeat(cdr.double_array(values.shape[1]), len(values))
    records["data"] = values
    return records


def event_message(event: Event) -> bytes:
    """An event as a message, at its time."""
    stamp = int(nanoseconds(np.array(event.time)))
    level = LEVELS.get(event.kind, cdr.INFO)
    details = json.dumps(dict(event.details)) if event.details else ""
    return cdr.log_message(stamp, level, NAME + event.kind, event.text, details)


def read_timing(contents: Contents, epoch: int) -> Timing | None:
    """The timing of a run; None if it was not recorded."""
    number = _channel(contents, "/timing", ARRAY)
    if number is None:
        return None
    rows = contents.rows(number, cdr.double_array(len(TIMING_FIELDS)).dtype)
    time = (rows["publish_time"].astype(np.int64) - epoch) / 1e9
    stages = contents.channels[number].metadata.get("stages", "")
    data = np.nan_to_num(rows["body"]["data"], nan=0.0, posinf=0.0, neginf=0.0)
    data[np.abs(data) > MOST] = 0.0
    lateness, skipped, stage = data.T
    return Timing(time, lateness, skipped, stage, tuple(stages.split(",")) if stages else ())


def read_state(contents: Contents, epoch: int) -> ControllerState | None:
    """The controller's own state; None where it was not recorded, or what explains it is damaged."""
    number = _channel(contents, STATE, ARRAY)
    if number is None:
        return None
    metadata = contents.channels[number].metadata
    try:
        given = json.loads(metadata["words"])
        words = {
            str(name): {int(code): str(word) for code, word in given[name].items()}
            for name in metadata["fields"].split(",")
        }
    except (KeyError, ValueError, TypeError, AttributeError):
        contents.lost.append("what the controller's state means")
        return None
    rows = contents.rows(number, cdr.double_array(len(words)).dtype)
    time = (rows["publish_time"].astype(np.int64) - epoch) / 1e9
    return ControllerState(time, rows["body"]["data"], words)


def read_events(contents: Contents, epoch: int) -> tuple[Event, ...]:
    """The events of a run, in the order in which they were recorded; damaged ones are counted as lost."""
    number = _channel(contents, EVENTS.name, EVENTS.schema)
    found: list[Event] = []
    for published, body in contents.bodies(number) if number is not None else ():
        try:
            message = cdr.read_log(body)
            details = json.loads(message.function) if message.function else {}
            found.append(
                Event((published - epoch) / 1e9, message.name.removeprefix(NAME), message.text, details)
            )
        except ValueError:
            contents.lost.append("an event that is damaged")
    return tuple(found)


def _channel(contents: Contents, topic: str, schema: str) -> int | None:
    """Number of the channel of a topic, if its messages are what we write there."""
    for number, channel in contents.channels.items():
        described = contents.schemas.get(channel.schema_id)
        if channel.topic == topic and described is not None and described.name == schema:
            return number
    return None
