"""Copy of an MCAP file with other metadata or further topics; recorded messages are repeated unchanged."""

import heapq
import os
from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import itemgetter
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer

from ...errors import RecordingError
from . import cdr
from .mcap_file import host_clock, read_recording
from .mcap_records import Contents, read_contents
from .mcap_topics import Topic, nanoseconds
from .mcap_writer import CHUNK, Stream


def add_topics(
    source: Path,
    target: Path,
    name: str,
    content: Iterable[tuple[Topic, np.ndarray, np.ndarray]],
    settings: Mapping[str, str],
) -> None:
    """Write a copy of a recording with further topics and settings.

    Args:
        source: The recording, which is not changed.
        target: Path of the copy.
        name: Name of the run, which that of the recording must be.
        content: Topics without signals, the times of their messages (t,) [s], and the messages (t,).
        settings: Further settings, by names that the recording does not have.

    Raises:
        NotAFile: The source is not a recording of exidyn.
        RecordingError: The source is damaged, is another run, or already has such settings.
    """
    recording, contents = read_recording(source), read_contents(source)
    if recording.name != name:
        raise RecordingError(f"{source} is a recording of {recording.name}, not of {name}")
    if contents.lost or not contents.finished:
        raise RecordingError(
            f"{source} is damaged or ends abruptly; a copy would hide that. Recover it first "
            "(exidyn info --repair)"
        )
    if repeated := settings.keys() & contents.metadata.get("settings", {}).keys():
        raise RecordingError(f"{source} already has {', '.join(repeated)}; use the original recording")
    epoch = int(contents.metadata["exidyn"]["epoch_ns"])
    streams = []
    for topic, time, messages in content:
        published = nanoseconds(time) + epoch
        streams.append(Stream(topic, published, host_clock(recording, published, epoch), messages))
    more = {"settings": {**contents.metadata.get("settings", {}), **settings}}
    write_copy(contents, target, contents.metadata | more, streams, recording.robot.joints)


def write_copy(
    contents: Contents,
    target: Path,
    metadata: Mapping[str, dict[str, str]],
    added: Sequence[Stream] = (),
    joints: Sequence[str] = (),
) -> array:
    """Write all content of a file and further messages; return the log times of all messages [ns].

    Args:
        contents: Content of the file.
        target: Path of the copy, which gets its name only when it is complete.
        metadata: All metadata records of the copy, by name.
        added: Further messages; those of a topic that the file has too join its channel.
        joints: Names of the joints, for the channels of further topics.
    """
    part = target.with_name(target.name + ".copy")  # not .part, which may be the file that is copied
    with open(part, "wb") as file:
        writer = Writer(file, chunk_size=CHUNK, compression=CompressionType.LZ4)
        writer.start(profile="ros2", library="exidyn")
        for name, record in metadata.items():
            writer.add_metadata(name, record)
        for attached in contents.attachments.values():
            times = attached.create_time, attached.log_time
            writer.add_attachment(*times, attached.name, attached.media_type, attached.data)
        logged = _write_messages(contents, writer, added, joints)
        writer.finish()
    os.replace(part, target)
    return logged


Row = tuple[int, int, bytes, int, int]
"""Log time [ns], number of the channel, body, publish time [ns] and sequence number of a message."""


def _write_messages(
    contents: Contents, writer: Writer, added: Sequence[Stream], joints: Sequence[str]
) -> array:
    """Write all messages in the order of their log times, as far as the file has that order."""
    schemas = {0: 0}
    for number, schema in contents.schemas.items():
        schemas[number] = writer.register_schema(schema.name, schema.encoding, schema.data)
    channels = {
        number: writer.register_channel(
            channel.topic, channel.message_encoding, schemas[channel.schema_id], channel.metadata
        )
        for number, channel in contents.channels.items()
        if channel.schema_id in schemas
    }
    topics = {contents.channels[number].topic: copied for number, copied in channels.items()}
    for topic in (stream.topic for stream in added):
        if topic.name not in topics:
            definition = cdr.SCHEMAS[topic.schema].encode()
            schema_id = writer.register_schema(topic.schema, "ros2msg", definition)
            details = topic.metadata(joints)
            topics[topic.name] = writer.register_channel(topic.name, "cdr", schema_id, details)
    times = array("Q")
    further = [_added(stream, topics[stream.topic.name]) for stream in added]
    for logged, number, body, published, sequence in heapq.merge(
        _recorded(contents, channels), *further, key=itemgetter(0)
    ):
        writer.add_message(number, logged, body, published, sequence)
        times.append(logged)
    return times


def _recorded(contents: Contents, channels: Mapping[int, int]) -> Iterator[Row]:
    for message in contents.messages_in_order():
        if message.channel_id in channels:
            number = channels[message.channel_id]
            yield message.log_time, number, message.data, message.publish_time, message.sequence


def _added(stream: Stream, number: int) -> Iterator[Row]:
    rows = zip(stream.logged.tolist(), stream.published.tolist(), stream.messages, strict=True)
    for logged, published, message in rows:
        yield logged, number, message.tobytes(), published, 0
