"""Spawned processes that do not run the main program of their parent again, so a script needs no guard."""

import sys
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType


class ProcessWithoutMain(SpawnProcess):
    """A spawned process in which `__main__` is empty."""

    def start(self) -> None:
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")  # has no file that the new process could run
        try:
            super().start()
        finally:
            sys.modules["__main__"] = main


class ContextWithoutMain(SpawnContext):
    """Context of multiprocessing that starts such processes."""

    Process = ProcessWithoutMain
