"""Answers: assigns frames on a CAN bus to questions, for joints that answer each question with one frame.

No frame carries a number or a time. A frame that arrives after its cycle, from an adapter's queue or a slow
motor, would be read in the next cycle and look right. So questions and answers are counted: after a missing
answer, the next frame may be that answer, and does not count as a measurement of its own cycle. Two different
answers in every cycle mean that two nodes have the same number; it is not known which of them is the joint.
"""

from collections.abc import Callable, Sequence

from ..host_clock import HOST, Clock

TWICE = 3
"""Consecutive cycles with two different answers that prove two nodes: a slow answer explains two at most."""
DOUBTED = 1.0
"""Time for which a joint with two nodes stays stale after its last double answer [s]."""


class Answers:
    """Counts the questions to joints and their answers, and reports events, a sentence each.

    If a joint `may_skip` a cycle, an answer that arrives in a cycle without it is late; if none arrives, it
    was lost.
    """

    def __init__(
        self, names: Sequence[str], report: Callable[[str], None], may_skip: bool, clock: Clock = HOST
    ) -> None:
        self._clock = clock
        self._names, self._report, self._may_skip = names, report, may_skip
        self.begin()

    def begin(self) -> None:
        """Forget all questions."""
        count = len(self._names)
        self.fresh = [False] * count  # whether each joint has answered the question of this cycle
        self.waiting = 0  # number of joints whose answer is still missing
        self._owed, self._came = [0] * count, [0] * count
        self._skipped, self._late = [False] * count, [False] * count
        self._extra, self._second, self._twice = [0] * count, [False] * count, [0] * count
        self._last, self._doubted_until = [b""] * count, [0.0] * count
        self._open = False

    def ask(self) -> list[bool]:
        """Begin a cycle; returns which joints are to be asked in it."""
        to_ask = [self._can_ask(joint) for joint in range(len(self._names))]
        self._owed = [owed + ask for owed, ask in zip(self._owed, to_ask, strict=True)]
        self._twice = [(twice + 1) * second for twice, second in zip(self._twice, self._second, strict=True)]
        self._second = [False] * len(to_ask)
        self.fresh, self._came = [False] * len(to_ask), [0] * len(to_ask)
        self.waiting, self._open = sum(to_ask), True
        return to_ask

    def end(self) -> None:
        """End the cycle; an answer that arrives before the next question is late."""
        self._open = False

    def add_question(self) -> None:
        """Count one more question to all joints, sent out of turn."""
        self._extra = [extra + 1 for extra in self._extra]

    def take(self, joint: int, data: bytes) -> None:
        """Take a frame with an answer of a joint."""
        if self._extra[joint]:
            self._extra[joint] -= 1
            return
        if not self._owed[joint]:
            if self._came[joint]:  # else the frame was unsolicited, such as before the first question
                self._answered_twice(joint, data)
            return
        self._came[joint] += 1
        self._owed[joint] -= 1
        self._last[joint] = data
        if self._owed[joint] or self._skipped[joint] or not self._open:
            self._report_late(joint)
            return
        self._late[joint] = False
        self.waiting -= 1
        self.fresh[joint] = self._clock.monotonic() >= self._doubted_until[joint]

    def _can_ask(self, joint: int) -> bool:
        """Decide whether a missing answer was lost; returns whether the joint can be asked."""
        if not self._owed[joint]:
            self._skipped[joint] = False
        elif self._may_skip:
            self._skipped[joint] = not self._skipped[joint]
            self._owed[joint] *= self._skipped[joint]
        elif self._came[joint] == 1:  # one answer to one question: the missing answer was lost
            self._owed[joint] = 0
        return not self._skipped[joint]

    def _report_late(self, joint: int) -> None:
        if not self._late[joint]:
            self._report(
                f"{self._names[joint]}: an answer came after its cycle, or one before it was lost; not used"
            )
        self._late[joint] = True

    def _answered_twice(self, joint: int, data: bytes) -> None:
        """Discard an answer that a second one contradicts, and distinguish slow answers from two nodes."""
        if data == self._last[joint]:  # CAN itself may deliver a frame twice
            return
        self.fresh[joint], self._second[joint] = False, True
        if self._twice[joint] + 1 < TWICE:
            return
        now = self._clock.monotonic()
        if now >= self._doubted_until[joint]:
            self._report(
                f"{self._names[joint]}: two different answers to one question. Do two nodes have the same "
                "number? Neither is used"
            )
        self._doubted_until[joint] = now + DOUBTED
