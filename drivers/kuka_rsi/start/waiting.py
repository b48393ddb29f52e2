"""Waiting for a controller's program to begin, and reporting what is wrong when it does not."""

import logging
import time

from ...errors import NotReady
from ..telegrams.conversation import Conversation
from ..telegrams.link import Datagram
from ..telegrams.session import Fresh
from .simulator import COUNT

PATIENCE = 1.0
"""How long is waited before a message about it [s]."""
SHOWN = 80
"""Bytes of what cannot be used that are shown: enough to recognise a telegram."""

log = logging.getLogger(__name__)


def first_telegrams(
    conversation: Conversation, count: int, seconds: float, controller: str, here: str, answering: bool
) -> list[Fresh]:
    """The first telegrams of a session, in a row; of a simulator that waits for answers, the first answered.

    Args:
        conversation: Silent yet.
        count: How many.
        seconds: How long to wait for the next.
        controller: Its address, for messages.
        here: Address and port listened on, for messages.
        answering: Whether a simulator may be answered.

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
        elif answering and conversation.session.waits and not conversation.session.counting:
            _answer_from_now_on(conversation)
            found, count = [], COUNT
        elif time.monotonic() - last >= seconds:
            raise NotReady(_what_came(conversation, len(found), seconds, controller, here))
        elif not asked and not found:
            log.warning("waiting for %s at %s: start the RSI program on the controller", controller, here)
            asked = True
    return found


def _answer_from_now_on(conversation: Conversation) -> None:
    """Answer the telegram that a simulator waits with, and all that come."""
    conversation.session.count_answers()
    conversation.silent = False
    conversation.answer_again()


def _what_came(conversation: Conversation, found: int, seconds: float, controller: str, here: str) -> str:
    session, link = conversation.session, conversation.link
    if found and session.waits:
        return (
            f"{controller} sends one telegram again and again, as simulators do that wait for an answer, and "
            "log_only gives none: set it to false"
        )
    if found:
        return (
            f"{controller} sent {found} telegram{'s' * (found > 1)} to {here} and then none for {seconds:g} "
            "s: RSI has ended there. Look at the pendant's messages, then start the program again"
        )
    if session.unread:
        missing = ", ".join(session.reader.missing(session.unread.data)[:6]) or "numbers"
        return (
            f"{controller}:{session.unread.port} sent {_shown(session.unread)} to {here}, which lacks "
            f"{missing}. Has the controller another configuration than this one?"
        )
    if link.strangers:
        return (
            f"{controller} sent nothing to {here} within {seconds:g} s, but {link.stranger}:"
            f"{link.strange.port} sent {_shown(link.strange)}. If that is the controller, set controller to "
            f"{link.stranger}"
        )
    return (
        f"nothing arrived at {here} within {seconds:g} s. Start the RSI program on {controller}. If it runs, "
        "look at IP_NUMBER and PORT of its configuration and at this computer's firewall"
    )


def _shown(datagram: Datagram) -> str:
    """What came, as far as it can be read by a person."""
    text = repr(datagram.data[:SHOWN])[2:-1]
    return f"{len(datagram.data)} bytes ({text}{'...' * (len(datagram.data) > SHOWN)})"
