"""Conversation: each telegram of the controller and the answer to it."""

import threading
import time
from collections.abc import Sequence

from ...host_clock import host_time
from .link import Link
from .session import Fresh, Session
from .telegram import Answer


class Conversation:
    """Receives from the controller and answers with the last corrections that were given.

    Args:
        link: To the controller.
        session: Which telegram is the next.
        answer: Writes answers.
        corrections: At first, one an axis [deg].
        counted: Whether the last number of a telegram is how many answers came too late.

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

    def answer_again(self) -> None:
        """Answer the last telegram, which was not answered or whose answer was lost."""
        if self.session.last:
            self._reply(self.session.last)

    def _reply(self, fresh: Fresh) -> None:
        # A correction that was not taken, and then the next one, would be two steps in one cycle.
        self.repeated = bool(self._answered) and self._was_late(fresh) and not self.stopping
        self._answered = self._answered if self.repeated else self._head
        whole = self._answer.whole(self._answered, fresh.telegram.stamp)
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
    """A thread that keeps a conversation up between exchanges.

    Args:
        conversation: Not to be used elsewhere until `end`.
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
        """Leave the conversation to the caller."""
        self._enough.set()
        self._thread.join()
