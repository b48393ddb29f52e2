"""Claim: one exidyn process per bus and computer, because two that command a bus disturb each other.

A CAN socket lets any number of programs send. The claim is a socket name in Linux's abstract namespace: it
vanishes with the process, however that ends, and belongs to the same network namespace as the bus.
"""

import os
import socket
import struct
import sys

from ..errors import NotReady

CREDENTIALS = struct.Struct("3i")
"""`ucred` of Linux: process, user and group at the other end of a socket."""
LONGEST = 100
"""Maximum length of a name [bytes]; an abstract address has at most 107."""


class Claim:
    """The exclusive right of a process to use a named bus until `release`. Only Linux supports it.

    Raises:
        NotReady: If another process uses the bus.
    """

    def __init__(self, bus: str) -> None:
        self._socket: socket.socket | None = None
        if sys.platform != "linux":
            return
        address = b"\0" + f"exidyn {bus}".encode()[:LONGEST]
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            claim.bind(address)
            claim.listen()
        except OSError as error:
            claim.close()
            holder = _holder(address)
            if holder == os.getpid():
                return
            process = f" (process {holder})" if holder else ""
            raise NotReady(
                f"{bus} is in use by another exidyn{process}: two programs on one bus disturb each other. "
                "End the other program, then try again"
            ) from error
        self._socket = claim

    def release(self) -> None:
        """Let other processes use the bus; may be called again."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _holder(address: bytes) -> int:
    """Id of the process that has claimed an address; 0 if it cannot be determined."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
        link.settimeout(0.1)
        try:
            link.connect(address)
            peer = link.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, CREDENTIALS.size)
        except OSError:
            return 0
    return int(CREDENTIALS.unpack(peer)[0])
