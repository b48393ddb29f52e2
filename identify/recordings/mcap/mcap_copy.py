"""Copy of an MCAP file with other metadata; recorded messages are repeated unchanged."""

import os
from array import array
from collections.abc import Mapping
from pathlib import Path

from mcap.writer import CompressionType, Writer

from .mcap_records import Contents
from .mcap_writer import CHUNK


def write_copy(contents: Contents, target: Path, metadata: Mapping[str, dict[str, str]]) -> array:
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
