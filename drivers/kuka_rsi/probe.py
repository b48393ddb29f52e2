"""Probe: what the controller makes of corrections, seen from motions too small to do harm.

RSI_ON(#ABSOLUTE) takes a correction for the distance from the start, RSI_ON(#RELATIVE) adds it in every
cycle, so that an arm whose correction is held runs away. Corrections of an axis may also reach another axis,
where the RSI context links them so. No telegram shows either, so small patterns come before any motion:

1. All axes are corrected by some ten thousandths of a degree for a while, by zero, by the opposite for as
   long, and by zero. Only a controller that adds makes anything of it: the arm moves by a hundredth of a
   degree and back to where it began, so that nothing need be undone.
2. Only if 1 moved nothing, each axis is corrected by that hundredth of a degree in patterns of its own
   (`linkage`). A controller that takes distances must follow them, axis by axis. No correction is larger
   than the sum of 1, and the last is zero, so that each axis ends where it began.
"""

import math
from collections.abc import Generator, Sequence

import numpy as np

from .layout import ACTUAL
from .linkage import MOVED, Linkage, pattern_table
from .session import Fresh
from .telegram import decimals

BOUND = 0.05
"""No axis moves further in a probe [deg], which is 2 mm at the end of an arm of 2 m, even if the controller
adds corrections and this computer dies while it does: what it adds until its Timeout, and the sum before, are
no more together. An axis that is seen further away ends the probe: only where RSI_MOVECORR is first called
after the first pattern, on a controller that adds, may it be further by then, half a degree."""
SIZES = (0.01, 0.03)
"""By how much the arm should move, in as many attempts [deg]: encoders see ten thousandths, drives hold
thousandths; a cold gear's friction may hide the first."""
SHORTEST = 100
"""Timeout for which steps are made where it is shorter [cycles]: 0.1 degrees a second, without a jerk."""
SPEED = 0.1
"""Velocity of corrections in the second patterns [deg/s], without a jerk whatever the Timeout."""
STEPS, SIGMAS = 3, 4
"""What is to be seen is so many steps of the numbers sent, and so many standard deviations of an arm at rest:
of a median of `SEEN` cycles, `MOVED` of it is then four."""
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
        self._table = pattern_table(len(axes))
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
        axes = len(self._axes)
        yield from self._played(np.zeros((self._cycles(BEGINNING), axes)))
        still = yield from self._played(np.zeros((self._watching, axes)))
        self._rest = _last(still)
        sizes = self._sizes(still.std(axis=0))
        for size in sizes:
            half = np.outer(self._half(size), self._way)
            cycles = 2 * len(half) + (len(self._table) + 1) * (self._rise(size) + self._watching)
            self._messages.append(
                f"seeing what corrections do, by motions of {size:g} degrees, for "
                f"{cycles * self._cycle:.1f} s"
            )
            up = _last((yield from self._played(half)))
            back = _last((yield from self._played(-half)))
            self._require_unmoved(up, back, size, np.abs(half).max())
            linkage = yield from self._follow(back, size)
            if linkage.agrees:
                least, most = linkage.followed.min(), linkage.followed.max()
                self._messages.append(
                    "corrections are distances from the start (RSI_ON(#ABSOLUTE)), and each reaches its "
                    f"axis: axes moved by {least:.4f} to {most:.4f} degrees when corrected by {size:g}"
                )
                return
            if not linkage.stuck or size == sizes[-1]:
                raise _Refused(linkage.refusal())

    def _follow(self, rest: np.ndarray, size: float) -> Generator[np.ndarray, np.ndarray, Linkage]:
        """Correct each axis by a size [deg] in its patterns; the arm was at rest before (n,) [deg]."""
        corrections = size * self._way * self._table
        places = []
        before = np.zeros(len(self._axes))
        for after in (*corrections, 0.0 * before):
            rise = np.linspace(before, after, self._rise(size) + 1)[1:]
            hold = np.tile(after, (self._watching, 1))
            places.append(_last((yield from self._played(np.concatenate((rise, hold))))))
            before = after
        self._rest = places.pop()
        passed = np.arange(1, len(places) + 1)[:, None] / (len(places) + 1)
        motions = np.array(places) - rest - passed * (self._rest - rest)  # less a steady drift
        return Linkage(self._axes, corrections, motions, size)

    def _played(self, corrections: np.ndarray) -> _Course:
        """Correct by corrections (t, n) [deg]; the positions meanwhile (t, n) [deg]."""
        seen = []
        for correction in corrections:
            seen.append((yield correction))
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
        """First half of the first pattern (t,) [deg]; its sum is the size of the second."""
        count = math.ceil(size * self._timeout / (BOUND - size))
        return np.concatenate((np.full(count, size / count), np.zeros(self._watching)))

    def _rise(self, size: float) -> int:
        """Cycles in which a correction changes by a size [deg] in the second patterns."""
        return self._cycles(size / SPEED)

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
