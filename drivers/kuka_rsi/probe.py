"""Probe: determines the effect of corrections by motions too small to do harm.

RSI_ON(#ABSOLUTE) treats a correction as the distance from the start, RSI_ON(#RELATIVE) adds it in every
cycle, so that an arm with a constant correction runs away. The RSI context may also link the corrections of
an axis to another axis. Telegrams show neither, so small patterns come before any motion:

1. All axes are corrected by some 1e-4 degrees for a while, by zero, by the opposite for the same time, and by
   zero. Only a controller that adds corrections responds visibly: the arm moves by 0.01 degrees and back to
   its start, so that nothing has to be undone.
2. Only if 1 moved nothing, each axis is corrected by these 0.01 degrees in patterns of its own (`linkage`). A
   controller with absolute corrections must follow them, axis by axis. No correction is larger than the sum
   of 1, and the last is zero, so that each axis ends at its start.
"""

import math
from collections.abc import Generator, Sequence

import numpy as np

from .linkage import MOVED, Linkage, pattern_table
from .session import Fresh
from .settings import ACTUAL
from .start import COARSE
from .telegram import decimals

BOUND = 0.05
"""Largest motion of an axis in a probe [deg], which is 2 mm at the end of an arm of 2 m. It holds even if the
controller adds corrections and this computer dies meanwhile: it bounds the sum so far plus the corrections
added until the Timeout. An axis further away ends the probe. Only if the controller adds corrections and
RSI_MOVECORR is first called after the first pattern may it be half a degree away by then."""
SIZES = (0.01, 0.03)
"""Motion of the arm in each attempt [deg]: encoders resolve 1e-4, drives hold 1e-3; the friction of a cold
gear may prevent the first."""
SHORTEST = 100
"""Lower bound of the Timeout for computing steps [cycles]: 0.1 degrees per second, without a jerk."""
SPEED = 0.1
"""Velocity of corrections in the second patterns [deg/s], without a jerk for any Timeout."""
STEPS, SIGMAS = 3, 4
"""Smallest usable motion, in steps of the sent positions and in standard deviations of an arm at rest;
`MOVED` of it is four standard deviations of a median of `SEEN` cycles."""
BEGINNING = 0.5
"""Maximum time for RSI_MOVECORR and the brakes after RSI_ON [s]."""
LAG = 0.1
"""Time within which an arm has followed [s]; drives and filters of RSI take some 10 ms."""
SEEN = 10
"""Number of cycles whose median is a position."""
_Course = Generator[np.ndarray, np.ndarray, np.ndarray]
"""Yields corrections (n,), receives the positions (n,) in the telegram that they answered [deg]."""


class _Refused(Exception):
    """The arm must not be commanded."""


class Probe:
    """Corrections to send until their effect is known, to a controller with a cycle [s].

    `actual` are the columns of the measured positions. The controller may continue without answers for
    `timeout` cycles, and allows corrections from `lower` to `upper`, each (n,) [deg]; an axis without room
    for the probe is not probed.
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
        self._direction = np.where(upper >= SIZES[-1], 1.0, np.where(lower <= -SIZES[-1], -1.0, 0.0))
        self._table = pattern_table(len(axes))
        self._rest = np.empty(0)
        self._decimals = 0
        self._messages: list[str] = []
        self.done = not self._direction.any()  # whether the effect is known, or commands are forbidden
        self.fault = ""  # why commands are forbidden; empty while they are allowed
        self.passed = False  # whether corrections have the required effect
        self._course = self._probe()
        self.correction = next(self._course)  # correction for the next answer, shape (n,) [deg]

    def see(self, fresh: Fresh) -> None:
        """Process the telegram that was answered with the correction, and choose the next correction."""
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
            half = np.outer(self._half(size), self._direction)
            cycles = 2 * len(half) + (len(self._table) + 1) * (self._rise(size) + self._watching)
            self._messages.append(
                f"probing the effect of corrections by motions of {size:g} degrees, for "
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

    def _follow(self, start: np.ndarray, size: float) -> Generator[np.ndarray, np.ndarray, Linkage]:
        """Correct each axis by a size [deg] in its patterns, from a position at rest (n,) [deg]."""
        corrections = size * self._direction * self._table
        places = []
        before = np.zeros(len(self._axes))
        for after in (*corrections, 0.0 * before):
            rise = np.linspace(before, after, self._rise(size) + 1)[1:]
            hold = np.tile(after, (self._watching, 1))
            places.append(_last((yield from self._played(np.concatenate((rise, hold))))))
            before = after
        self._rest = places.pop()
        passed = np.arange(1, len(places) + 1)[:, None] / (len(places) + 1)
        motions = np.array(places) - start - passed * (self._rest - start)  # minus a steady drift
        return Linkage(self._axes, corrections, motions, size)

    def _played(self, corrections: np.ndarray) -> _Course:
        """Send corrections (t, n) [deg], and return the positions measured meanwhile (t, n) [deg]."""
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
        """Number of cycles with a constant correction until the position of the arm is known."""
        return self._cycles(LAG) + SEEN

    def _half(self, size: float) -> np.ndarray:
        """First half of the first pattern (t,) [deg]; its sum is the correction of the second patterns."""
        count = math.ceil(size * self._timeout / (BOUND - size))
        return np.concatenate((np.full(count, size / count), np.zeros(self._watching)))

    def _rise(self, size: float) -> int:
        """Number of cycles in which a correction changes by a size [deg] in the second patterns."""
        return self._cycles(size / SPEED)

    def _sizes(self, noise: np.ndarray) -> tuple[float, ...]:
        """Sizes of motions [deg] that can be distinguished from noise (n,) [deg]."""
        step = 10.0**-self._decimals if self._decimals > COARSE else 0.0
        sizes = tuple(size for size in SIZES if size >= max(STEPS * step, SIGMAS * noise.max()))
        if not sizes:
            raise _Refused(
                f"{self._axes[int(noise.argmax())]} does not stand still: its position has a standard "
                f"deviation of {noise.max():.2g} degrees, limit {SIZES[-1] / SIGMAS:g}, too much to probe "
                "the effect of corrections. Let the program wait until the arm stands still before RSI_ON"
            )
        return sizes

    def _require_unmoved(self, up: np.ndarray, back: np.ndarray, size: float, step: float) -> None:
        """Refuse if the first pattern moved an axis, or if a motion could not be seen."""
        if self._decimals <= COARSE:
            raise _Refused(
                f"positions come in steps of {10.0**-self._decimals:g} degrees, too coarse to probe the "
                "effect of corrections, and to identify from: set Precision of the ETHERNET object to 4 in "
                "the RSI context"
            )
        added = self._direction * (up - back)
        if added.max() > MOVED * size:
            raise _Refused(
                f"corrections add up: {self._axes[int(added.argmax())]} moved by {added.max():.2g} degrees "
                f"while its correction was {step:.2g}. Call RSI_ON(#ABSOLUTE) in the controller's program, "
                "which now has #RELATIVE. The arm is back at its start, within "
                f"{np.abs(back - self._rest).max():.2g} degrees"
            )
        moved = np.maximum(np.abs(up - self._rest), np.abs(back - self._rest))
        if moved.max() > MOVED * size:
            raise _Refused(
                f"{self._axes[int(moved.argmax())]} moved by {moved.max():.2g} degrees while its correction "
                f"was {step:.2g} at most. Let the program wait until the arm stands still before RSI_ON, and "
                "move only by RSI_MOVECORR"
            )

    def _too_far(self, actual: np.ndarray) -> str:
        away = np.abs(actual - self._rest)
        return (
            f"{self._axes[int(away.argmax())]} moved by {away.max():.2g} degrees, limit {BOUND:g}, while "
            f"corrections were {SIZES[-1]:g} at most: they add up (RSI_ON(#ABSOLUTE) is required), or "
            "something else moves the arm"
        )


def _last(positions: np.ndarray) -> np.ndarray:
    """Position at the end of a course of positions (t, n), shape (n,)."""
    return np.median(positions[-SEEN:], axis=0)
