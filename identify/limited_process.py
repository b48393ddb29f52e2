"""Work on a file in a process of its own, with limits of memory and time, which a damaged file may kill.

The process, this file run as a module, writes its result or an error to its standard output: a line of JSON,
then the numbers of each array as they lie in memory. Nothing in it is code, as it would be in a pickle: what
comes out of a library that a file has damaged is data.
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
from threading import Timer
from typing import IO, Any

import numpy as np

from . import errors
from .child_processes import end_with_parent

ARRAY = "array"
"""Key of an object that stands for an array in the line of JSON; its value is type and shape."""


class Ended(Exception):
    """A process that ended without a result; the text says how, such as `crashed (SIGSEGV)`."""


def call(place: str, arguments: Sequence[Any], memory: int, seconds: float) -> Any:
    """The result of a function that is called in a process of its own.

    Args:
        place: "module:function" with the module's whole name.
        arguments: Arguments of the function, as JSON holds them.
        memory: Memory that the process may take, and size of a file that it may write [B].
        seconds: Time that it may take [s].

    Returns:
        What the function returned: mappings and lists of texts, numbers and arrays.

    Raises:
        Ended: The process died or took too long.
        MemoryError: The memory was not enough.
        OSError: A file cannot be opened.
        ExidynError: The function raised it; type and text are kept.
    """
    with (
        tempfile.TemporaryDirectory(prefix="exidyn-") as folder,
        tempfile.TemporaryFile() as printed,
        _process(place, arguments, memory, folder, printed) as process,
        _ended_after(seconds, process) as too_long,
    ):
        assert process.stdout is not None
        try:
            return _receive(process.stdout)
        except EOFError:
            code = process.wait()
        raise Ended(f"took more than {seconds:.0f} s" if too_long else _how_it_ended(code, printed))


@contextmanager
def _process(
    place: str, arguments: Sequence[Any], memory: int, folder: str, printed: IO[bytes]
) -> Iterator["subprocess.Popen[bytes]"]:
    """The process, which does not outlive the context; what libraries print in it goes to a file."""
    command = [sys.executable, "-P", "-m", __name__, str(os.getpid()), str(memory), place]
    # Modules are looked for where this process does, and linear algebra needs no threads.
    path = os.pathsep.join(filter(None, sys.path))
    process = subprocess.Popen(
        [*command, json.dumps(list(arguments))],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=printed,
        env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1", "TMPDIR": folder},
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@contextmanager
def _ended_after(seconds: float, process: "subprocess.Popen[bytes]") -> Iterator[list[bool]]:
    """End the process after so long; the list is no longer empty then."""
    ended: list[bool] = []

    def end() -> None:
        ended.append(True)
        process.kill()

    timer = Timer(seconds, end)
    timer.daemon = True
    timer.start()
    try:
        yield ended
    finally:
        timer.cancel()


def _how_it_ended(code: int, printed: IO[bytes]) -> str:
    """An exit code in words; beyond 255 is Windows, where it is the number of an exception."""
    if code < 0:
        return f"crashed ({signal.Signals(-code).name})"
    printed.seek(0)
    lines = printed.read().decode(errors="replace").split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "")
    return f"crashed (code {code:#x})" if code > 255 else f"ended with code {code} ({last})"


def _receive(stream: IO[bytes]) -> Any:
    """The result that the process wrote; EOFError where it ended before, and an error is raised as it was."""
    line = stream.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    content = json.loads(line)
    if "number" in content:
        raise OSError(content["number"], content["reason"], content["file"])
    if "error" in content:
        raise _error(content["error"], content["text"])
    return _filled(content["result"], stream)


def _error(name: str, text: str) -> Exception:
    """An error of a type by its name; its text is made already, and its constructor is not asked again."""
    kind: type[Exception] = {"MemoryError": MemoryError}.get(name, getattr(errors, name, OSError))
    error: Exception = kind.__new__(kind)
    error.args = (text,)
    return error


def _filled(content: Any, stream: IO[bytes]) -> Any:
    """The result with its arrays, whose numbers are read in the order in which they were written."""
    if isinstance(content, list):
        return [_filled(item, stream) for item in content]
    if not isinstance(content, dict):
        return content
    if ARRAY not in content:
        return {key: _filled(item, stream) for key, item in content.items()}
    values = np.empty(content["shape"], content[ARRAY])
    rest = values.data.cast("B") if values.size else memoryview(b"")
    while rest:
        count = stream.readinto(rest)  # type: ignore[attr-defined]  # which pipes have
        if not count:
            raise EOFError
        rest = rest[count:]
    return values


def main(arguments: Sequence[str]) -> None:
    """Call the function, and write its result or an error to the standard output.

    Args:
        arguments: Number of the parent, memory [B], "module:function", and the function's arguments as JSON.
    """
    parent, memory, place, given = arguments
    end_with_parent(int(parent), sys.stdin.read)
    _limit(int(memory))
    # Whatever libraries print goes elsewhere than the result.
    with os.fdopen(os.dup(1), "wb") as stream:
        os.dup2(2, 1)
        module, name = place.split(":")
        arrays: list[np.ndarray] = []
        try:
            content = {"result": _emptied(getattr(import_module(module), name)(*json.loads(given)), arrays)}
        except (errors.ExidynError, MemoryError, OSError) as error:
            content = {"error": type(error).__name__, "text": str(error)}
            if isinstance(error, OSError) and error.errno is not None:
                content |= {"number": error.errno, "reason": error.strerror, "file": str(error.filename)}
        stream.write(json.dumps(content).encode() + b"\n")
        for array in arrays:
            stream.write(array.data)


def _emptied(content: Any, arrays: list[np.ndarray]) -> Any:
    """The result without the numbers of its arrays, which are collected."""
    if isinstance(content, np.ndarray):
        arrays.append(np.ascontiguousarray(content))
        return {ARRAY: content.dtype.str, "shape": content.shape}
    if isinstance(content, dict):
        return {key: _emptied(item, arrays) for key, item in content.items()}
    return [_emptied(item, arrays) for item in content] if isinstance(content, list | tuple) else content


def _limit(memory: int) -> None:
    """Let allocations beyond it fail, so that a damaged size is an error and no other program has to go."""
    if sys.platform != "win32":
        from resource import RLIMIT_DATA, RLIMIT_FSIZE, setrlimit

        setrlimit(RLIMIT_DATA, (memory, memory))
        setrlimit(RLIMIT_FSIZE, (memory, memory))


if __name__ == "__main__":
    main(sys.argv[1:])
