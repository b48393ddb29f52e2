"""One run in one MCAP file that explains itself, and that ROS 2 tools and viewers open as it is.

The file begins with what explains it (metadata, robot, trajectory), so that a run that was cut off still
does. Time is kept twice: a message's publish_time is the controller's time counted from an epoch, its
log_time the host's clock where that was recorded, and else the same.
"""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from . import cdr
from .errors import NotAFile, RecordingError
from .link_frames import link_frames, link_poses
from .mcap_records import Contents, read_contents
from .mcap_topics import TRANSFORMS, Topic, nanoseconds, topic_of, topics_of
from .mcap_writer import CHUNK, EPOCH, FORMAT, Head, RecordingWriter
from .recording import EFFORT, KnownPayload, Recording, Signal
from .recording_checks import check
from .robot_file import parse_model

TRANSFORM_RATE = 50.0
"""Poses of the links a second, enough for the eye [1/s]."""


def write_recording(recording: Recording, path: Path | str) -> None:
    """Write a recording; the file appears under its name only when it is whole."""
    part = Path(path).with_name(Path(path).name + ".part")
    head = _head(recording)
    streams = _streams(recording, head.epoch)
    start = min((int(stream.logged[0]) for stream in streams if len(stream.logged)), default=head.epoch)
    with open(part, "wb") as file, RecordingWriter(file, head, start) as writer:
        _write_merged(streams, writer)
    os.replace(part, path)


class _Stream(NamedTuple):
    """Messages of one topic, with the controller's and the host's clock [ns since 1970]."""

    topic: Topic
    published: np.ndarray
    logged: np.ndarray
    messages: np.ndarray


def _head(recording: Recording) -> Head:
    epoch = EPOCH
    if recording.host_time is not None and len(recording.host_time):
        epoch = int(recording.host_time[0] - nanoseconds(recording.signals["position"].time[:1])[0])
    return Head(
        name=recording.name,
        model=recording.model,
        payload=recording.payload,
        trajectory=recording.trajectory,
        settings=recording.settings,
        warnings=recording.warnings,
        epoch=epoch,
        host_clock=recording.host_time is not None,
        samples={name: len(signal) for name, signal in recording.signals.items()},
    )


def _streams(recording: Recording, epoch: int) -> list[_Stream]:
    joints = recording.robot.joints
    content = [
        (topic, recording.signals[next(iter(topic.fields))].time, topic.messages(joints, recording.signals))
        for topic in topics_of(recording.signals)
    ]
    streams = []
    for topic, time, messages in (*content, _transforms(recording)):
        published = nanoseconds(time) + epoch
        streams.append(_Stream(topic, published, _host_clock(recording, published, epoch), messages))
    return streams


def _write_merged(streams: list[_Stream], writer: RecordingWriter) -> None:
    """All topics, in the order in which they were recorded."""
    for stream in streams:
        writer.add_topic(stream.topic)
    which = np.concatenate([np.full(len(stream.logged), number) for number, stream in enumerate(streams)])
    row = np.concatenate([np.arange(len(stream.logged)) for stream in streams])
    for place in np.argsort(np.concatenate([stream.logged for stream in streams]), kind="stable"):
        stream, index = streams[which[place]], row[place]
        message = stream.messages[index].tobytes()
        writer.write(stream.topic, message, int(stream.published[index]), int(stream.logged[index]))


def _host_clock(recording: Recording, time: np.ndarray, epoch: int) -> np.ndarray:
    """Host's clock at controller's times [ns]: exact at position samples, between them interpolated."""
    if recording.host_time is None or not len(recording.host_time):
        return time
    known = nanoseconds(recording.signals["position"].time)
    late = recording.host_time - known - epoch
    return time + np.rint(np.interp(time - epoch, known, late)).astype(np.int64)


def _transforms(recording: Recording) -> tuple[Topic, np.ndarray, np.ndarray]:
    """Poses of the links at `TRANSFORM_RATE` or at the rate of the recording."""
    position = recording.signals["position"]
    ticks = np.floor(position.time * TRANSFORM_RATE)
    shown = position[np.flatnonzero(np.diff(ticks, prepend=-np.inf))]
    kinematics = recording.robot.kinematics
    frames = link_frames(kinematics)
    template = cdr.transforms([(frame.parent, frame.child) for frame in frames])
    records = np.repeat(template, len(shown))
    poses = link_poses(kinematics, shown.values)
    for which in range(len(frames)):
        cdr.set_stamp(records, f"stamp{which}", nanoseconds(shown.time))
        records[f"pose{which}"] = poses[:, which]
    return TRANSFORMS, shown.time, records


def read_recording(path: Path | str) -> Recording:
    """Read a recording, as far as a file that was cut off goes.

    Raises:
        NotAFile: Not a recording, or not even its robot can be read.
        RecordingError: What is in it cannot be a recording; see `recording_checks.check`.
    """
    contents = read_contents(Path(path))
    head = _read_head(contents, Path(path))
    signals, host_time = _read_signals(contents, head)
    recording = Recording(
        name=head.name,
        model=head.model,
        signals=signals,
        payload=head.payload,
        trajectory=head.trajectory,
        settings=head.settings,
        host_time=host_time if head.host_clock else None,
        warnings=head.warnings,
    )
    return check(recording.doubted(*_losses(contents, head, signals)))


def _read_head(contents: Contents, path: Path) -> Head:
    record = contents.metadata.get("exidyn")
    if record is None or "robot.toml" not in contents.attachments:
        raise NotAFile(
            f"{path} has no robot inside: it was cut off before its first sample, or it is not an exidyn "
            "recording. Import ROS 2 bags first"
        )
    if record.get("format") != FORMAT:
        raise RecordingError(f"{path} has format {record.get('format')}; this version reads {FORMAT}")
    try:
        return _parse_head(record, contents)
    except (KeyError, TypeError, ValueError) as error:
        raise NotAFile(f"{path}: what explains it is damaged: {error}") from error


def _parse_head(record: Mapping[str, str], contents: Contents) -> Head:
    payload: Any = json.loads(record["payload"])
    known = tuple((name, value) for name, value in payload["known"]) if payload else ()
    return Head(
        name=record["name"],
        model=parse_model(contents.attachments["robot.toml"].decode()),
        payload=KnownPayload(payload["name"], known) if payload else None,
        trajectory=contents.attachments.get("trajectory", b"").decode(),
        settings=contents.metadata.get("settings", {}),
        warnings=tuple(json.loads(record["warnings"])),
        epoch=int(record["epoch_ns"]),
        host_clock=json.loads(record["host_clock"]),
        samples=json.loads(record["samples"]),
    )


def _read_signals(contents: Contents, head: Head) -> tuple[dict[str, Signal], np.ndarray]:
    joints = head.model.robot.joints
    silent = Signal(np.empty(0), np.empty((0, len(joints))))
    signals = dict.fromkeys(head.samples, silent)
    host_time = np.empty(0, np.int64)
    for number, channel in contents.channels.items():
        topic = topic_of(channel.topic, channel.metadata)
        if topic is None:
            continue
        rows = contents.rows(number, topic.template(joints).dtype)
        time = (rows["publish_time"].astype(np.int64) - head.epoch) / 1e9
        signals |= {signal: Signal(time, rows["body"][name]) for signal, name in topic.fields.items()}
        if "position" in topic.fields:
            host_time = rows["log_time"].astype(np.int64)
    # A run that ended before its first sample is a recording too, if only of which robot it was.
    signals.setdefault("position", silent)
    if not any(name in signals for name in EFFORT):
        signals["current"] = silent
    return signals, host_time


def _losses(contents: Contents, head: Head, signals: Mapping[str, Signal]) -> list[str]:
    """What is missing, in sentences."""
    losses = [f"could not be read: {loss}" for loss in contents.lost]
    for name, expected in head.samples.items():
        found = len(signals[name])
        if found < expected:
            lost = expected - found
            seconds = lost * signals[name].period
            losses.append(
                f"{name}: {found} of {expected} samples were read, {lost} ({seconds:.3f} s) are lost"
            )
    if not contents.finished:
        last = signals["position"].time[-1:].tolist()
        until = f"the run is known up to {last[0]:.3f} s" if last else "there is not one sample in it"
        losses.insert(
            0, f"file ends abruptly: {until}; what the recorder still held, at most {CHUNK} bytes, is lost"
        )
    return losses
