"""Start of a session: waits for the first telegrams, and checks whether the arm may be commanded.

Simulators of a controller have no clock and no timeout: they wait for an answer, and count answers.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import NotReady
from .conversation import Conversation
from .session import Datagram, Fresh
from .settings import ACTUAL, DELAY, PROGRAMMED, Layout
from .telegram import decimals

PATIENCE = 1.0
"""Time to wait for a telegram before a message tells the user [s]."""
SHOWN = 80
"""Number of bytes shown of an unusable datagram: enough to recognize a telegram."""

log = logging.getLogger(__name__)


def first_telegrams(
    conversation: Conversation, count: int, seconds: float, controller: str, here: str, answering: bool
) -> list[Fresh]:
    """Wait for `count` telegrams without answers; if `answering`, answer a simulator that waits for it.

    The next telegram must come within `seconds` [s]; `controller` and `here` are addresses for messages.

    Raises:
        NotReady: If too few telegrams came in time; the message says what came instead.
    """
    telegrams: list[Fresh] = []
    last = conversation.clock.monotonic()
    announced = False
    while len(telegrams) < count:
        fresh = conversation.turn(min(PATIENCE, seconds))
        if fresh:
            telegrams.append(fresh)
            last = conversation.clock.monotonic()
        elif answering and conversation.session.waits and not conversation.session.counting:
            conversation.count_answers()
            telegrams, count = [], COUNT
        elif conversation.clock.monotonic() - last >= seconds:
            raise NotReady(_describe_received(conversation, len(telegrams), seconds, controller, here))
        elif not announced and not telegrams:
            log.warning("waiting for %s at %s: start the RSI program on the controller", controller, here)
            announced = True
    return telegrams


def _describe_received(
    conversation: Conversation, count: int, seconds: float, controller: str, here: str
) -> str:
    session, link = conversation.session, conversation.link
    if count and session.waits:
        return (
            f"{controller} repeats one telegram, as simulators do that wait for an answer, but log_only "
            "sends no answers: set it to false"
        )
    if count:
        return (
            f"{controller} sent {count} telegram{'s' * (count > 1)} to {here} and then none for {seconds:g} "
            "s: RSI has ended there. Look at the pendant's messages, then start the program again"
        )
    if session.unread:
        missing = ", ".join(session.reader.missing(session.unread.data)[:6]) or "numbers"
        return (
            f"{controller}:{session.unread.port} sent {_shown(session.unread)} to {here}, which lacks "
            f"{missing}. Does the controller use another configuration?"
        )
    if link.strangers:
        return (
            f"{controller} sent nothing to {here} within {seconds:g} s, but {link.stranger}:"
            f"{link.stranger_datagram.port} sent {_shown(link.stranger_datagram)}. If that is the "
            f"controller, set controller to {link.stranger}"
        )
    return (
        f"nothing arrived at {here} within {seconds:g} s. Start the RSI program on {controller}. If it runs, "
        "look at IP_NUMBER and PORT of its configuration and at this computer's firewall"
    )


def _shown(datagram: Datagram) -> str:
    text = repr(datagram.data[:SHOWN])[2:-1]
    return f"{len(datagram.data)} bytes ({text}{'...' * (len(datagram.data) > SHOWN)})"


COUNT = 50
"""Number of telegrams from which the cycle is determined as a median."""
SHORTEST, LONGEST = 0.0005, 0.1
"""Shortest and longest cycle of a simulator [s]: shorter cycles cannot be answered in time, longer ones are
too slow for a motion."""


def cycle_of(telegrams: Sequence[Fresh]) -> float:
    """Time between answered telegrams [s]. Raises NotReady if it is too short or too long for a motion."""
    arrivals = np.array([fresh.datagram.arrival for fresh in telegrams])
    cycle = float(np.median(np.diff(arrivals))) * 1e-9
    if not SHORTEST <= cycle <= LONGEST:
        raise NotReady(
            f"a simulator that waits for answers sends every {1e3 * cycle:.3g} ms; valid are "
            f"{1e3 * SHORTEST:g} to {1e3 * LONGEST:g} ms"
        )
    return round(cycle, 4)


def warning(cycle: float) -> str:
    """Warning about a run with a simulator."""
    return (
        "this is a simulator that waits for each answer and counts answers instead of milliseconds, not a "
        f"controller: times are this computer's, the cycle of {1e3 * cycle:g} ms is measured, and there are "
        "no dynamics to identify"
    )


COARSE = 1
"""Number of decimals that KUKA sends by default, which is too small: steps of 0.1 degrees."""
RESTING = 0.1
"""Largest motion of an arm at rest in a few cycles [deg]."""
APART = 0.5
"""Largest distance of an arm at rest from its programmed pose [deg]; drives hold 1 % of that."""


@dataclass(frozen=True)
class Beginning:
    """State at the beginning of a session."""

    start: np.ndarray  # pose from which corrections count, shape (n,) [deg]
    reference: str  # element from which the pose was read
    decimals: int  # number of decimals of positions
    # Number of late answers counted by the controller until then; None if it does not count.
    delay: int | None
    simulated: bool = False  # whether it is a simulator, whose numbers have as many decimals as they need

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
    """Check the first telegrams, at least two, of a controller with a cycle [s], None for a simulator.

    Raises NotReady if the cycle differs, or if the arm moves or is not at its programmed pose.
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
            "program wait until it stands still before RSI_ON, and move only by RSI_MOVECORR"
        )
    apart = np.abs(actual[0] - start)
    if apart.max() > APART:
        axis = layout.axes[int(apart.argmax())]
        raise NotReady(
            f"{axis} is {apart.max():.3g} degrees from its programmed pose, limit {APART:g}: corrections "
            "from an earlier run are still in force. Cancel the program on the controller and start it again"
        )
