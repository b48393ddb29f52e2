"""Probe: what the controller makes of corrections, seen from motions too small to do harm.

RSI_ON(#ABSOLUTE) takes a correction for the distance from the start, RSI_ON(#RELATIVE) adds it in every
cycle, so that an arm whose correction is held runs away; no telegram shows which. So two small patterns come
before any motion. Only a controller that adds makes anything of the first: some ten thousandths of a degree
for a while, none, the opposite for as long, none. Added up it is a trapezoid that ends where it began, so
that nothing need be undone. The second is that sum, and is sent only if the first moved nothing: a
controller that takes distances must follow it.
"""

import math
from collections.abc import Generator, Sequence

import numpy as np

from .layout import ACTUAL
from .session import Fresh
from .telegram import decimals

BOUND = 0.05
"""No axis moves further in a probe [deg], which is 2 mm at the end of an arm of 2 m, even if the controller
adds corrections and this computer dies while it does: what it adds until its Timeout, and the sum before, are
no more together. An axis that is seen further away ends the probe: only where RSI_MOVECORR is first called in
the middle of the second pattern, on a controller that adds, may it be further by then, half a degree."""
SIZES = (0.01, 0.03)
"""By how much the arm should move, in as many attempts [deg]: encoders see ten thousandths, drives hold
thousandths; a cold gear's friction may hide the first."""
SHORTEST = 100
"""Timeout for which steps are made where it is shorter [cycles]: 0.1 degrees a second, without a jerk."""
STEPS, SIGMAS = 3, 4
"""What is to be seen is so many steps of the numbers sent, and so many standard deviations of an arm at rest:
of a median of `SEEN` cycles, `MOVED` of it is then four."""
MOVED = 0.4
"""Share of a size from which on it is a motion: an arm that begins to follow while the first pattern rises
still moves by all of it when that falls."""
APART = 0.6
"""Share by which a motion may differ from its correction: a drive that must overcome friction first swings
over by up to half."""
BEGINNING = 0.5
"""How long RSI_MOVECORR and the brakes may take after RSI_ON [s]."""
LAG = 0.1
"""Time within which an arm has followed [s]; drives and RSI's own filters take some hundredths."""
SEEN = 10
"""Cycles that a position is the median of."""
COARSE = 1
"""Decimals with which nothing of this is seen: steps of 0.1 degrees."""

_Course = Generator[np.ndarray, np.ndarray, np.ndarray]
"""Gives corrections (n,), takes the positions (n,) in the telegram that they answered [deg]."""


class _Refused(Exception):
    """The arm must not be commanded."""


class Probe:
    """Corrections to answer with until it is known what they do.

    Args:
        axes: Names.
        actual: Columns of the measured positions in a telegram.
        cycle: Cycle of the controller [s].
        timeout: Cycles for which the controller may go on without answers.
        lower: Most negative corrections that it takes, shape (n,) [deg].
        upper: Most positive; an axis that has no room for the probe is not probed.

    Attributes:
        correction: What to answer the next telegram with, shape (n,) [deg].
        done: Whether it is known what corrections do, or that nothing may be commanded.
        fault: Why nothing may be; empty while it may.
        passed: Whether corrections do what they should.
    """

    def __init__(
        self,
        axes: Sequence[str],
        actual: slice,
        cycle: float,
        timeout: int,
        lower: np.ndarray,
        upper: np.ndarray,
    ) -> None:
        self._axes, self._actual = axes, actual
        self._cycle, self._timeout = cycle, max(timeout, SHORTEST)
        self._way = np.where(upper >= SIZES[-1], 1.0, np.where(lower <= -SIZES[-1], -1.0, 0.0))
        self._rest = np.empty(0)
        self._decimals = 0
        self._messages: list[str] = []
        self.done, self.fault, self.passed = not self._way.any(), "", False
        self._course = self._probe()
        self.correction = next(self._course)

    def see(self, fresh: Fresh) -> None:
        """Take in the telegram that was answered with the correction, and choose the next."""
        self._decimals = max(self._decimals, decimals(fresh.datagram.data, ACTUAL))
        try:
            self.correction = self._course.send(np.array(fresh.telegram.numbers[self._actual]))
        except StopIteration:
            self.done = self.passed = True
        except _Refused as refused:
            self.fault = str(refused)
            self.give_up()

    def give_up(self) -> None:
        self.correction = np.zeros(len(self._axes))
        self.done = True

    def events(self) -> tuple[str, ...]:
        messages, self._messages = tuple(self._messages), []
        return messages

    def _probe(self) -> Generator[np.ndarray, np.ndarray, None]:
        yield from self._played(np.zeros(self._cycles(BEGINNING)))
        still = yield from self._played(np.zeros(self._watching))
        self._rest = _last(still)
        size, rise = 0.0, self._rest
        for size in self._sizes(still.std(axis=0)):
            half = self._half(size)
            seconds = 4 * len(half) * self._cycle
            self._messages.append(
                f"seeing what corrections do, by motions of {size:g} degrees, for {seconds:.1f} s"
            )
            up = _last((yield from self._played(half)))
            back = _last((yield from self._played(-half)))
            self._require_unmoved(up, back, size, half[0])
            top = _last((yield from self._played(np.cumsum(half))))
            self._rest = _last((yield from self._played(size - np.cumsum(half))))
            rise = self._way * (top - 0.5 * (back + self._rest))
            wrong = rise[self._wrong(rise, size)]
            if wrong.size == 0:
                probed = rise[self._way != 0.0]
                self._messages.append(
                    "corrections are distances from the start (RSI_ON(#ABSOLUTE)): axes moved by "
                    f"{probed.min():.4f} to {probed.max():.4f} degrees when corrected by {size:g}"
                )
                return
            if np.abs(wrong).max() > MOVED * size:  # it moved, and not as it was corrected
                break
        raise _Refused(self._not_followed(rise, size))

    def _played(self, shape: np.ndarray) -> _Course:
        """Correct by a shape (t,) [deg]; the positions meanwhile (t, n) [deg]."""
        seen = []
        for correction in shape:
            seen.append((yield self._way * correction))
            if self._rest.size and np.abs(seen[-1] - self._rest).max() > BOUND:
                raise _Refused(self._too_far(seen[-1]))
        return np.array(seen)

    def _cycles(self, seconds: float) -> int:
        return math.ceil(seconds / self._cycle)

    @property
    def _watching(self) -> int:
        """Cycles for which nothing changes until the arm's position is known."""
        return self._cycles(LAG) + SEEN

    def _half(self, size: float) -> np.ndarray:
        """First half of the first pattern (t,) [deg]; its sum is that of the second."""
        count = math.ceil(size * self._timeout / (BOUND - size))
        return np.concatenate((np.full(count, size / count), np.zeros(self._watching)))

    def _sizes(self, noise: np.ndarray) -> tuple[float, ...]:
        """Those that can be seen behind a noise (n,) [deg]."""
        step = 10.0**-self._decimals if self._decimals > COARSE else 0.0
        sizes = tuple(size for size in SIZES if size >= max(STEPS * step, SIGMAS * noise.max()))
        if not sizes:
            raise _Refused(
                f"{self._axes[int(noise.argmax())]} does not stand still: its position has a standard "
                f"deviation of {noise.max():.2g} degrees, limit {SIZES[-1] / SIGMAS:g}, too much to see what "
                "corrections do before the motion. Let the program wait until the arm stands still before "
                "RSI_ON"
            )
        return sizes

    def _require_unmoved(self, up: np.ndarray, back: np.ndarray, size: float, step: float) -> None:
        """Raise where the first pattern moved anything, or it could not be seen."""
        if self._decimals <= COARSE:
            raise _Refused(
                f"positions come in steps of {10.0**-self._decimals:g} degrees, too coarse to see what "
                "corrections do, and to identify from: set Precision of the ETHERNET object to 4 in the RSI "
                "context"
            )
        added = self._way * (up - back)
        if added.max() > MOVED * size:
            raise _Refused(
                f"corrections add up: {self._axes[int(added.argmax())]} moved by {added.max():.2g} degrees "
                f"while its correction was {step:.2g}. Call RSI_ON(#ABSOLUTE) in the controller's program, "
                "which now has #RELATIVE. The arm is back where it was, within "
                f"{np.abs(back - self._rest).max():.2g} degrees"
            )
        moved = np.maximum(np.abs(up - self._rest), np.abs(back - self._rest))
        if moved.max() > MOVED * size:
            raise _Refused(
                f"{self._axes[int(moved.argmax())]} moved by {moved.max():.2g} degrees while its correction "
                f"was {step:.2g} at most. Let the program wait until the arm stands still before RSI_ON, and "
                "move by nothing but RSI_MOVECORR"
            )

    def _wrong(self, rise: np.ndarray, size: float) -> np.ndarray:
        """Places of axes that do not follow their corrections."""
        return np.flatnonzero((self._way != 0.0) & ~(np.abs(rise / size - 1.0) <= APART))

    def _not_followed(self, rise: np.ndarray, size: float) -> str:
        wrong = self._wrong(rise, size)
        names = ", ".join(f"{self._axes[place]} ({rise[place]:.2g})" for place in wrong)
        return (
            f"corrections of {size:g} degrees did not move the arm by as much: {names}. Are the drives on "
            "and RSI_MOVECORR called? Are the ETHERNET object's outputs linked to AXISCORR, axis by axis? A "
            "STOP object may keep corrections from having an effect"
        )

    def _too_far(self, actual: np.ndarray) -> str:
        away = np.abs(actual - self._rest)
        return (
            f"{self._axes[int(away.argmax())]} moved by {away.max():.2g} degrees, limit {BOUND:g}, while "
            f"corrections were {SIZES[-1]:g} at most: they add up (RSI_ON(#ABSOLUTE) is required), or "
            "something else moves the arm"
        )


def _last(positions: np.ndarray) -> np.ndarray:
    """Where the arm stood at the end of a piece (t, n), shape (n,)."""
    return np.median(positions[-SEEN:], axis=0)
