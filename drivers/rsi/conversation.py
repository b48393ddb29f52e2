"""Conversation: each telegram of the controller and the answer to it."""

import threading
import time
from collections.abc import Sequence

from ..host_clock import host_time
from .link import Link
from .session import Fresh, Session
from .telegram import Answer


class Conversation:
    """Hears the controller and answers with the last corrections that were given.

    Args:
        link: To the controller.
        session: Which telegram is the next.
        answer: Writes answers.
        corrections: At first, one an axis [deg].

    Attributes:
        silent: Whether nothing is answered, as at first.
        stopping: Whether the Stop channel is set.
        refused: Whether the network did not take the last answer.
        heard: When the last telegram was read [s].
    """

    def __init__(self, link: Link, session: Session, answer: Answer, corrections: Sequence[float]) -> None:
        self.link, self.session = link, session
        self._answer = answer
        self.silent = True
        self.stopping = False
        self.refused = False
        self.heard = time.monotonic()
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
            whole = self._answer.whole(self._head, fresh.telegram.stamp)
            self.refused = not self.link.answer(whole, fresh.datagram.port)
        self.heard = time.monotonic()
        return fresh

    @property
    def quiet(self) -> float:
        """Time since the last telegram [s]."""
        return time.monotonic() - self.heard


def lateness(fresh: Fresh) -> float:
    """How late a telegram was answered, or how late it came, whichever is more [s]."""
    return max((host_time() - fresh.datagram.arrival) * 1e-9, fresh.late, 0.0)


class Keeper:
    """A thread that keeps a conversation up while nobody exchanges.

    Args:
        conversation: Not to be touched by anybody else until `end`.
        cycle: Of the controller [s].
    """

    def __init__(self, conversation: Conversation, cycle: float) -> None:
        self._conversation, self._cycle = conversation, cycle
        self._enough = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="kuka_rsi keeper", daemon=True)
        self._thread.start()

    def _keep(self) -> None:
        while not self._enough.is_set():
            self._conversation.turn(self._cycle)

    def end(self) -> None:
        """Leave the conversation to whoever calls."""
        self._enough.set()
        self._thread.join()
