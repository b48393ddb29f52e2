"""Read a file by a library in native code in a process apart, which a damaged file may kill."""

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Timer
from typing import IO

from ...errors import NotAFile
from .table_stream import receive
from .tables.table import Table

START = 60.0
"""How long libraries may take to be imported, on a busy machine with a cold disk [s]; usually 0.3 s."""
SLOWEST = 1e6
"""Bytes of the file that are read in a second at least: less than a hundredth of what decompression takes."""
SHARE = 0.5
"""Memory of a reader, of what the machine has: what it read is held twice while it is handed over."""


def read_apart(place: str, library: str, source: Path) -> list[Table]:
    """The tables that a reader finds in a file.

    Args:
        place: "module:function" in this package; the function takes a path.
        library: What errors call the reader.
        source: File or folder.

    Raises:
        NotAFile: The reader died, took too long, or refused the file.
        RecordingError: The file is no table; whatever else the reader raises on purpose, too.
        MissingPackage: The library is not installed.
        OSError: The file cannot be opened.
        MemoryError: The reader's memory was not enough.
    """
    seconds = START + _size(source) / SLOWEST
    with (
        tempfile.TemporaryFile() as printed,
        _reader(place, source, printed) as reader,
        _ended_after(seconds, reader) as too_long,
    ):
        assert reader.stdout is not None
        try:
            return receive(reader.stdout)
        except EOFError:
            code = reader.wait()
        why = f"took more than {seconds:.0f} s" if too_long else _how_it_ended(code, printed)
    raise NotAFile(
        f"{source}: {library}, which reads it, {why}: the file is damaged. Try to write it anew, or as CSV"
    )


@contextmanager
def _reader(place: str, source: Path, printed: IO[bytes]) -> Iterator["subprocess.Popen[bytes]"]:
    """The process, which does not outlive the context; what libraries print in it goes to a file."""
    command = [sys.executable, "-P", "-m", f"{__package__}.reader_process", str(os.getpid()), str(memory())]
    # Modules are looked for where this process does, and linear algebra needs no threads.
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "OMP_NUM_THREADS": "1",
    }
    reader = subprocess.Popen(
        [*command, place, str(source)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=printed,
        env=environment,
    )
    try:
        yield reader
    finally:
        reader.kill()
        reader.communicate()


@contextmanager
def _ended_after(seconds: float, reader: "subprocess.Popen[bytes]") -> Iterator[list[bool]]:
    """End the reader after so long; the list is no longer empty then."""
    ended: list[bool] = []

    def end() -> None:
        ended.append(True)
        reader.kill()

    timer = Timer(seconds, end)
    timer.daemon = True
    timer.start()
    try:
        yield ended
    finally:
        timer.cancel()


def memory() -> int:
    """How much a reader may take [B]; 0 where the system does not tell what it has."""
    try:
        return int(SHARE * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return 0


def _size(source: Path) -> int:
    files = source.rglob("*") if source.is_dir() else [source]
    return sum(path.stat().st_size for path in files if path.is_file())


def _how_it_ended(code: int, printed: IO[bytes]) -> str:
    """An exit code in words; beyond 255 is Windows, where it is the number of an exception."""
    if code < 0:
        return f"crashed ({signal.Signals(-code).name})"
    printed.seek(0)
    lines = printed.read().decode(errors="replace").split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "")
    return f"crashed (code {code:#x})" if code > 255 else f"ended with code {code} ({last})"
