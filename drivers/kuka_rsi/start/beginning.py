"""Beginning: the first telegrams of a session, and whether the arm may be commanded from there."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import NotReady
from ..layout import ACTUAL, DELAY, PROGRAMMED, Layout
from ..telegrams.session import Fresh
from ..telegrams.telegram import decimals

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
        decimals: Of positions.
        delay: Late answers that the controller counted until then; None if it does not count.
        simulated: Whether it is a simulator, which sends as many decimals as a number happens to need.
    """

    start: np.ndarray
    reference: str
    decimals: int
    delay: int | None
    simulated: bool = False

    def warnings(self) -> list[str]:
        """Warnings."""
        if self.decimals > COARSE or self.simulated:
            return []
        return [
            f"positions come in steps of {10.0**-self.decimals:g} degrees, too coarse to identify from: set "
            "Precision of the ETHERNET object to 4 in the RSI context"
        ]


def look_at(telegrams: Sequence[Fresh], layout: Layout, cycle: float | None, commanding: bool) -> Beginning:
    """Look the first telegrams over.

    Args:
        telegrams: At least two.
        layout: Their contents.
        cycle: That the controller should have [s]; None for a simulator, which has none of its own.
        commanding: Whether the arm is to be moved.

    Raises:
        NotReady: Another cycle, or an arm that is not where it may be commanded from.
    """
    if cycle is not None:
        _look_at_clock(telegrams, cycle)
    numbers = np.array([fresh.telegram.numbers for fresh in telegrams])
    actual = numbers[:, layout.columns(ACTUAL)]
    columns = layout.columns(PROGRAMMED)
    start = actual[0] if columns is None else numbers[0, columns]
    if commanding:
        _look_at_rest(actual, start, layout)
    return Beginning(
        start=start,
        reference=ACTUAL if columns is None else PROGRAMMED,
        decimals=max(decimals(fresh.datagram.data, ACTUAL) for fresh in telegrams),
        delay=int(numbers[-1, layout.names.index(f"{DELAY}.D")]) if layout.delay else None,
        simulated=cycle is None,
    )


def _look_at_clock(telegrams: Sequence[Fresh], cycle: float) -> None:
    stamps = [fresh.telegram.time for fresh in telegrams]
    step = min(after - before for before, after in zip(stamps, stamps[1:], strict=False))
    if step != round(cycle * 1e3):
        raise NotReady(
            f"the controller sends every {step} ms, not every {1e3 * cycle:g} ms. Set cycle to "
            f"{step * 1e-3:g}, or call RSI_ON with #IPO_FAST for 4 ms, #IPO for 12 ms"
        )


def _look_at_rest(actual: np.ndarray, start: np.ndarray, layout: Layout) -> None:
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
