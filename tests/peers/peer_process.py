"""What a peer is from outside: a process that prints when it is ready and what happens to it."""

import atexit
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from exidyn.drivers.driver import Driver
from exidyn.drivers.host_clock import HOST

if __package__:
    from .virtual_clock import of_this_test
else:
    from virtual_clock import of_this_test

HERE = Path(__file__).parent
ENDING = 60.0
"""How long a peer may take to end by itself [s]; only one that hangs is waited for so long."""


class NoBus(Exception):
    """The peer could not open its bus on this machine; the message is its reason."""


@cache
def nursery():
    """The socket of the process that starts peers."""
    link, end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with end:
        process = subprocess.Popen(
            [sys.executable, str(HERE / "nursery.py"), str(end.fileno())],
            pass_fds=[end.fileno()],
            stdin=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
    atexit.register(process.wait)  # it ends with the link, which is closed first
    atexit.register(link.close)
    return link


class Process:
    """A process of the nursery, with as much of `subprocess.Popen` as tests need."""

    def __init__(self, script, arguments, environment, output):
        self.returncode = None
        taken, told = os.pipe()
        self._status, ended = os.pipe()
        self.stdin = os.fdopen(told, "w")
        message = json.dumps([script, arguments, environment]).encode()
        socket.send_fds(nursery(), [message], [taken, output, ended])
        self.pid = int(nursery().recv(100))
        os.close(taken)
        os.close(ended)

    def poll(self):
        return self.wait(0.0)

    def wait(self, seconds=ENDING):
        """Its exit status, negative for a signal; None if it does not end."""
        if self.returncode is None and select.select([self._status], [], [], seconds)[0]:
            status = os.read(self._status, 1)
            os.close(self._status)
            self.returncode = status[0] if status else -signal.SIGKILL
        return self.returncode

    def kill(self):
        if self.poll() is None:
            os.kill(self.pid, signal.SIGKILL)


class Peer:
    """A running peer; a context manager that ends it.

    While it runs, it and all drivers share a virtual clock, unless its controller keeps one of its own.

    Attributes:
        address: What it printed after "ready".
    """

    shared = True

    def __init__(self, script, *arguments, shared=None):
        shared = Peer.shared if shared is None else shared
        self.clock, self._slot = (of_this_test(), of_this_test().allot()) if shared else (HOST, None)
        self._output, self._printed = tempfile.TemporaryFile(), []
        environment = self.clock.environment(self._slot) if shared else {}
        self.process = Process(script, [*map(str, arguments)], environment, self._output.fileno())
        self._before, Driver.clock = Driver.clock, self.clock
        while not (ready := self._line("ready ")) and self.process.wait(0.002) is None:
            pass
        self.address = ready.removeprefix("ready ").strip()
        if not ready:
            self.close()
            output = "".join(self.lines).strip()
            raise NoBus(output) if self.process.returncode == 77 else RuntimeError(f"{script}: {output}")

    @property
    def lines(self):
        """What it has printed, in order."""
        if self._output.closed:
            return self._printed
        size = os.fstat(self._output.fileno()).st_size
        return os.pread(self._output.fileno(), size, 0).decode().splitlines(keepends=True)

    def _line(self, text):
        return next((line for line in self.lines if text in line and line.endswith("\n")), "")

    def wait_for(self, text, seconds=60.0):
        """The first line with a text in it, once it is there."""
        self.wait_until(lambda: self.printed(text) or self.process.poll() is not None, seconds)
        if line := self._line(text):
            return line
        raise LookupError(f"the peer did not print '{text}'; it printed: {''.join(self.lines)}")

    def wait_until(self, condition, seconds=60.0):
        """Wait until a condition holds, by the clock of the peer; returns whether it does."""
        if self._slot is not None:
            return self.clock.until(condition, seconds)
        end = HOST.monotonic() + seconds
        while not condition() and HOST.monotonic() < end:
            HOST.sleep(0.01)
        return condition()

    def tell(self, line):
        """Write a line to its standard input."""
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def printed(self, text):
        return bool(self._line(text))

    def close(self):
        if self.process.stdin.closed:
            return
        self.process.stdin.close()
        if self._slot is None or self.clock.until(self._has_left, 3.0):
            self.process.wait(3.0 if self._slot is None else ENDING)
        self.process.kill()
        self.process.wait()
        Driver.clock = self._before
        if self._slot is not None:
            self.clock.free(self._slot)
        self._printed = self.lines
        self._output.close()

    def _has_left(self):
        return not self.clock.takes_part(self._slot) or self.process.poll() is not None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
