"""Session of RSI, from the controller's first telegram to its last: selects the next telegram.

Telegrams may be lost, repeated, late, out of order or unreadable. Only a telegram that is newer than all
before is used; the others are reported. A clock that jumps, or another port, means that the controller has
begun a new session, from the position at that time.
"""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from .telegram import Telegram, TelegramReader

JUMP = 1000
"""Largest step of the clock within a session, forward or back [ms]: longer than controllers wait for answers
(0.4 s), and than a network delays a telegram."""
AGAIN = 2
"""Number of repetitions of a telegram by a sender that waits for its answer; networks may duplicate one."""
AWHILE = 50_000_000
"""Minimum duration of these repetitions [ns]: four of the slowest cycles, in which a controller would have
sent new telegrams."""
_TURN = 1 << 32
"""The clock may count in 32 bits, which is 50 days."""


class Datagram(NamedTuple):
    """A received datagram."""

    data: bytes  # content
    port: int  # port of the sender, which a controller changes for every session
    arrival: int  # time of arrival at the network card's driver, by the host's clock [ns since 1970]


class Fresh(NamedTuple):
    """The newest telegram."""

    telegram: Telegram  # content of the telegram
    datagram: Datagram  # datagram in which it came
    cycles: int  # number of cycles since the previous telegram; 1 if none is missing
    late: float  # time between the arrivals of both telegrams minus the time between their stamps [s]


class Session:
    """Follows the telegrams of one controller with a cycle in [ms]."""

    def __init__(self, reader: TelegramReader, cycle: int) -> None:
        self.reader, self._cycle = reader, cycle
        self.last: Fresh | None = None  # the newest telegram so far
        self._odd: Counter[str] = Counter()
        self._again = self._again_for = 0
        self.elapsed = 0.0  # time between the first telegram and the last [ms]
        self.restarted = ""  # why another session has begun; empty if none has
        self.unread: Datagram | None = None  # last datagram that was not a telegram
        self.counting = False  # whether stamps count answers, as simulators do, and times are this computer's

    @property
    def waits(self) -> bool:
        """Whether the sender repeats the same telegram because it waits for an answer."""
        return self._again >= AGAIN and self._again_for >= AWHILE

    def count_answers(self) -> None:
        """Treat stamps as counts of answers from now on."""
        self._cycle, self.counting = 1, True
        self._odd.clear()

    def take(self, datagrams: Sequence[Datagram]) -> Fresh | None:
        """Select the newest telegram among datagrams; None if none is newer than the last."""
        before = self.last
        for datagram in datagrams:
            telegram = self.reader.read(datagram.data)
            if telegram is None:
                self._odd["could not be read"] += 1
                self.unread = datagram
            elif self.last is None:
                self.last = Fresh(telegram, datagram, 1, 0.0)
            else:
                self._follow(telegram, datagram, self.last)
        if self.last is None or self.last is before:
            return None
        return self.last if before is None else self._since(before, self.last)

    def _since(self, before: Fresh, last: Fresh) -> Fresh:
        gone = _advance(before.telegram, last.telegram)
        if abs(gone) > JUMP or gone <= 0:  # another session, with another clock
            gone = self._cycle
        waited = (last.datagram.arrival - before.datagram.arrival) * 1e-9
        time = waited if self.counting else gone * 1e-3
        self.elapsed += 1e3 * time
        self.last = last._replace(cycles=max(round(gone / self._cycle), 1), late=waited - time)
        return self.last

    def _follow(self, telegram: Telegram, datagram: Datagram, last: Fresh) -> None:
        gone = _advance(last.telegram, telegram)
        if datagram.port != last.datagram.port:
            self._restart("it sends from another port", telegram, datagram)
        elif abs(gone) > JUMP:
            self._restart(f"its clock jumped by {gone} ms", telegram, datagram)
        elif gone == 0:
            self._odd["came twice"] += 1
            self._again += 1
            self._again_for = datagram.arrival - last.datagram.arrival
        elif gone < 0:
            self._odd["came too late"] += 1
        else:
            self.last = Fresh(telegram, datagram, 1, 0.0)
            self._again = 0

    def _restart(self, why: str, telegram: Telegram, datagram: Datagram) -> None:
        self.last = Fresh(telegram, datagram, 1, 0.0)
        self.restarted = self.restarted or (
            f"the controller has begun a new RSI session: {why}. Corrections now count from another pose; "
            "cancel the program on the controller and record again"
        )

    def events(self) -> tuple[str, ...]:
        """Irregularities since the last call, a sentence each."""
        events = tuple(f"{count} telegram{'s' * (count > 1)} {fate}" for fate, count in self._odd.items())
        self._odd.clear()
        return events


def _advance(before: Telegram, after: Telegram) -> int:
    """Time between the stamps of two telegrams [ms]."""
    return (after.time - before.time + _TURN // 2) % _TURN - _TURN // 2
