"""Recovery of a complete file, with the index that viewers need, from the remains of a crash or bad copy."""

import json
import os
from array import array
from dataclasses import dataclass
from pathlib import Path

from mcap.writer import CompressionType, Writer

from ...errors import NotAFile, RecordingError
from .mcap_records import Contents, read_contents
from .mcap_writer import CHUNK


@dataclass(frozen=True)
class Recovered:
    """Result of a recovery.

    Attributes:
        messages: Number of recovered messages.
        begin: Host clock at the first message [ns since 1970].
        end: Host clock at the last message [ns since 1970].
        lost: Phrases about missing content; empty if the file was complete.
    """

    messages: int
    begin: int
    end: int
    lost: tuple[str, ...]

    @property
    def seconds(self) -> float:
        """Time from the first message to the last [s]."""
        return 1e-9 * (self.end - self.begin)


def recover(source: Path, target: Path) -> Recovered:
    """Write a complete file with all readable messages of another file, which is not changed.

    The new recording names its source and what is missing.

    Raises:
        NotAFile: The source has no readable content.
        RecordingError: The target exists.
    """
    contents = read_contents(source)
    if target.exists():
        raise RecordingError(f"{target} exists and is not written over. Choose another name (--output)")
    lost = (*contents.lost, *_losses(contents))
    if not contents.metadata and not contents.chunks:
        raise NotAFile(f"{source}: there is nothing in it to rescue; {'; '.join(lost)}")
    part = target.with_name(target.name + ".rescue")
    with open(part, "wb") as file:
        writer = Writer(file, chunk_size=CHUNK, compression=CompressionType.LZ4)
        writer.start(profile="ros2", library="exidyn")
        _explain(contents, writer, source, lost)
        times = _repeat(contents, writer)
        writer.finish()
    os.replace(part, target)
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


def _explain(contents: Contents, writer: Writer, source: Path, lost: tuple[str, ...]) -> None:
    for name, record in contents.metadata.items():
        writer.add_metadata(name, _with_warning(record, source, lost) if name == "exidyn" else record)
    for attachment in contents.attachments.values():
        writer.add_attachment(
            attachment.create_time,
            attachment.log_time,
            attachment.name,
            attachment.media_type,
            attachment.data,
        )


def _with_warning(record: dict[str, str], source: Path, lost: tuple[str, ...]) -> dict[str, str]:
    """Description of a recording, with a warning if something is missing."""
    warning = f"recovered from {source.name}, without {'; '.join(lost)}" if lost else ""
    try:
        warnings = json.loads(record.get("warnings", "[]"))
    except ValueError:
        warnings = []
    return record | {"warnings": json.dumps([*warnings, warning] if warning else warnings)}


def _repeat(contents: Contents, writer: Writer) -> array:
    """Write all messages unchanged and in order, with new channel numbers; return their log times [ns]."""
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
            number, logged = channels[message.channel_id], message.log_time
            writer.add_message(number, logged, message.data, message.publish_time, message.sequence)
            times.append(logged)
    return times
