"""Read a file by a library in native code in a process apart, which a damaged file may kill.

The process, this file run as a module, writes tables or an error to its standard output: a line of JSON, then
the numbers of each table as they lie in memory. Nothing in it is code, as it would be in a pickle: what comes
out of a reader that a file has damaged is data.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from threading import Timer
from typing import IO, Any

import numpy as np

from ... import errors
from ...child_processes import end_with_parent
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
    files = source.rglob("*") if source.is_dir() else [source]
    seconds = START + sum(path.stat().st_size for path in files if path.is_file()) / SLOWEST
    with (
        tempfile.TemporaryFile() as printed,
        _reader(place, source, printed) as reader,
        _ended_after(seconds, reader) as too_long,
    ):
        assert reader.stdout is not None
        try:
            return _receive(reader.stdout)
        except EOFError:
            code = reader.wait()
        why = f"took more than {seconds:.0f} s" if too_long else _how_it_ended(code, printed)
    raise errors.NotAFile(
        f"{source}: {library}, which reads it, {why}: the file is damaged. Try to write it anew, or as CSV"
    )


@contextmanager
def _reader(place: str, source: Path, printed: IO[bytes]) -> Iterator["subprocess.Popen[bytes]"]:
    """The process, which does not outlive the context; what libraries print in it goes to a file."""
    command = [sys.executable, "-P", "-m", f"{__package__}.read_apart", str(os.getpid()), str(memory())]
    # Modules are looked for where this process does, and linear algebra needs no threads.
    path = os.pathsep.join(filter(None, sys.path))
    reader = subprocess.Popen(
        [*command, place, str(source)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=printed,
        env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
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


def _how_it_ended(code: int, printed: IO[bytes]) -> str:
    """An exit code in words; beyond 255 is Windows, where it is the number of an exception."""
    if code < 0:
        return f"crashed ({signal.Signals(-code).name})"
    printed.seek(0)
    lines = printed.read().decode(errors="replace").split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "")
    return f"crashed (code {code:#x})" if code > 255 else f"ended with code {code} ({last})"


def _receive(stream: IO[bytes]) -> list[Table]:
    """The tables that the process wrote; EOFError where it ended before, and an error is raised as it was."""
    line = stream.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    content = json.loads(line)
    if "number" in content:
        raise OSError(content["number"], content["reason"], content["file"])
    if "error" in content:
        name = content["error"]
        raise {"MemoryError": MemoryError, "OSError": OSError}.get(name, getattr(errors, name, OSError))(
            content["text"]
        )
    tables = []
    for head in content["tables"]:
        values = np.empty(head["values"])
        left = values.data.cast("B") if values.size else memoryview(b"")
        while left:
            count = stream.readinto(left)  # type: ignore[attr-defined]  # which pipes have
            if not count:
                raise EOFError
            left = left[count:]
        tables.append(Table(**head | {"values": values, "joints": tuple(head["joints"])}))
    return tables


def main(arguments: Sequence[str]) -> None:
    """Read, and write tables or an error to the standard output.

    Args:
        arguments: Number of the parent, memory [B] or 0, "module:function" in this package, and the path.
    """
    parent, limit, place, source = arguments
    end_with_parent(int(parent), sys.stdin.read)
    _limit_memory(int(limit))
    # Whatever libraries print goes elsewhere than the tables.
    with os.fdopen(os.dup(1), "wb") as stream:
        os.dup2(2, 1)
        module, name = place.split(":")
        try:
            tables = getattr(import_module(f"{__package__}.{module}"), name)(Path(source))
        except (errors.ExidynError, MemoryError, OSError) as error:
            content: dict[str, Any] = {"error": type(error).__name__, "text": str(error)}
            if isinstance(error, OSError) and error.errno is not None:
                content |= {"number": error.errno, "reason": error.strerror, "file": str(error.filename)}
            stream.write(json.dumps(content).encode() + b"\n")
        else:
            _send(stream, tables)


def _send(stream: IO[bytes], tables: Sequence[Table]) -> None:
    """Write tables; such readers give no lines of a text file."""
    heads = [table._asdict() | {"values": table.values.shape} for table in tables]
    for head in heads:
        del head["lines"]
    stream.write(json.dumps({"tables": heads}).encode() + b"\n")
    for table in tables:
        stream.write(np.ascontiguousarray(table.values, dtype=float).data)


def _limit_memory(limit: int) -> None:
    """Let allocations beyond it fail, so that a damaged size is an error and no other program has to go."""
    if limit and sys.platform != "win32":
        from resource import RLIMIT_DATA, setrlimit

        setrlimit(RLIMIT_DATA, (limit, limit))


if __name__ == "__main__":
    main(sys.argv[1:])
