"""Child processes that end when their parent ends, even if the parent is killed.

On Linux the kernel kills a child once the thread that started it has ended (prctl, PR_SET_PDEATHSIG).
Elsewhere a thread of the child waits for the other end of a pipe to close. Two kinds of children outlive
their parent on purpose and are not started here: the recorder of a run, which finishes its file, and the
process of the driver `franka`, which stops the arm. Both end when their pipe or socket closes.

External programs are started through this file as a script, so it needs only the standard library.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from typing import IO, TYPE_CHECKING, Any

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor

PR_SET_PDEATHSIG = 1
"""Option of prctl, from <sys/prctl.h>: the signal that a process receives when its parent ends."""
LIVES_ON = 0
"""Stands for the parent's process ID if the program outlives its parent."""


def end_with_parent(parent: int, wait_for_its_end: Callable[[], object]) -> None:
    """End this process once its parent has ended; the child calls this as early as possible.

    If the parent with that process ID has already ended, this process ends at once. Where the kernel cannot
    watch the parent, a thread calls `wait_for_its_end`, which returns when the parent has ended.
    """
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # the parent ended before the line above
            os._exit(1)
    else:
        _in_thread(lambda: (wait_for_its_end(), os._exit(1)))


def process_pool(
    workers: int,
    initializer: Callable[..., object] | None = None,
    initargs: Sequence[Any] = (),
    with_main: bool = False,
) -> "ProcessPoolExecutor":
    """Pool of spawned processes that end with this process; only the thread that creates it may use it.

    The processes do not run the main program again, so a script needs no guard. With `with_main` they do,
    which makes the definitions of the script available to them.
    """
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    from .without_main import ContextWithoutMain

    begin = (os.getpid(), initializer, tuple(initargs))
    context = get_context("spawn") if with_main else ContextWithoutMain()
    return ProcessPoolExecutor(workers, context, _begin_worker, begin)


def _begin_worker(parent: int, initializer: Callable[..., object] | None, initargs: tuple[Any, ...]) -> None:
    from multiprocessing import parent_process
    from multiprocessing.connection import wait

    started_by = parent_process()
    assert started_by is not None
    end_with_parent(parent, lambda: wait([started_by.sentinel]))
    if initializer is not None:
        initializer(*initargs)


def start_program(
    command: Sequence[str], output: IO[bytes] | int, lives_on: bool = False
) -> "subprocess.Popen[bytes]":
    """Start an external program; signals that this process ignores have their default effect on it.

    With `lives_on` the program outlives this process, in a session of its own.
    """
    parent = LIVES_ON if lives_on else os.getpid()
    return subprocess.Popen(
        [sys.executable, "-I", "-S", __file__, str(parent), *command],
        stdin=subprocess.DEVNULL if lives_on else subprocess.PIPE,
        stdout=output,
        stderr=output,
        start_new_session=lives_on,
    )


def main(arguments: Sequence[str]) -> int:
    """Become the program, or watch over it where the kernel cannot.

    Args:
        arguments: Process ID of the parent, and the command.
    """
    parent, command = int(arguments[0]), list(arguments[1:])
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)
    if sys.platform == "linux":
        if parent != LIVES_ON:
            end_with_parent(parent, sys.stdin.read)
        os.execv(command[0], command)  # the kernel's parent-death signal stays in effect
    program = subprocess.Popen(command)
    if parent != LIVES_ON:
        _in_thread(lambda: (sys.stdin.read(), program.kill()))
    return program.wait()


def _in_thread(work: Callable[[], object]) -> None:
    from threading import Thread

    Thread(target=work, daemon=True).start()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
