"""How long the answers of a cycle usually take, so that a thread sleeps once for all of them.

A thread that waits for each of six answers is put to sleep and woken six times a cycle. Each time costs 10 to
30 us on a usual computer, more than reading and understanding the answer.
"""

import time

LONGER, SHORTER = 20e-6, 2e-6
"""By how much the next sleep is longer where an answer had to be waited for after it, and shorter where none
had to [s]: in balance, one cycle in eleven waits again."""
SHORTEST = 50e-6
"""Below this a sleep is left out: it would take longer than it was asked for [s]."""


class AnswerTime:
    """The usual time between a question and the last of its answers."""

    def __init__(self) -> None:
        self._usual = 0.0

    def sleep(self) -> None:
        """Right after the question: sleep until its answers have usually come."""
        if self._usual >= SHORTEST:
            time.sleep(self._usual)

    def adjust(self, waited: bool) -> None:
        """All answers have come; whether they had to be waited for after the sleep."""
        self._usual = max(self._usual + (LONGER if waited else -SHORTER), 0.0)
