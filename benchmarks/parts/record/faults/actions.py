"""What is done to a peer in a cycle of the motion."""

import os
import signal
from collections.abc import Callable
from threading import Timer

from ..controllers import Peer
from .fault import Action


def at(cycle: int, action: Callable[[Peer], object]) -> Callable[[Peer], list[Action]]:
    """Do something to the peer in a cycle of the motion."""
    return lambda peer: [(cycle, lambda: action(peer))]


def line(text: str) -> Callable[[Peer], object]:
    """Send the peer what goes wrong."""
    return lambda peer: os.write(peer.process.stdin.fileno(), f"{text}\n".encode())


def halted(seconds: float) -> Callable[[Peer], object]:
    """The peer's process stands still for a while."""

    def act(peer: Peer) -> None:
        peer.process.send_signal(signal.SIGSTOP)
        Timer(seconds, peer.process.send_signal, (signal.SIGCONT,)).start()

    return act
