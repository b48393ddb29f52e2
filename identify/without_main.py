"""Spawned processes that do not run the program of their parent again, so that a script needs no guard."""

import sys
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType


class ProcessWithoutMain(SpawnProcess):
    """A spawned process in which `__main__` is empty."""

    def start(self) -> None:
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")  # it has no file that the new process would run
        try:
            super().start()
        finally:
            sys.modules["__main__"] = main


class ContextWithoutMain(SpawnContext):
    """Makes such processes."""

    Process = ProcessWithoutMain
