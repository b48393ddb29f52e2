"""Recovery of a complete file, with the index that viewers need, from the remains of a crash or bad copy."""

import json
from dataclasses import dataclass
from pathlib import Path

from ...errors import NotAFile, RecordingError
from .mcap_copy import write_copy
from .mcap_records import Contents, read_contents


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
    metadata = {
        name: _with_warning(record, source, lost) if name == "exidyn" else record
        for name, record in contents.metadata.items()
    }
    times = write_copy(contents, target, metadata)
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
