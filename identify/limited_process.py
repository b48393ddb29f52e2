"""Read a file in a separate process with limits of memory and time, since a damaged file may crash it.

The process runs this file as a module. It writes its result or an error to its standard output: a line of
JSON, then the raw numbers of each array. Unlike a pickle, this holds no code: even if a damaged file has
corrupted a library, the result is only data.
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
"""Key of a JSON object that stands for an array; its value is the type, beside the key `shape`."""


class Ended(Exception):
    """The process ended without a result; the text says how, such as `crashed (SIGSEGV)`."""


def call(place: str, arguments: Sequence[Any], memory: int, seconds: float) -> Any:
    """Result of a function that is called in a separate process.

    Args:
        place: "module:function" with the full name of the module.
        arguments: Arguments of the function, which JSON can represent.
        memory: Maximum memory of the process, and maximum size of a file that it writes [B].
        seconds: Maximum duration [s].

    Returns:
        Return value of the function: mappings and lists of texts, numbers and arrays.

    Raises:
        Ended: The process crashed or took too long.
        MemoryError: The memory limit was exceeded.
        OSError: A file cannot be opened.
        ExidynError: The function raised it; type and text are preserved.
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
    """The process, which ends with the context; the output of libraries goes to the file `printed`."""
    command = [sys.executable, "-P", "-m", __name__, str(os.getpid()), str(memory), place]
    # The process finds modules on the path of this one, and needs no threads for linear algebra.
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
    """End the process after a time [s]; the list is not empty once it was ended."""
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
    """Description of an exit code; codes above 255 are exception numbers of Windows."""
    if code < 0:
        return f"crashed ({signal.Signals(-code).name})"
    printed.seek(0)
    lines = printed.read().decode(errors="replace").split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "")
    return f"crashed (code {code:#x})" if code > 255 else f"ended with code {code} ({last})"


def _receive(stream: IO[bytes]) -> Any:
    """Result that the process wrote.

    Raises EOFError if the process ended before it wrote one, and raises the function's own error again.
    """
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
    """Error from the name of its type and its final text, which its constructor would format again."""
    kind: type[Exception] = {"MemoryError": MemoryError}.get(name, getattr(errors, name, OSError))
    error: Exception = kind.__new__(kind)
    error.args = (text,)
    return error


def _filled(content: Any, stream: IO[bytes]) -> Any:
    """Result with its arrays, whose numbers are read in the order in which they were written."""
    if isinstance(content, list):
        return [_filled(item, stream) for item in content]
    if not isinstance(content, dict):
        return content
    if ARRAY not in content:
        return {key: _filled(item, stream) for key, item in content.items()}
    values = np.empty(content["shape"], content[ARRAY])
    unfilled = values.data.cast("B") if values.size else memoryview(b"")
    while unfilled:
        count = stream.readinto(unfilled)  # type: ignore[attr-defined]  # pipes have it
        if not count:
            raise EOFError
        unfilled = unfilled[count:]
    return values


def main(arguments: Sequence[str]) -> None:
    """Call the function, and write its result or an error to the standard output.

    Args:
        arguments: Process ID of the parent, memory [B], "module:function", and the arguments as JSON.
    """
    parent, memory, place, packed = arguments
    end_with_parent(int(parent), sys.stdin.read)
    _limit(int(memory))
    # The output of libraries must not mix with the result.
    with os.fdopen(os.dup(1), "wb") as stream:
        os.dup2(2, 1)
        module, name = place.split(":")
        arrays: list[np.ndarray] = []
        try:
            content = {"result": _emptied(getattr(import_module(module), name)(*json.loads(packed)), arrays)}
        except (errors.ExidynError, MemoryError, OSError) as error:
            content = {"error": type(error).__name__, "text": str(error)}
            if isinstance(error, OSError) and error.errno is not None:
                content |= {"number": error.errno, "reason": error.strerror, "file": str(error.filename)}
        stream.write(json.dumps(content).encode() + b"\n")
        for array in arrays:
            stream.write(array.data)


def _emptied(content: Any, arrays: list[np.ndarray]) -> Any:
    """Result with a placeholder for each array; the arrays are appended to `arrays`."""
    if isinstance(content, np.ndarray):
        arrays.append(np.ascontiguousarray(content))
        return {ARRAY: content.dtype.str, "shape": content.shape}
    if isinstance(content, dict):
        return {key: _emptied(item, arrays) for key, item in content.items()}
    return [_emptied(item, arrays) for item in content] if isinstance(content, list | tuple) else content


def _limit(memory: int) -> None:
    """Let larger allocations fail: a damaged size causes an error and takes no memory from other programs."""
    if sys.platform != "win32":
        from resource import RLIMIT_DATA, RLIMIT_FSIZE, setrlimit

        setrlimit(RLIMIT_DATA, (memory, memory))
        setrlimit(RLIMIT_FSIZE, (memory, memory))


if __name__ == "__main__":
    main(sys.argv[1:])
