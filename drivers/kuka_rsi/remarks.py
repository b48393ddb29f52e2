"""Remarks: what is worth reporting of a cycle, in sentences."""

import numpy as np

from .layout import DELAY, PROGRAMMED, Layout
from .start.beginning import Beginning
from .telegrams.conversation import Conversation
from .telegrams.session import Fresh

FOLLOWS = 0.1
"""Motion of the programmed pose from which on it is reported [deg]."""


class Remarks:
    """Remembers what was reported already.

    Args:
        layout: Contents of telegrams.
        beginning: Of the session.
        controller: Its address.
        commanding: Whether the arm is moved by corrections.
    """

    def __init__(self, layout: Layout, beginning: Beginning, controller: str, commanding: bool) -> None:
        self._delay = beginning.delay
        self._start = np.asarray(beginning.start, float).tolist()
        # The pose that the program holds must stand still; without corrections it is what moves.
        self._programmed = layout.columns(PROGRAMMED) if commanding else None
        self._controller = controller
        self._strange = False

    def on(self, conversation: Conversation, fresh: Fresh | None) -> tuple[str, ...]:
        """What happened since the last cycle; nothing but that if no telegram came."""
        events = list(conversation.session.events())
        if fresh is not None:
            events += self._late(fresh) + self._moved(fresh)
        if conversation.refused:
            events.append("the network did not take an answer")
        stranger = conversation.link.stranger
        if stranger and not self._strange:
            self._strange = True
            events.append(f"something from {stranger} was ignored: only {self._controller} is accepted")
        return tuple(events)

    def _late(self, fresh: Fresh) -> list[str]:
        if self._delay is None:
            return []
        before, self._delay = self._delay, int(fresh.telegram.numbers[-1])
        if self._delay <= before:
            return []
        answers = "answer" if self._delay == 1 else "answers"
        return [f"the controller counts {self._delay} late {answers}, {before} before ({DELAY})"]

    def _moved(self, fresh: Fresh) -> list[str]:
        if self._programmed is None:
            return []
        pose = fresh.telegram.numbers[self._programmed]
        moved = max(abs(now - start) for now, start in zip(pose, self._start, strict=True))
        if moved <= FOLLOWS:
            return []
        self._programmed = None
        return [
            f"the programmed pose ({PROGRAMMED}) moved by {moved:.3g} degrees: the program moves the arm "
            "too, or this controller counts corrections into it"
        ]
