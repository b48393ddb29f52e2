"""Conversation: each telegram of a KUKA controller and the answer to it, over a socket for it alone."""

import errno
import select
import socket
import struct
import sys
import threading
import time
from collections.abc import Sequence

from ..errors import BadSettings, NotReady
from ..host_clock import host_time
from .session import Datagram, Fresh, Session
from .telegram import Answer

LONGEST = 65535
MOST = 256
"""Datagrams taken at once: a full buffer of telegrams, so that a flood cannot keep the loop here."""
_STAMPED = 35  # SO_TIMESTAMPNS of Linux, which Python does not name
_TIME = struct.Struct("@ll")
_OLDEST = 10_000_000_000
"""A receive time longer ago than this is not accepted: the wall clock was set since [ns]."""


class Link:
    """A UDP socket bound to one address of this computer, for one controller.

    Attributes:
        strangers: Datagrams from other addresses, which were ignored.
        stranger: The last of those addresses.
        strange: What came from there last.

    Raises:
        BadSettings: An address that this computer does not have, or that is none.
        NotReady: A port that is in use.
    """

    def __init__(self, address: str, port: int, controller: str) -> None:
        self._controller = controller
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.strangers = 0
        self.stranger = ""
        self.strange = Datagram(b"", 0, 0)
        try:
            self._bind(address, port)
        except BaseException:
            self._socket.close()
            raise
        self._socket.setblocking(False)
        self._waited_for = [self._socket.fileno()]
        if sys.platform == "linux":  # elsewhere the times of arrival are those of reading
            self._socket.setsockopt(socket.SOL_SOCKET, _STAMPED, 1)

    def _bind(self, address: str, port: int) -> None:
        try:
            self._socket.bind((address, port))
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise NotReady(
                    f"{address}:{port} is taken by another program. Is a second driver running?"
                ) from error
            raise BadSettings(
                f"cannot listen on {address}:{port}: {error.strerror or error}. IP_NUMBER must be the "
                "address of this computer in the controller's network; set bind if the two differ on purpose"
            ) from error

    def wait(self, seconds: float) -> list[Datagram]:
        """All that has come from the controller; waits for the first of it, but not longer."""
        deadline = time.monotonic() + seconds
        while True:
            left = max(deadline - time.monotonic(), 0.0)
            ready, _, _ = select.select(self._waited_for, [], [], left)
            found = self._waiting() if ready else []
            if found or not left:
                return found

    def _waiting(self) -> list[Datagram]:
        found = []
        for _ in range(MOST):
            try:
                data, extra, (address, port) = self._read()
            except BlockingIOError:
                break
            except OSError:
                continue  # an earlier answer was refused by the network, which is no telegram
            if address == self._controller:
                found.append(Datagram(data, port, _arrival(extra)))
            else:
                self.strangers += 1
                self.stranger, self.strange = address, Datagram(data, port, 0)
        return found

    def _read(self) -> tuple[bytes, list[tuple[int, int, bytes]], tuple[str, int]]:
        if sys.platform == "linux":
            data, extra, _, sender = self._socket.recvmsg(LONGEST, 64)
            return data, extra, sender
        data, sender = self._socket.recvfrom(LONGEST)
        return data, [], sender

    def answer(self, data: bytes, port: int) -> bool:
        try:
            self._socket.sendto(data, (self._controller, port))
        except OSError:
            return False
        return True

    def close(self) -> None:
        self._socket.close()


def _arrival(extra: list[tuple[int, int, bytes]]) -> int:
    now = host_time()
    for _, kind, content in extra:
        if kind == _STAMPED and len(content) >= _TIME.size:
            seconds, rest = _TIME.unpack_from(content)
            age = time.time_ns() - seconds * 1_000_000_000 - rest
            return now - age if 0 <= age < _OLDEST else now
    return now


class Conversation:
    """Receives from the controller and answers with the last corrections that were given, one an axis [deg].

    Where answers that came too late are `counted`, their number is the last of a telegram.

    Attributes:
        silent: Whether nothing is answered, as at first.
        stopping: Whether the Stop channel is set.
        refused: Whether the network did not take the last answer.
        repeated: Whether the last answer was the one before again, since that had come too late.
        received: When the last telegram was read [s].
    """

    def __init__(
        self,
        link: Link,
        session: Session,
        answer: Answer,
        corrections: Sequence[float],
        counted: bool = False,
    ) -> None:
        self.link, self.session = link, session
        self._answer, self._counted = answer, counted
        self._late: float | None = None
        self._answered = b""
        self.repeated = False
        self.silent = True
        self.stopping = False
        self.refused = False
        self.received = time.monotonic()
        self.correct(corrections)

    def correct(self, corrections: Sequence[float]) -> None:
        """Answer with these corrections from now on [deg]."""
        self._corrections = corrections
        self._head = self._answer.head(corrections, self.stopping)

    def stop(self) -> None:
        """Set the Stop channel from now on."""
        self.stopping = True
        self.correct(self._corrections)

    def turn(self, seconds: float) -> Fresh | None:
        """The newest telegram, answered; None if none came in that time.

        Older ones that came with it are not answered: the controller has given them up.
        """
        deadline = time.monotonic() + seconds
        while True:
            fresh = self.session.take(self.link.wait(max(deadline - time.monotonic(), 0.0)))
            if fresh is not None:
                break
            if time.monotonic() >= deadline:
                return None
        if not self.silent and not self.session.restarted:
            self._reply(fresh)
        self.received = time.monotonic()
        return fresh

    def count_answers(self) -> None:
        """Answer the telegram that a simulator waits with, and all that come; stamps count answers then."""
        self.session.count_answers()
        self.silent = False
        if self.session.last:
            self._reply(self.session.last)

    def _reply(self, fresh: Fresh) -> None:
        # A correction that was not taken, and then the next one, would be two steps in one cycle.
        self.repeated = bool(self._answered) and self._was_late(fresh) and not self.stopping
        self._answered = self._answered if self.repeated else self._head
        whole = self._answer.complete(self._answered, fresh.telegram.stamp)
        self.refused = not self.link.answer(whole, fresh.datagram.port)

    def _was_late(self, fresh: Fresh) -> bool:
        """Whether the controller did not take the last answer: it counts more than were not given."""
        if not self._counted:
            return False
        before, self._late = self._late, fresh.telegram.numbers[-1]
        return before is not None and self._late - before > fresh.cycles - 1

    @property
    def quiet(self) -> float:
        """Time since the last telegram [s]."""
        return time.monotonic() - self.received


def lateness(fresh: Fresh) -> float:
    """How late a telegram was answered, or how late it came, whichever is more [s]."""
    return max((host_time() - fresh.datagram.arrival) * 1e-9, fresh.late, 0.0)


class Keeper:
    """A thread that keeps a conversation up between exchanges; no one else uses it until `end`."""

    def __init__(self, conversation: Conversation, cycle: float) -> None:
        self._conversation, self._cycle = conversation, cycle
        self._enough = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="kuka_rsi keeper", daemon=True)
        self._thread.start()

    def _keep(self) -> None:
        while not self._enough.is_set():
            self._conversation.turn(self._cycle)

    def end(self) -> None:
        self._enough.set()
        self._thread.join()
