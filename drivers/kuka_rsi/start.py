"""The first telegrams of a session: waited for, and whether the arm may be commanded from there.

Simulators of a controller have no clock and no timeout: they wait for an answer, and count answers.
"""

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import NotReady
from .conversation import Conversation
from .layout import ACTUAL, DELAY, PROGRAMMED, Layout
from .session import Datagram, Fresh
from .telegram import decimals

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
            conversation.count_answers()
            found, count = [], COUNT
        elif time.monotonic() - last >= seconds:
            raise NotReady(_what_came(conversation, len(found), seconds, controller, here))
        elif not asked and not found:
            log.warning("waiting for %s at %s: start the RSI program on the controller", controller, here)
            asked = True
    return found


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
    text = repr(datagram.data[:SHOWN])[2:-1]
    return f"{len(datagram.data)} bytes ({text}{'...' * (len(datagram.data) > SHOWN)})"


COUNT = 50
"""Telegrams that the cycle is the median of."""
SHORTEST, LONGEST = 0.0005, 0.1
"""Cycles that are taken for a simulator's [s]: faster ones cannot be answered in time, slower ones are no
motion."""


def cycle_of(telegrams: Sequence[Fresh]) -> float:
    """Time between answered telegrams [s]. Raises NotReady if nothing can be moved like that."""
    arrivals = np.array([fresh.datagram.arrival for fresh in telegrams])
    cycle = float(np.median(np.diff(arrivals))) * 1e-9
    if not SHORTEST <= cycle <= LONGEST:
        raise NotReady(
            f"a simulator that waits for answers sends every {1e3 * cycle:.3g} ms; valid are "
            f"{1e3 * SHORTEST:g} to {1e3 * LONGEST:g} ms"
        )
    return round(cycle, 4)


def warning(cycle: float) -> str:
    """What a person should know of a run against one."""
    return (
        "this is a simulator that waits for each answer and counts answers instead of milliseconds, not a "
        f"controller: times are this computer's, the cycle of {1e3 * cycle:g} ms is measured, and there are "
        "no dynamics to identify"
    )


COARSE = 1
"""Decimals that KUKA sends by default: steps of 0.1 degrees."""
RESTING = 0.1
"""Motion in a few cycles of an arm at rest, at most [deg]."""
APART = 0.5
"""Largest distance of an arm at rest from its programmed pose [deg]; drives hold a hundredth of that."""


@dataclass(frozen=True)
class Beginning:
    """Where a session begins.

    Attributes:
        start: Pose from which corrections count, shape (n,) [deg].
        reference: Element that it was read from.
        decimals: Decimals of positions.
        delay: Late answers that the controller counted until then; None if it does not count.
        simulated: Whether it is a simulator, which sends as many decimals as a number happens to need.
    """

    start: np.ndarray
    reference: str
    decimals: int
    delay: int | None
    simulated: bool = False

    def warnings(self) -> list[str]:
        if self.decimals > COARSE or self.simulated:
            return []
        return [
            f"positions come in steps of {10.0**-self.decimals:g} degrees, too coarse to identify from: set "
            "Precision of the ETHERNET object to 4 in the RSI context"
        ]


def check_start(
    telegrams: Sequence[Fresh], layout: Layout, cycle: float | None, commanding: bool
) -> Beginning:
    """Look at least two telegrams over, of a controller with a cycle [s]; None for a simulator without one.

    Raises NotReady for another cycle, or for an arm that is not where it may be commanded from.
    """
    if cycle is not None:
        _check_clock(telegrams, cycle)
    numbers = np.array([fresh.telegram.numbers for fresh in telegrams])
    actual = numbers[:, layout.columns(ACTUAL)]
    columns = layout.columns(PROGRAMMED)
    start = actual[0] if columns is None else numbers[0, columns]
    if commanding:
        _check_rest(actual, start, layout)
    return Beginning(
        start=start,
        reference=ACTUAL if columns is None else PROGRAMMED,
        decimals=max(decimals(fresh.datagram.data, ACTUAL) for fresh in telegrams),
        delay=int(numbers[-1, layout.names.index(f"{DELAY}.D")]) if layout.delay else None,
        simulated=cycle is None,
    )


def _check_clock(telegrams: Sequence[Fresh], cycle: float) -> None:
    stamps = [fresh.telegram.time for fresh in telegrams]
    step = min(after - before for before, after in zip(stamps, stamps[1:], strict=False))
    if step != round(cycle * 1e3):
        raise NotReady(
            f"the controller sends every {step} ms, not every {1e3 * cycle:g} ms. Set cycle to "
            f"{step * 1e-3:g}, or call RSI_ON with #IPO_FAST for 4 ms, #IPO for 12 ms"
        )


def _check_rest(actual: np.ndarray, start: np.ndarray, layout: Layout) -> None:
    moved = np.abs(actual[-1] - actual[0])
    if moved.max() > RESTING:
        axis = layout.axes[int(moved.argmax())]
        raise NotReady(
            f"the arm moves: {axis} by {moved.max():.3g} degrees in {len(actual) - 1} cycles. Let the "
            "program wait until it stands still before RSI_ON, and move by nothing but RSI_MOVECORR"
        )
    apart = np.abs(actual[0] - start)
    if apart.max() > APART:
        axis = layout.axes[int(apart.argmax())]
        raise NotReady(
            f"{axis} is {apart.max():.3g} degrees from where its program put it, limit {APART:g}: "
            "corrections from an earlier run are still in force. Cancel the program on the controller and "
            "start it again"
        )
