"""What a peer is from outside: a process that prints when it is ready and what happens to it."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

HERE = Path(__file__).parent
STARTING = 900.0
"""How long a peer may take to import and compile what it needs [s]: 15 s of processor time, of which it got
a tenth on two cores with ten others busy. Only a peer that hangs is waited for so long."""


class NoBus(Exception):
    """The peer could not open its bus on this machine; the message is its reason."""


class Peer:
    """A running peer; a context manager that ends it.

    Args:
        script: Its file beside this one.
        arguments: Of its command line.

    Attributes:
        address: What it printed after "ready".
        lines: What it has printed since, in order.
    """

    def __init__(self, script, *arguments):
        command = [sys.executable, str(HERE / script), *map(str, arguments)]
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=subprocess.STDOUT, text=True, env=environment
        )
        self.lines, self._news = [], threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        try:
            self.address = self.wait_for("ready ", STARTING).removeprefix("ready ").strip()
        except LookupError as error:
            self.close()
            if self.process.returncode == 77:
                raise NoBus("".join(self.lines).strip()) from error
            output = "".join(self.lines).strip() or f"nothing in {STARTING:g} s"
            raise RuntimeError(f"{script} did not start: {output}") from error

    def _read(self):
        for line in self.process.stdout:
            with self._news:
                self.lines.append(line)
                self._news.notify_all()
        with self._news:
            self._news.notify_all()

    def wait_for(self, text, seconds=60.0):
        """The first line with a text in it, once it is there."""
        end = time.monotonic() + seconds
        with self._news:
            while True:
                for line in self.lines:
                    if text in line:
                        return line
                if time.monotonic() > end or not (self._reader.is_alive() or self.process.poll() is None):
                    raise LookupError(f"the peer did not print '{text}'; it printed: {''.join(self.lines)}")
                self._news.wait(0.05)

    def tell(self, line):
        """Write a line to its standard input."""
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def printed(self, text):
        with self._news:
            return any(text in line for line in self.lines)

    def close(self):
        if self.process.poll() is None:
            self.process.stdin.close()
            try:
                self.process.wait(3.0)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self._reader.join()
        for stream in (self.process.stdin, self.process.stdout):
            stream.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
