"""Recovery of a complete file, with the index that viewers need, from the remains of a crash or bad copy."""

import json
import os
from array import array
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mcap.writer import CompressionType, Writer

from ...errors import NotAFile, RecordingError
from .mcap_records import Contents, read_contents
from .mcap_writer import CHUNK


@dataclass(frozen=True)
class Recovered:
    """Result of a recovery."""

    messages: int  # number of recovered messages
    begin: int  # host clock at the first message [ns since 1970]
    end: int  # host clock at the last message [ns since 1970]
    lost: tuple[str, ...]  # phrases about missing content; empty if the file was complete

    @property
    def seconds(self) -> float:
        """Time from the first message to the last [s]."""
        return 1e-9 * (self.end - self.begin)


def recover(source: Path, target: Path) -> Recovered:
    """Write a complete file with all readable messages of another file, which is not changed.

    The new recording names its source and what is missing.
    """
    contents = read_contents(source)
    if target.exists():
        raise RecordingError(f"{target} exists and is not written over. Choose another name (--output)")
    lost = (*contents.lost, *_losses(contents))
    if not contents.metadata and not contents.chunks:
        raise NotAFile(f"{source}: there is nothing in it to rescue; {'; '.join(lost)}")
    metadata = {
        name: _with_warning(record, source, lost) if name == "exidyn" else record
        for name, record in contents.metadata.items()
    }
    times = _write_copy(contents, target, metadata)
    return Recovered(len(times), min(times, default=0), max(times, default=0), lost)


def _losses(contents: Contents) -> list[str]:
    losses = []
    described = {
        number for number, channel in contents.channels.items() if channel.schema_id in (0, *contents.schemas)
    }
    unknown = sum(message.channel_id not in described for message in contents.messages_in_order())
    if unknown:
        losses.append(f"{unknown} messages of topics whose description is damaged")
    if not contents.finished:
        losses.append("whatever came after the end of the file")
    return losses


def _with_warning(record: dict[str, str], source: Path, lost: tuple[str, ...]) -> dict[str, str]:
    """Description of a recording, with a warning if something is missing."""
    warning = f"recovered from {source.name}, without {'; '.join(lost)}" if lost else ""
    try:
        warnings = json.loads(record.get("warnings", "[]"))
    except ValueError:
        warnings = []
    return record | {"warnings": json.dumps([*warnings, warning] if warning else warnings)}


def _write_copy(contents: Contents, target: Path, metadata: Mapping[str, dict[str, str]]) -> array:
    """Write all content of a file with other metadata; return the log times of all messages [ns].

    The copy gets its name only when it is complete.
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
        logged = _write_messages(contents, writer)
        writer.finish()
    os.replace(part, target)
    return logged


def _write_messages(contents: Contents, writer: Writer) -> array:
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
    times = array("Q")
    for message in contents.messages_in_order():
        if message.channel_id in channels:
            number = channels[message.channel_id]
            writer.add_message(number, message.log_time, message.data, message.publish_time, message.sequence)
            times.append(message.log_time)
    return times
