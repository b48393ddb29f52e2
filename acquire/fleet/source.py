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
"""A date in a file name, optionally followed by a time."""


class SourceFile(NamedTuple):
    """A recording of a source.

    Attributes:
        path: Path below the source.
        arm: Name of the arm.
        size: Size [B].
        modified: Time of the last change since 1970 [s]; zero if unknown.
    """

    path: str
    arm: str
    size: int
    modified: float


@dataclass(frozen=True)
class Source:
    """The recordings in a folder, or at an address such as s3://bucket/check-runs."""

    address: str

    @property
    def remote(self) -> bool:
        """Whether the source is an address that fsspec reads."""
        return "://" in self.address

    def files(self) -> list[SourceFile]:
        """All recordings, sorted by path; the arm is the first folder below the source.

        Raises:
            NotAFile: If the folder does not exist or contains no recordings.
        """
        files = sorted(self._remote_files() if self.remote else self._local_files())
        if not files:
            raise NotAFile(
                f"{self.address}: no recordings there; expected ARM/RUN{ENDING}, one folder per arm"
            )
        return files

    def _local_files(self) -> Iterator[SourceFile]:
        root = Path(self.address)
        for path in root.rglob(f"*{ENDING}"):
            relative, status = path.relative_to(root).as_posix(), path.stat()
            yield SourceFile(relative, _arm(relative), status.st_size, status.st_mtime)

    def _remote_files(self) -> Iterator[SourceFile]:
        files, root = self._system()
        for path, details in files.find(root, detail=True).items():
            if path.endswith(ENDING):
                relative = str(PurePosixPath(path).relative_to(root))
                changed = details.get("mtime") or details.get("LastModified") or 0.0
                changed = changed.timestamp() if isinstance(changed, datetime) else float(changed)
                yield SourceFile(relative, _arm(relative), int(details["size"]), changed)

    def _system(self) -> tuple[Any, str]:
        files, root = optional("fsspec", "an address", "fleet").core.url_to_fs(self.address)
        return files, str(root).rstrip("/")

    @contextmanager
    def local(self, file: SourceFile) -> Iterator[Path]:
        """Local path of a file within the context; remote files are downloaded."""
        if not self.remote:
            yield Path(self.address) / file.path
            return
        files, root = self._system()
        with TemporaryDirectory(prefix="fleet-") as folder:
            copy = Path(folder) / PurePosixPath(file.path).name
            files.get_file(f"{root}/{file.path}", str(copy))
            yield copy


def _arm(relative: str) -> str:
    parts = PurePosixPath(relative).parts
    return parts[0] if len(parts) > 1 else PurePosixPath(relative).stem


def content_hash(path: Path) -> str:
    """Hash of a recording's content, which identifies it at any path."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:32]


def date_of(recording: Recording, path: str) -> datetime:
    """Start of a run, from the host's clock or its file's name; raises `RecordingError` without a date."""
    if recording.host_time is not None and len(recording.host_time):
        return datetime.fromtimestamp(float(recording.host_time[0]) * 1e-9, UTC)
    if written := IN_NAME.search(PurePosixPath(path).name):
        year, month, day, hour, minute = (int(digits or 0) for digits in written.groups())
        return datetime(year, month, day, hour, minute, tzinfo=UTC)
    raise RecordingError(
        f"{path}: the recording has no clock. Put the date into the file name, such as 2026-05-03T0830.mcap"
    )
