"""Conversation: receives telegrams of one KUKA controller and answers them, over a UDP socket."""

import errno
import socket
import struct
import sys
import threading
from collections.abc import Sequence

from ..errors import BadSettings, NotReady
from ..host_clock import HOST, Clock
from .session import Datagram, Fresh, Session
from .telegram import Answer

LONGEST = 65535
MOST = 256
"""Maximum number of datagrams read at once: a full buffer, so that a flood cannot block the loop."""
_STAMPED = 35  # SO_TIMESTAMPNS of Linux, which Python does not name
_TIME = struct.Struct("@ll")
_OLDEST = 10_000_000_000
"""Maximum age of a receive time [ns]; if it is older, the wall clock was set in the meantime."""


class Link:
    """A UDP socket bound to one address of this computer, for one controller.

    Raises:
        BadSettings: If this computer does not have the address, or the address is invalid.
        NotReady: If the port is in use.
    """

    def __init__(self, address: str, port: int, controller: str, clock: Clock = HOST) -> None:
        self.clock = clock
        self._controller = controller
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.strangers = 0  # number of datagrams from other addresses, which were ignored
        self.stranger = ""  # last of these addresses
        self.stranger_datagram = Datagram(b"", 0, 0)  # last of these datagrams
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
        """Wait for a datagram from the controller, and return all that have arrived."""
        deadline = self.clock.monotonic() + seconds
        while True:
            remaining = max(deadline - self.clock.monotonic(), 0.0)
            datagrams = self._waiting() if self.clock.readable(self._waited_for, remaining) else []
            if datagrams or not remaining:
                return datagrams

    def _waiting(self) -> list[Datagram]:
        datagrams = []
        for _ in range(MOST):
            try:
                data, extra, (address, port) = self._read()
            except BlockingIOError:
                break
            except OSError:
                continue  # the network reports that it refused an earlier answer
            if address == self._controller:
                datagrams.append(Datagram(data, port, _arrival(extra, self.clock)))
            else:
                self.strangers += 1
                self.stranger, self.stranger_datagram = address, Datagram(data, port, 0)
        return datagrams

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


def _arrival(extra: list[tuple[int, int, bytes]], clock: Clock) -> int:
    now = clock.host_time()
    for _, kind, content in extra:
        if kind == _STAMPED and len(content) >= _TIME.size:
            seconds, nanoseconds = _TIME.unpack_from(content)
            age = clock.age(seconds * 1_000_000_000 + nanoseconds)
            return now - age if 0 <= age < _OLDEST else now
    return now


class Conversation:
    """Receives telegrams and answers them with the present corrections, one per axis [deg].

    If `counted`, the last number of a telegram counts answers that came too late.
    """

    def __init__(
        self,
        link: Link,
        session: Session,
        answer: Answer,
        corrections: Sequence[float],
        counted: bool = False,
    ) -> None:
        self.link, self.session, self.clock = link, session, link.clock
        self._answer, self._counted = answer, counted
        self._late: float | None = None
        self._answered = b""
        self.repeated = False  # whether the last answer repeated the one before, which had come too late
        self.silent = True  # whether telegrams are not answered
        self.stopping = False  # whether the Stop channel is set
        self.refused = False  # whether the network did not take the last answer
        self.received = self.clock.monotonic()  # time at which the last telegram was read [s]
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
        """Wait for a telegram, answer the newest one, and return it; None if none comes in time.

        Older telegrams that arrived with it are not answered: the controller no longer waits for them.
        """
        deadline = self.clock.monotonic() + seconds
        while True:
            fresh = self.session.take(self.link.wait(max(deadline - self.clock.monotonic(), 0.0)))
            if fresh is not None:
                break
            if self.clock.monotonic() >= deadline:
                return None
        if not self.silent and not self.session.restarted:
            self._reply(fresh)
        self.received = self.clock.monotonic()
        return fresh

    def count_answers(self) -> None:
        """Answer the pending telegram of a simulator, and all later ones; their stamps count answers."""
        self.session.count_answers()
        self.silent = False
        if self.session.last:
            self._reply(self.session.last)

    def _reply(self, fresh: Fresh) -> None:
        # After a correction that was not taken, the next one would be two steps in one cycle.
        self.repeated = bool(self._answered) and self._was_late(fresh) and not self.stopping
        self._answered = self._answered if self.repeated else self._head
        data = self._answer.complete(self._answered, fresh.telegram.stamp)
        self.refused = not self.link.answer(data, fresh.datagram.port)

    def _was_late(self, fresh: Fresh) -> bool:
        """Whether the last answer came too late: the controller's count rose by more than missed cycles."""
        if not self._counted:
            return False
        before, self._late = self._late, fresh.telegram.numbers[-1]
        return before is not None and self._late - before > fresh.cycles - 1

    @property
    def quiet(self) -> float:
        """Time since the last telegram [s]."""
        return self.clock.monotonic() - self.received


def lateness(fresh: Fresh, clock: Clock) -> float:
    """Delay of the answer to a telegram, or of the telegram itself, whichever is larger [s]."""
    return max((clock.host_time() - fresh.datagram.arrival) * 1e-9, fresh.late, 0.0)


class Keeper:
    """A thread that continues a conversation before the exchanges; nothing else may use it until `end`."""

    def __init__(self, conversation: Conversation, cycle: float) -> None:
        self._conversation, self._cycle = conversation, cycle
        self._enough = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="kuka_rsi keeper", daemon=True)
        conversation.clock.start(self._thread)

    def _keep(self) -> None:
        while not self._enough.is_set():
            self._conversation.turn(self._cycle)

    def end(self) -> None:
        self._enough.set()
        self._conversation.clock.join(self._thread)
