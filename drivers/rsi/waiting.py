"""Waiting for a controller's program to begin, and saying what is wrong when it does not."""

import logging
import time

from ..errors import NotReady
from .conversation import Conversation
from .session import Fresh

PATIENCE = 1.0
"""How long is waited before a person is told what for [s]."""

log = logging.getLogger(__name__)


def first_telegrams(
    conversation: Conversation, count: int, seconds: float, controller: str, here: str
) -> list[Fresh]:
    """The first telegrams of a session, in a row.

    Args:
        conversation: Silent yet.
        count: How many.
        seconds: How long to wait for the next.
        controller: Its address, for messages.
        here: Address and port listened on, for messages.

    Raises:
        NotReady: None came in time, with what came instead.
    """
    found: list[Fresh] = []
    last = time.monotonic()
    asked = False
    while len(found) < count:
        fresh = conversation.turn(min(PATIENCE, seconds))
        if fresh:
            found.append(fresh)
            last = time.monotonic()
        elif time.monotonic() - last >= seconds:
            raise NotReady(
                f"{controller} sent nothing to {here} that could be read within {seconds:g} s. "
                f"{_advice(conversation)}"
            )
        elif not asked:
            log.warning("waiting for %s at %s: start the RSI program on the controller", controller, here)
            asked = True
    return found


def _advice(conversation: Conversation) -> str:
    unread = conversation.session.unread
    if unread:
        missing = ", ".join(conversation.session.reader.missing(unread)[:6]) or "numbers"
        return f"What it sent lacks {missing}: has the controller another configuration than this one?"
    if conversation.link.strangers:
        return f"Something came from {conversation.link.stranger}; if that is the controller, set it so"
    return (
        "Start the RSI program on the controller. If it runs, look at IP_NUMBER and PORT of its "
        "configuration and at this computer's firewall"
    )
