"""Claim: a bus is for one exidyn process of a computer, since two that command it disturb each other.

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
"""Bytes of a name; an abstract address has at most 107."""


class Claim:
    """The right of a process to use a bus, by its name, until `release`. Only Linux has such claims.

    Raises:
        NotReady: Another process has it.
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
                "Let the other end, then try again"
            ) from error
        self._socket = claim

    def release(self) -> None:
        """Let others use the bus; may be called again."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _holder(address: bytes) -> int:
    """Number of the process that has claimed an address; 0 where that cannot be found out."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
        link.settimeout(0.1)
        try:
            link.connect(address)
            peer = link.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, CREDENTIALS.size)
        except OSError:
            return 0
    return int(CREDENTIALS.unpack(peer)[0])
