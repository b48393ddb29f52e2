"""DiskFile: a new file that is appended to, with room kept back for its end."""

import errno
import os
import tempfile
from pathlib import Path
from threading import Event, Thread

KEPT_BACK = 4 << 20
"""Bytes of disk that are kept back: some ten seconds of an arm's run, enough to brake and write the end."""

SYNC = 1.0
"""Time between asking the operating system to put what was written on the disk [s]. A process that is killed
loses nothing by waiting, only a machine that loses its power does."""

FULL = (errno.ENOSPC, errno.EDQUOT)


class DiskFile:
    """Has what the MCAP writer asks of a stream. A context manager that closes it.

    Attributes:
        full: Why nothing but what was kept back is left; empty while there is room.

    Args:
        path: Of a file that is not there yet.
        kept_back: Bytes.

    Raises:
        OSError: It is there, cannot be created, or the disk has less room than is kept back.
    """

    def __init__(self, path: Path, kept_back: int = KEPT_BACK) -> None:
        self.full = ""
        self._size = 0
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
        self._closing = Event()
        self._syncing = Thread(target=self._sync, daemon=True)
        try:
            # Without a name, so that a crash gives it back too.
            self._kept = tempfile.TemporaryFile(dir=path.parent)
            os.posix_fallocate(self._kept.fileno(), 0, kept_back)
        except OSError:
            os.close(self._file)
            path.unlink()
            raise
        self._syncing.start()

    def write(self, data: bytes) -> int:
        """Append; where the disk is full, into the room kept back.

        Raises:
            OSError: There is none left either, or another reason.
        """
        left = memoryview(data)
        while left:
            try:
                left = left[os.write(self._file, left) :]
            except OSError as error:
                if error.errno not in FULL or self.full:
                    raise
                self.full = error.strerror or "full"
                self._kept.close()
        self._size += len(data)
        return len(data)

    def tell(self) -> int:
        """Bytes written."""
        return self._size

    def flush(self) -> None:
        """Nothing waits here: what is written is the operating system's, and outlives this process."""

    def _sync(self) -> None:
        """In a thread: it takes long on a busy disk."""
        while not self._closing.wait(SYNC):
            try:
                os.fdatasync(self._file)
            except OSError as error:
                self.full = error.strerror or "failing"

    def close(self) -> None:
        """Put all on the disk."""
        if self._closing.is_set():
            return
        self._closing.set()
        self._syncing.join()
        self._kept.close()
        try:
            os.fsync(self._file)
        finally:
            os.close(self._file)

    def __enter__(self) -> "DiskFile":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
