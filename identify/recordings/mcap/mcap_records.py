"""Records of an MCAP file, as far as they can be read: a file of a run that crashed has no end.

Python iterates only over the frames of records (one byte kind, eight bytes length). Messages stay in their
chunk until `rows` takes all messages of a channel at once. The reader of the package mcap stops at the first
chunk that is damaged or cut off, and takes eight times as long; only its parsers of single records are used.
A complete file, with the index that viewers need, is recovered from the remains of a crash or a bad copy.
"""

import json
import mmap
import os
import struct
import zlib
from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from ...errors import NotAFile, RecordingError
from ...file_names import read_failure
from ..reading_limits import LEAST, largest_size, too_large
from .mcap_writer import CHUNK

MAGIC = b"\x89MCAP0\r\n"
_FRAME = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQI")
_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_HEAD = [
    ("opcode", "u1"),
    ("length", "<u8"),
    ("channel", "<u2"),
    ("sequence", "<u4"),
    ("log_time", "<u8"),
    ("publish_time", "<u8"),
]


@dataclass
class Contents:
    """Content of a file, as far as it could be read."""

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)  # metadata records by name
    attachments: dict[str, Attachment] = field(default_factory=dict)  # attached files by name
    channels: dict[int, Channel] = field(default_factory=dict)  # channels by number
    schemas: dict[int, Schema] = field(default_factory=dict)  # message types by number
    # Messages of each channel: pairs of a chunk's bytes and offsets into it.
    messages: dict[int, list[tuple[np.ndarray, np.ndarray]]] = field(default_factory=dict)
    # Unpacked content of each chunk, as far as it could be read.
    chunks: list[bytes] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)  # phrases about content that could not be read
    finished: bool = False  # whether the writer finished the file
    room: int = LEAST  # maximum total size of the chunks that are not yet unpacked [B]

    def rows(self, channel: int, message: np.dtype) -> np.ndarray:
        """All messages of a channel, shape (t,): log_time, publish_time [ns] and `body`, a `message`.

        Messages of another length count as lost.
        """
        record = np.dtype([*_MESSAGE_HEAD, ("body", message)])
        parts = [np.empty(0, record)]
        for data, offsets in self.messages.get(channel, []):
            inside = offsets[offsets + record.itemsize <= len(data)]
            windows = np.lib.stride_tricks.sliding_window_view(data, record.itemsize) if len(inside) else data
            records = windows[inside].reshape(-1).view(record)
            valid = records["length"] == record.itemsize - _FRAME.size
            if len(inside) < len(offsets) or not valid.all():
                self.lost.append(
                    f"{len(offsets) - valid.sum()} messages of an unexpected length were skipped"
                )
            parts.append(records[valid])
        return np.concatenate(parts)

    def messages_in_order(self) -> Iterator[Message]:
        """All messages, in the order of the file."""
        for data in self.chunks:
            for kind, body, complete in _records(memoryview(data), 0):
                if kind == Opcode.MESSAGE and complete and len(body) >= _MESSAGE.size - _FRAME.size:
                    yield Message.read(ReadDataStream(BytesIO(body)), len(body))

    def bodies(self, channel: int) -> Iterator[tuple[int, bytes]]:
        """Publish_time [ns] and body of each message of a channel, of any length."""
        for data, offsets in self.messages.get(channel, []):
            for start in offsets.tolist():
                _, length, _, _, _, published = _MESSAGE.unpack(data[start : start + _MESSAGE.size].tobytes())
                yield published, data[start + _MESSAGE.size : start + _FRAME.size + length].tobytes()


def read_contents(path: Path) -> Contents:
    """Read a file as far as possible."""
    try:
        with open(path, "rb") as file:
            if not path.stat().st_size:
                raise NotAFile(f"{path} is empty: the recorder wrote nothing, or the copy failed")
            data = memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
    except OSError as error:
        raise NotAFile(f"{path} cannot be read: {read_failure(path, error)}") from error
    if bytes(data[: len(MAGIC)]) != MAGIC:
        begin = bytes(data[: len(MAGIC)])
        raise NotAFile(
            f"{path} is not an MCAP file: it begins with {begin!r}; other formats are imported first"
        )
    contents = Contents(room=largest_size(path))
    for kind, body, complete in _records(data, len(MAGIC)):
        _read(contents, kind, body, complete)
        if contents.room < 0:
            raise too_large(path)
    return contents


def _records(data: memoryview, start: int) -> Iterator[tuple[int, memoryview, bool]]:
    """Kind, body and completeness of each record; the last one may be cut off."""
    end = len(data)
    while start + _FRAME.size <= end:
        kind, length = _FRAME.unpack_from(data, start)
        start += _FRAME.size
        stop = start + length
        yield kind, data[start : min(stop, end)], stop <= end
        if kind == Opcode.FOOTER:
            return
        start = stop


_TABLES: dict[int, tuple[Any, str, str]] = {
    Opcode.SCHEMA: (Schema, "schemas", "id"),
    Opcode.CHANNEL: (Channel, "channels", "id"),
    Opcode.METADATA: (Metadata, "metadata", "name"),
    Opcode.ATTACHMENT: (Attachment, "attachments", "name"),
}
"""Kind of a record -> its parser, the table of `Contents` that holds it, and its key there."""


def _read(contents: Contents, kind: int, body: memoryview, complete: bool) -> None:
    """Add a record to the contents, unless it is damaged or of a kind that is not needed."""
    if kind == Opcode.CHUNK:
        _chunk(contents, body, complete)
    elif kind == Opcode.FOOTER:
        contents.finished = complete
    elif kind in _TABLES and complete:
        parser, table, key = _TABLES[kind]
        try:
            record = parser.read(ReadDataStream(BytesIO(body)))
        except Exception:  # the library's parser raises struct.error, UnicodeError, …
            return
        getattr(contents, table)[getattr(record, key)] = (
            record.metadata if kind == Opcode.METADATA else record
        )


def _chunk(contents: Contents, body: memoryview, complete: bool) -> None:
    """Unpack a chunk and index its messages; of a chunk that was cut off, unpack its complete blocks."""
    if len(body) < _CHUNK.size + 4:
        contents.lost.append(f"{len(body)} bytes at its end")
        return
    begin, end, size, checksum = _CHUNK.unpack_from(body)
    head = _CHUNK.size + 4 + int.from_bytes(body[_CHUNK.size : _CHUNK.size + 4], "little")
    packing = bytes(body[_CHUNK.size + 4 : head]).decode(errors="replace")
    data = _unpacked(packing, body[head + 8 :], min(size, contents.room + 1))
    contents.room -= len(data)
    if contents.room < 0:
        return
    intact = complete and len(data) == size and (not checksum or zlib.crc32(data) == checksum)
    if not intact:
        contents.lost.append(
            f"part of a chunk of {(end - begin) * 1e-9:.3f} s: {size - len(data)} of its {size} bytes"
            if not complete
            else f"a damaged chunk of {(end - begin) * 1e-9:.3f} s"
        )
        data = data if not complete else b""
    _index(contents, data)


def _unpacked(packing: str, packed: memoryview, size: int) -> bytes:
    """Content of a chunk, as far as its compressed blocks are complete."""
    if packing == "":
        return bytes(packed[:size])
    if packing != "lz4":
        raise NotAFile(
            f"chunks are compressed by '{packing}'; valid are lz4 and none. Compress the file again with lz4"
        )
    unpacker = lz4.frame.LZ4FrameDecompressor()
    parts = []
    try:
        for start in range(0, len(packed), _PIECE):  # in pieces, so that damage affects only what follows
            parts.append(unpacker.decompress(packed[start : start + _PIECE], max_length=size))
            size -= len(parts[-1])
            if unpacker.eof or size <= 0:
                break
    except RuntimeError:
        pass
    return b"".join(parts)


_PIECE = 1 << 16


def _index(contents: Contents, data: bytes) -> None:
    """Store the offset of each complete message, by channel."""
    offsets: dict[int, list[int]] = {}
    start, end, frame = 0, len(data), _FRAME.size
    unpack, message = struct.Struct("<BQH").unpack_from, int(Opcode.MESSAGE)
    while start + frame + 2 <= end:
        kind, length, channel = unpack(data, start)
        stop = start + frame + length
        if stop > end:
            break
        if kind == message and length >= _MESSAGE.size - frame:
            offsets.setdefault(channel, []).append(start)
        elif kind in (Opcode.CHANNEL, Opcode.SCHEMA):
            _read(contents, kind, memoryview(data)[start + frame : stop], True)
        start = stop
    contents.chunks.append(data)
    array = np.frombuffer(data, np.uint8)
    for channel, starts in offsets.items():
        contents.messages.setdefault(channel, []).append((array, np.array(starts)))


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
