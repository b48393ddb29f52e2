"""The functions of the package that a process enters, written to a file as lines of file, name and line.

A copy of this file called sitecustomize is imported by each Python process that finds it, child processes
too. Environment: WALK_PACKAGE, the folder of the package; WALK_FILE; and WALK_CYCLES where one cycle of the
recording loop is wanted, from one `exchange` with the driver to the next.
"""

import atexit
import os
import sys
import threading
from types import CodeType, FrameType
from typing import Any

PACKAGE = os.environ["WALK_PACKAGE"] + os.sep
DRIVERS = os.path.join(PACKAGE, "drivers", "")
FIRST, LAST = 200, 400
"""Cycles of a run that are looked at: after its beginning, when the motion is played."""
CO_NEWLOCALS = 0x2
"""A flag of functions, which bodies of modules and classes lack."""


class Walk:
    """All that is entered, written when it is entered first: a process may be killed."""

    def __init__(self) -> None:
        self._file = os.open(os.environ["WALK_FILE"], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        self._seen: dict[int, CodeType] = {}

    def __call__(self, frame: FrameType, event: str, _: Any) -> None:
        code = frame.f_code
        if event != "call" or id(code) in self._seen:
            return
        line = entry(frame)
        if line and while_imported(frame):
            return
        self._seen[id(code)] = code  # kept, so that no other gets its id
        os.write(self._file, line.encode())


class Cycle:
    """What the loop's thread enters in each cycle; written at the end: the cycle of median size."""

    def __init__(self) -> None:
        self._cycles: list[set[str]] = []
        self._thread = 0
        atexit.register(self._write)

    def __call__(self, frame: FrameType, event: str, _: Any) -> None:
        if event != "call":
            return
        if begins_cycle(frame):
            self._thread = threading.get_ident()
            self._cycles.append(set())
        if self._thread == threading.get_ident() and len(self._cycles) <= LAST + 1:
            self._cycles[-1].add(entry(frame))

    def _write(self) -> None:
        sys.setprofile(None)
        cycles = sorted(self._cycles[FIRST:LAST], key=len)
        if cycles:
            with open(os.environ["WALK_FILE"], "a", encoding="utf-8") as file:
                file.writelines(cycles[len(cycles) // 2])


def begins_cycle(frame: FrameType) -> bool:
    """Whether a driver is asked by what is not a driver."""
    code, caller = frame.f_code, frame.f_back
    return (
        code.co_name == "exchange"
        and code.co_filename.startswith(DRIVERS)
        and caller is not None
        and not caller.f_code.co_filename.startswith(DRIVERS)
    )


def entry(frame: FrameType) -> str:
    """The line of a function, or of a class whose constructor is generated; empty for all others."""
    code = frame.f_code
    if code.co_filename.startswith(PACKAGE):
        if not code.co_flags & CO_NEWLOCALS or code.co_name.startswith("<"):
            return ""
        place = code.co_filename.removeprefix(PACKAGE)
        return f"{place}\t{code.co_qualname}\t{code.co_firstlineno}\n"
    if code.co_name not in ("__init__", "__new__") or code.co_filename[:1] != "<":
        return ""
    made = frame.f_locals.get("_cls") or type(frame.f_locals.get("self"))
    file = getattr(sys.modules.get(made.__module__), "__file__", None) or ""
    if not file.startswith(PACKAGE):
        return ""
    return f"{file.removeprefix(PACKAGE)}\t{made.__qualname__}.\t0\n"


def while_imported(frame: FrameType) -> bool:
    """Whether a module of the package is being imported: what that calls, nobody follows."""
    above = frame.f_back
    while above is not None:
        if above.f_code.co_name == "<module>" and above.f_code.co_filename.startswith(PACKAGE):
            if above.f_globals.get("__name__") != "__main__":
                return True
        above = above.f_back
    return False


if __name__ == "sitecustomize":
    entered = Cycle() if "WALK_CYCLES" in os.environ else Walk()
    threading.setprofile(entered)
    sys.setprofile(entered)
