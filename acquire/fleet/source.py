"""Recordings by arm, in a folder or behind any address that fsspec reads."""

import hashlib
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from exidyn.identification.errors import NotAFile, RecordingError
from exidyn.identification.notebook import optional
from exidyn.identification.recordings.recording import Recording

ENDING = ".mcap"
IN_NAME = re.compile(r"(20\d\d)[-_]?([01]\d)[-_]?([0-3]\d)(?:[-_T ]?([0-2]\d)[-_:h]?([0-5]\d))?")
"""A date in a file's name, with a time behind it or not."""


class Found(NamedTuple):
    """A file: path below the source, its arm, size [B], and when it was last changed [s], zero if unknown."""

    path: str
    arm: str
    size: int
    modified: float


@dataclass(frozen=True)
class Source:
    """Where the recordings are: a folder, or an address such as s3://bucket/check-runs."""

    address: str

    @property
    def remote(self) -> bool:
        """Whether fsspec reads it."""
        return "://" in self.address

    def files(self) -> list[Found]:
        """All recordings, by path; the arm is the first folder below the source.

        Raises:
            NotAFile: There is no such folder, or nothing in it.
        """
        found = sorted(self._remote_files() if self.remote else self._local_files())
        if not found:
            raise NotAFile(f"{self.address}: no recordings there; expected ARM/RUN{ENDING}, a folder an arm")
        return found

    def _local_files(self) -> Iterator[Found]:
        root = Path(self.address)
        for path in root.rglob(f"*{ENDING}"):
            inside, status = path.relative_to(root).as_posix(), path.stat()
            yield Found(inside, _arm(inside), status.st_size, status.st_mtime)

    def _remote_files(self) -> Iterator[Found]:
        files, root = self._system()
        for path, details in files.find(root, detail=True).items():
            if path.endswith(ENDING):
                inside = str(PurePosixPath(path).relative_to(root))
                changed = details.get("mtime") or details.get("LastModified") or 0.0
                changed = changed.timestamp() if isinstance(changed, datetime) else float(changed)
                yield Found(inside, _arm(inside), int(details["size"]), changed)

    def _system(self) -> tuple[Any, str]:
        files, root = optional("fsspec", "an address", "fleet").core.url_to_fs(self.address)
        return files, str(root).rstrip("/")

    @contextmanager
    def local(self, found: Found) -> Iterator[Path]:
        """The file as one of this machine."""
        if not self.remote:
            yield Path(self.address) / found.path
            return
        files, root = self._system()
        with TemporaryDirectory(prefix="fleet-") as folder:
            copy = Path(folder) / PurePosixPath(found.path).name
            files.get_file(f"{root}/{found.path}", str(copy))
            yield copy


def _arm(inside: str) -> str:
    parts = PurePosixPath(inside).parts
    return parts[0] if len(parts) > 1 else PurePosixPath(inside).stem


def content_hash(path: Path) -> str:
    """What a recording is known by, wherever it lies."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:32]


def date_of(recording: Recording, path: str) -> datetime:
    """When a run began: by the host's clock, else by its file's name.

    Raises:
        RecordingError: Neither says.
    """
    if recording.host_time is not None and len(recording.host_time):
        return datetime.fromtimestamp(float(recording.host_time[0]) * 1e-9, UTC)
    if written := IN_NAME.search(PurePosixPath(path).name):
        year, month, day, hour, minute = (int(one or 0) for one in written.groups())
        return datetime(year, month, day, hour, minute, tzinfo=UTC)
    raise RecordingError(
        f"{path}: no clock was recorded. Put the date into the file's name, such as 2026-05-03T0830.mcap"
    )
