"""Events and timing of a run as topics of its MCAP file: /events and /timing.

An event is a rcl_interfaces/msg/Log, which viewers show as a line of text; its numbers are JSON
in its field `function`. /timing is an array of numbers, whose meaning is in its channel's metadata.
"""

import json
from collections.abc import Sequence

import numpy as np

from ..run_log import Event, Timing
from . import cdr
from .mcap_records import Contents
from .mcap_topics import ARRAY, Topic, nanoseconds

EVENTS = Topic("/events", "rcl_interfaces/msg/Log", {})
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
