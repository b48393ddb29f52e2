"""Expansion of xacro macros in a separate process: their expressions are Python and may run forever.

The process has limits of time and memory, starts no programs, writes no files, and reads only files that the
description may name.
"""

import sys
from collections.abc import Callable
from pathlib import Path

from ..errors import BrokenTree, RobotError
from ..limited_process import Ended, call
from ..notebook import optional
from .folders import Folders, outside

SECONDS = 30.0
"""Maximum duration of an expansion [s]; the largest robots take two seconds, on a busy machine ten."""
MEMORY = 500_000_000
"""Maximum memory of an expansion [B]; the largest robots take 60 MB, including Python and xacro."""
READ = ("r", "rb", "rt", None)
"""Modes in which a file is only read; None if a library passes flags."""
FORBIDDEN = (
    "subprocess.", "socket.", "shutil.", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork",
    "os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod",
    "os.chown",
)  # fmt: skip
"""Audit events of Python for actions that no macro needs: programs, networks, and changes of files."""


def expanded(path: Path) -> str:
    """URDF to which a file of macros expands, with the defaults of their arguments."""
    optional("xacro", f"{path.name}, a file of macros,", "xacro")
    try:
        text = call(f"{__name__}:expand", [str(path)], MEMORY, SECONDS)
        return str(text)
    except Ended as error:
        raise BrokenTree(f"{path}: xacro {error}. {_advice(path)}") from None
    except MemoryError:
        raise BrokenTree(f"{path}: xacro needs more than {MEMORY / 1e6:.0f} MB. {_advice(path)}") from None


def _advice(path: Path) -> str:
    return (
        "If it needs arguments, ROS packages or more time, expand it where those are: "
        f"xacro {path.name} NAME:=VALUE > arm.urdf"
    )


def expand(source: str) -> str:
    """URDF to which a file of macros expands; this runs in the separate process."""
    import xacro

    path, refused = Path(source), list[str]()
    sys.addaudithook(_guard(Folders.of(path), refused))
    try:
        return str(xacro.process_file(source).toxml())
    except Exception as error:  # macros hold Python expressions, which may raise anything
        if isinstance(getattr(error, "exc", error), MemoryError):  # xacro may have wrapped it
            raise MemoryError from None
        if refused:
            raise RobotError(f"{path}: xacro: {refused[0]}") from None
        raise BrokenTree(f"{path}: xacro: {error}. {_advice(path)}") from None


def _guard(folders: Folders, refused: list[str]) -> Callable[[str, tuple[object, ...]], None]:
    """Audit hook of Python that refuses actions that no macro needs, and adds them to `refused`."""
    python = {Path(entry).resolve() for entry in (*sys.path, sys.prefix, sys.base_prefix) if entry}

    def refuse(reason: str) -> None:
        refused.append(reason)
        raise PermissionError(reason)

    def guard(event: str, arguments: tuple[object, ...]) -> None:
        if event.startswith(FORBIDDEN):
            refuse(f"{event} is not allowed in macros")
        if event != "open" or not isinstance(arguments[0], str | bytes):
            return
        name, mode = arguments[:2]
        file = Path(name.decode(errors="replace") if isinstance(name, bytes) else str(name))
        if mode not in READ:
            refuse(f"macros may not write {file}")
        real = file.resolve()
        if not folders.hold(file) and not any(real.is_relative_to(folder) for folder in python):
            refuse(outside(file))

    return guard
