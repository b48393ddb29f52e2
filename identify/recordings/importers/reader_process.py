"""The process that reads a file of others, and may die of it; `read_apart` starts it."""

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from ...child_processes import end_with_parent


def main(arguments: Sequence[str]) -> None:
    """Read, and write tables or an error to the standard output.

    Args:
        arguments: Number of the parent, memory [B] or 0, "module:function" in this package, and the path.
    """
    parent, memory, place, source = arguments
    end_with_parent(int(parent), sys.stdin.read)
    _limit_memory(int(memory))
    from ...errors import ExidynError
    from .table_stream import send, send_error

    # Whatever libraries print goes elsewhere than the tables.
    with os.fdopen(os.dup(1), "wb") as stream:
        os.dup2(2, 1)
        module, name = place.split(":")
        try:
            tables = getattr(import_module(f"{__package__}.{module}"), name)(Path(source))
        except (ExidynError, MemoryError, OSError) as error:
            send_error(stream, error)
        else:
            send(stream, tables)


def _limit_memory(memory: int) -> None:
    """Let allocations beyond it fail, so that a damaged size is an error and no other program has to go."""
    if not memory or sys.platform == "win32":
        return
    from resource import RLIMIT_DATA, setrlimit

    setrlimit(RLIMIT_DATA, (memory, memory))


if __name__ == "__main__":
    main(sys.argv[1:])
