"""One run in one self-contained MCAP file, which ROS 2 tools and viewers can open.

The file begins with its description (metadata, robot, trajectory), so that a file that was cut off has it.
Messages have two times: publish_time is the controller's time, counted from an epoch, and log_time is the
host clock if that was recorded, and else the same.
"""

import json
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...errors import BadTime, NotAFile, RecordingError
from ...model import Model
from ...robot_files.robot_file import parse_model
from ..incomplete_samples import without_stale
from ..recording import EFFORT, ControllerState, Event, KnownPayload, Recording, Signal, Timing
from ..recording_checks import DerivedWarning, check_recorded
from ..servo_error import LAW, lacks_effort, servo_of, servo_words, with_servo_error
from . import cdr
from . import mcap_topics as topics
from . import mcap_writer as writing
from .mcap_records import Contents, read_contents
from .mcap_topics import Topic, nanoseconds
from .mcap_writer import FORMAT, Head, RecordingWriter, Stream

LATEST = 2**63 * 1e-9
"""Latest time that the format can hold [s since 1970]."""
MOST = 1e9
"""Maximum number in the timing of a cycle (seconds late, cycles missed); larger numbers are damaged."""


def write_recording(recording: Recording, path: Path | str) -> None:
    """Write a recording; the file gets its name only when it is complete."""
    part = Path(path).with_name(Path(path).name + ".part")
    head = _head(recording)
    streams = _streams(recording, head.epoch)
    start = min((int(stream.logged[0]) for stream in streams if len(stream.logged)), default=head.epoch)
    with open(part, "wb") as file, RecordingWriter(file, head, start) as writer:
        writing.write_merged(streams, writer)
        writer.add_outcome(recording.outcome)
    os.replace(part, path)


def _head(recording: Recording) -> Head:
    epoch = writing.EPOCH
    if recording.host_time is not None and len(recording.host_time):
        epoch = int(recording.host_time[0] - nanoseconds(recording.signals["position"].time[:1])[0])
    return Head(
        name=recording.name,
        model=recording.model,
        payload=recording.payload,
        trajectory=recording.trajectory,
        settings=recording.settings,
        warnings=tuple(text for text in recording.warnings if not isinstance(text, DerivedWarning)),
        epoch=epoch,
        host_clock=recording.host_time is not None,
        samples={name: len(signal) for name, signal in recording.signals.items()},
    )


def _streams(recording: Recording, epoch: int) -> list[Stream]:
    joints = recording.robot.joints
    content = [
        (topic, recording.signals[next(iter(topic.fields))].time, topic.messages(joints, recording.signals))
        for topic in topics.topics_of(recording.signals)
    ]
    # Poses of the links at `TRANSFORM_RATE`, or at the rate of the recording if that is lower.
    position = recording.signals["position"]
    shown = position[np.flatnonzero(np.diff(writing.ticks(position.time), prepend=-np.inf))]
    poses = writing.pose_messages(recording.robot.kinematics, shown.time, shown.values)
    content.append((topics.TRANSFORMS, shown.time, poses))
    if recording.timing is not None:
        timing = recording.timing
        content.append((topics.timing_topic(timing.stages), timing.time, topics.timing_messages(timing)))
    if recording.controller is not None:
        state = recording.controller
        content.append((topics.state_topic(state.words), state.time, topics.state_messages(state.values)))
    if recording.events:
        messages = writing.of_any_length([topics.event_message(event) for event in recording.events])
        content.append((topics.EVENTS, np.array([event.time for event in recording.events]), messages))
    streams = []
    for topic, time, messages in content:
        _require_times(recording, topic, time, epoch)
        published = nanoseconds(time) + epoch
        streams.append(Stream(topic, published, host_clock(recording, published, epoch), messages))
    return streams


def _require_times(recording: Recording, topic: Topic, time: np.ndarray, epoch: int) -> None:
    """Refuse times (t,) [s] after an epoch [ns] that the format cannot hold."""
    clocks = [time + 1e-9 * epoch]
    if recording.host_time is not None:
        clocks.append(1e-9 * recording.host_time)
    for clock in clocks:
        wrong = clock[~((clock >= 0.0) & (clock < LATEST))]
        if len(wrong):
            raise BadTime(
                f"{recording.name}: {topic.name} has a time of {wrong[0]:.6g} s since 1970; valid are 0 to "
                f"{LATEST:.6g} s (the year 2262). Correct the clock, or leave those samples out"
            )


def host_clock(recording: Recording, time: np.ndarray, epoch: int) -> np.ndarray:
    """Host clock at controller times [ns]: exact at position samples, interpolated between them."""
    if recording.host_time is None or not len(recording.host_time):
        return time
    known = nanoseconds(recording.signals["position"].time)
    late = recording.host_time - known - epoch
    return time + np.rint(np.interp(time - epoch, known, late)).astype(np.int64)


def read_recording(path: Path | str) -> Recording:
    """Read a recording; of a file that was cut off, read the available part.

    Implausible content, such as a joint at 90 rad, is among its warnings; see `recording_checks`.

    Raises:
        NotAFile: It is not a recording, or its robot cannot be read.
        RecordingError: This version cannot read its format.
    """
    contents = read_contents(Path(path))
    head = _read_head(contents, Path(path))
    signals, host_time = _read_signals(contents, head)
    lost, settings, robot = _losses(contents, head, signals), head.settings, head.model.robot
    if lacks_effort(signals, robot):
        servo = servo_of(robot, None, None)
        signals = with_servo_error(signals, servo, str(path))
        settings = {**settings, LAW: servo_words(servo)}
    recording = Recording(
        name=head.name,
        model=head.model,
        signals=signals,
        payload=head.payload,
        trajectory=head.trajectory,
        settings=settings,
        host_time=host_time if head.host_clock else None,
        events=_events(contents, head.epoch),
        timing=_timing(contents, head.epoch),
        controller=_state(contents, head.epoch),
        outcome=contents.metadata.get("outcome", {}),
        warnings=head.warnings,
    )
    return check_recorded(without_stale(recording.with_warnings(*lost)))


def import_recording(source: Path, model: Model | None = None) -> list[Recording]:
    """Importer by `read_recording`; it ignores `model` and uses the robot in the file."""
    return [read_recording(source)]


def _read_head(contents: Contents, path: Path) -> Head:
    record = contents.metadata.get("exidyn")
    if record is None or "robot.toml" not in contents.attachments:
        raise NotAFile(
            f"{path} contains no robot: it was cut off before its first sample, or it is not an exidyn "
            "recording. Import ROS 2 bags first"
        )
    if record.get("format") != FORMAT:
        raise RecordingError(f"{path} has format {record.get('format')}; this version reads {FORMAT}")
    try:
        return _parse_head(record, contents)
    except (KeyError, TypeError, ValueError, AttributeError, ArithmeticError, RecursionError) as error:
        raise NotAFile(f"{path}: its description is damaged: {error}") from error


def _parse_head(record: Mapping[str, str], contents: Contents) -> Head:
    epoch = int(record["epoch_ns"])
    samples, payload = (json.loads(record[name]) for name in ("samples", "payload"))
    for key, value in {"epoch_ns": epoch, **samples}.items():
        if not 0 <= int(value) < 2**63:
            raise ValueError(f"{key} is {value}; expected a whole number of 63 bits")
    trajectory = contents.attachments.get("trajectory")
    return Head(
        name=record["name"],
        model=parse_model(contents.attachments["robot.toml"].data.decode()),
        payload=KnownPayload(payload["name"], tuple(map(tuple, payload["known"]))) if payload else None,
        trajectory=trajectory.data.decode() if trajectory else "",
        settings=contents.metadata.get("settings", {}),
        warnings=tuple(str(warning) for warning in json.loads(record["warnings"])),
        epoch=epoch,
        host_clock=bool(json.loads(record["host_clock"])),
        samples={name: int(count) for name, count in samples.items()},
    )


def _read_signals(contents: Contents, head: Head) -> tuple[dict[str, Signal], np.ndarray]:
    joints = head.model.robot.joints
    silent = Signal(np.empty(0), np.empty((0, len(joints))))
    signals = dict.fromkeys(head.samples, silent)
    host_time = np.empty(0, np.int64)
    for number, channel in contents.channels.items():
        topic = topics.topic_of(channel.topic, channel.metadata)
        if topic is None:
            continue
        rows = contents.rows(number, topic.template(joints).dtype)
        time = (rows["publish_time"].astype(np.int64) - head.epoch) / 1e9
        signals |= {signal: Signal(time, rows["body"][name]) for signal, name in topic.fields.items()}
        if "position" in topic.fields:
            host_time = rows["log_time"].astype(np.int64)
    # A run that ended before its first sample is a recording too, which only names its robot.
    signals.setdefault("position", silent)
    if not any(name in signals for name in EFFORT):
        signals["current"] = silent
    return signals, host_time


def _losses(contents: Contents, head: Head, signals: Mapping[str, Signal]) -> list[str]:
    """Sentences about missing content."""
    losses = [f"could not be read: {loss}" for loss in contents.lost]
    for name, expected in head.samples.items():
        count = len(signals[name])
        if count < expected:
            lost = expected - count
            seconds = lost * signals[name].period
            losses.append(
                f"{name}: {count} of {expected} samples were read, {lost} ({seconds:.3f} s) are lost"
            )
    if not contents.finished:
        last = signals["position"].time[-1:].tolist()
        until = f"the run is known up to {last[0]:.3f} s" if last else "it has no samples"
        held = f"what the recorder still held, at most {writing.CHUNK} bytes, is lost"
        losses.insert(0, f"file ends abruptly: {until}; {held}")
    return losses


def _timing(contents: Contents, epoch: int) -> Timing | None:
    """Timing of a run; None if it was not recorded."""
    number = _channel(contents, "/timing", topics.ARRAY)
    if number is None:
        return None
    time, data = _numbers(contents, number, len(topics.TIMING_FIELDS), epoch)
    stages = contents.channels[number].metadata.get("stages", "")
    data = np.nan_to_num(data, nan=0.0, posinf=0.0, neginf=0.0)
    data[np.abs(data) > MOST] = 0.0
    lateness, skipped, stage = data.T
    return Timing(time, lateness, skipped, stage, tuple(stages.split(",")) if stages else ())


def _state(contents: Contents, epoch: int) -> ControllerState | None:
    """State of the controller; None if it was not recorded, or if its description is damaged."""
    number = _channel(contents, topics.STATE, topics.ARRAY)
    if number is None:
        return None
    metadata = contents.channels[number].metadata
    try:
        meanings = json.loads(metadata["words"])
        words = {
            str(name): {int(code): str(word) for code, word in meanings[name].items()}
            for name in metadata["fields"].split(",")
        }
    except (KeyError, ValueError, TypeError, AttributeError):
        contents.lost.append("the meaning of the controller's state")
        return None
    return ControllerState(*_numbers(contents, number, len(words), epoch), words)


def _numbers(contents: Contents, channel: int, count: int, epoch: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (t,) [s] and numbers (t, count) of the messages of a channel."""
    rows = contents.rows(channel, cdr.double_array(count).dtype)
    return (rows["publish_time"].astype(np.int64) - epoch) / 1e9, rows["body"]["data"]


def _events(contents: Contents, epoch: int) -> tuple[Event, ...]:
    """Events of a run, in the order of their recording; damaged events count as lost."""
    number = _channel(contents, topics.EVENTS.name, topics.EVENTS.schema)
    events: list[Event] = []
    for published, body in contents.bodies(number) if number is not None else ():
        try:
            events.append(topics.event_of(body, (published - epoch) / 1e9))
        except ValueError:
            contents.lost.append("a damaged event")
    return tuple(events)


def _channel(contents: Contents, topic: str, schema: str) -> int | None:
    """Number of the channel of a topic, if its messages have the type that exidyn writes."""
    for number, channel in contents.channels.items():
        described = contents.schemas.get(channel.schema_id)
        if channel.topic == topic and described is not None and described.name == schema:
            return number
    return None
