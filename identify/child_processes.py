"""Child processes that end with the process that started them, however that ends: killed, too.

On Linux the kernel kills a child once the thread that started it has ended (prctl, PR_SET_PDEATHSIG).
Elsewhere a thread of the child waits for the other end of a pipe to close. Two kinds of children outlive
their parent on purpose and do not come from here: the recorder of a run, which finishes its file, and the
process of the driver `franka`, which brings the arm to rest; both end when their pipe or socket closes.

A program of others is started through this file as a script, which needs the standard library only.
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
"""Of <sys/prctl.h>: the signal that a process gets when its parent ends."""
LIVES_ON = 0
"""In place of the parent's number: of a program that outlives it."""


def end_with_parent(parent: int, wait_for_its_end: Callable[[], object]) -> None:
    """End this process once its parent has ended; to be called by the child as early as possible.

    If the parent of that number has ended already, so does this process. `wait_for_its_end` returns when it
    has, and is called in a thread where the kernel cannot watch.
    """
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it ended before the line above
            os._exit(1)
    else:
        _in_thread(lambda: (wait_for_its_end(), os._exit(1)))


def process_pool(
    workers: int,
    initializer: Callable[..., object] | None = None,
    initargs: Sequence[Any] = (),
    with_main: bool = False,
) -> "ProcessPoolExecutor":
    """A pool of spawned processes, which end with this one; to be used by the thread that makes it.

    They do not run the program of this process again, so that a script needs no guard; `with_main` has them
    do so, for what it defines.
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
    """Start a program of others; signals that this process ignores have their usual effect on it.

    One that `lives_on` outlives this process, in a session of its own.
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
    """Become the program, or watch over it where the kernel does not: the parent's number, and a command."""
    parent, command = int(arguments[0]), list(arguments[1:])
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_DFL)
    if sys.platform == "linux":
        if parent != LIVES_ON:
            end_with_parent(parent, sys.stdin.read)
        os.execv(command[0], command)  # which keeps what was asked of the kernel
    program = subprocess.Popen(command)
    if parent != LIVES_ON:
        _in_thread(lambda: (sys.stdin.read(), program.kill()))
    return program.wait()


def _in_thread(work: Callable[[], object]) -> None:
    from threading import Thread

    Thread(target=work, daemon=True).start()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
