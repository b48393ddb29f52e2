"""Link to the process that talks to the controller: starts it and exchanges messages with it."""

import importlib.util
import os
import select
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress

import msgspec
import numpy as np

from ..errors import LinkLost, MissingPackage, NotReady
from .fci_messages import ASK, FATAL, FAULT, READY, SEEN, error_names, explained, read_record
from .settings import FrankaSettings
from .target_stream import CYCLE

READ = 1 << 12
"""Maximum length of a message [bytes]."""
PACKAGE = "pylibfranka"
LEAVING = 5.0
"""Maximum time for the process to stop the arm and end [s]."""


class FciLink:
    """A running process that talks to the controller.

    Raises MissingPackage without the maker's library, LinkLost without a connection, NotReady if the
    controller refuses.
    """

    def __init__(self, settings: FrankaSettings) -> None:
        if importlib.util.find_spec(PACKAGE) is None:
            raise MissingPackage("franka", PACKAGE, "franka")
        self._where, self._patience = settings.address, settings.wait
        self._records: deque[np.void] = deque()
        self.version = ""  # version of the library
        self.fault = ""  # why commands are no longer taken; empty while they are
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.setblocking(False)
        encoded = msgspec.json.encode(settings).decode()
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", f"{__package__}.fci_process", str(theirs.fileno()), encoded],
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            )
        finally:
            theirs.close()
        try:
            self._wait_until(lambda: bool(self.version), "no connection to the controller")
        except BaseException:
            self.close()
            raise

    def _wait_until(self, condition: Callable[[], bool], missing: str) -> None:
        end = time.monotonic() + self._patience
        while not condition():
            if time.monotonic() > end:
                raise LinkLost(f"driver franka: {self._where}: {missing} in {self._patience:g} s")
            self._receive(end - time.monotonic())

    def state(self) -> np.void:
        """Request the controller's present state. Raises LinkLost if none comes."""
        self._records.clear()
        self.send(ASK)
        self._wait_until(lambda: bool(self._records), "no state of the controller")
        return self._records.pop()

    def send(self, message: bytes) -> bool:
        """Send a message; returns whether it was sent."""
        try:
            self._socket.send(message)
        except OSError:
            return False
        return True

    def next(self, patience: float) -> np.void | None:
        """Take the oldest state; None if none comes within `patience` [s]. Raises LinkLost."""
        self._receive(0.0)
        if not self._records:
            self._receive(patience)
        return self._records.popleft() if self._records else None

    def forget(self, keep: int = 0) -> None:
        """Discard queued states except the newest `keep`."""
        self._receive(0.0)
        while len(self._records) > keep:
            self._records.popleft()

    def _receive(self, patience: float) -> None:
        try:
            select.select([self._socket], [], [], max(patience, 0.0))
            while True:
                with suppress(ConnectionResetError):  # messages sent before the reset can still be read
                    self._take(self._socket.recv(READ))
        except BlockingIOError:
            return
        except OSError as error:
            raise LinkLost(f"driver franka: {self._where}: {error.strerror or error}") from error

    def _take(self, message: bytes) -> None:
        kind, body = message[:1], message[1:]
        if kind == SEEN:
            self._records.append(read_record(body))
        elif kind == READY:
            self.version = body.decode()
        elif kind == FAULT:
            self.fault = self.fault or _describe_stop(body.decode("utf-8", "replace"))
        elif kind == FATAL:
            raise self._refusal(body.decode("utf-8", "replace").removeprefix("libfranka: "))
        else:
            raise LinkLost(
                f"driver franka: the process that talks to {self._where} has ended. The controller stops the "
                f"arm {20 * CYCLE:g} s after its last command"
            )

    def _refusal(self, text: str) -> LinkLost | NotReady:
        if "ncompatible" in text:
            return NotReady(
                f"driver franka: {text.split('.')[0]}. pylibfranka drives an FR3 with system 5.9 or newer; "
                "a Panda (system 4) is not supported"
            )
        if "realtime" in text.lower():
            return NotReady(f"driver franka: {text} Try `real_time = false`, or a real-time kernel")
        return LinkLost(
            f"driver franka: {self._where}: {text} Try ping, and unlock the joints and activate FCI in Desk"
        )

    def close(self) -> None:
        self._socket.close()
        try:
            self._process.wait(LEAVING)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _describe_stop(text: str) -> str:
    """Why the arm was stopped, from the names of errors in a text of libfranka."""
    names = error_names(text)
    if names:
        return f"the controller has stopped the arm: {explained(names)}"
    return text.removeprefix("libfranka: ").strip()
