"""Tables, or an error, through a pipe: a line of JSON, then the numbers of each table as they lie in memory.

Nothing in it is code, as it would be in a pickle: what comes out of a reader that a file has damaged is data.
"""

import json
from collections.abc import Sequence
from typing import IO, Any

import numpy as np

from ... import errors
from .tables.table import Table


def send(stream: IO[bytes], tables: Sequence[Table]) -> None:
    """Write tables; such readers give no lines of a text file."""
    _send_line(stream, {"tables": [_head(table) for table in tables]})
    for table in tables:
        stream.write(np.ascontiguousarray(table.values, dtype=float).data)
    stream.flush()


def _head(table: Table) -> dict[str, Any]:
    head = table._asdict()
    del head["lines"]
    return head | {"values": table.values.shape}


def send_error(stream: IO[bytes], error: Exception) -> None:
    """Write an error."""
    content: dict[str, Any] = {"error": type(error).__name__, "text": str(error)}
    if isinstance(error, OSError) and error.errno is not None:
        content |= {"number": error.errno, "reason": error.strerror, "file": str(error.filename)}
    _send_line(stream, content)
    stream.flush()


def _send_line(stream: IO[bytes], content: dict[str, Any]) -> None:
    stream.write(json.dumps(content).encode() + b"\n")


def receive(stream: IO[bytes]) -> list[Table]:
    """Read what was written; an error is raised as it was.

    Raises:
        EOFError: The stream ends before its end.
        ExidynError: Of the kind that was written; likewise OSError and MemoryError.
    """
    line = stream.readline()
    if not line.endswith(b"\n"):
        raise EOFError
    content = json.loads(line)
    if "error" in content:
        raise _error(content)
    return [_table(head, stream) for head in content["tables"]]


def _table(head: dict[str, Any], stream: IO[bytes]) -> Table:
    values = np.empty(head["values"])
    left = values.data.cast("B") if values.size else memoryview(b"")
    while left:
        count = stream.readinto(left)  # type: ignore[attr-defined]  # which pipes have
        if not count:
            raise EOFError
        left = left[count:]
    return Table(**head | {"values": values, "joints": tuple(head["joints"])})


def _error(content: dict[str, Any]) -> Exception:
    if "number" in content:
        return OSError(content["number"], content["reason"], content["file"])
    kind = {"MemoryError": MemoryError, "OSError": OSError}.get(content["error"])
    return (kind or getattr(errors, content["error"]))(content["text"])
