"""How far a command that takes its time has got, and how long it will still take."""

import math
import shutil
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from threading import Event, Thread
from typing import Self, TypeVar

import numpy as np
from tqdm import tqdm

from exidyn.identification.progress import StageText
from exidyn.identification.text_table import paragraph
from exidyn.quoting import visible

from ..screen import beneath

T = TypeVar("T")
Progress = Callable[[str], None]
"""Called with a sentence at each stage."""

PATIENCE = 2.0
"""Time until a bar appears [s]: what is over before needs none."""
REDRAW = 0.5
"""Between two looks at the clock [s]."""
KNOWN = 0.02
"""Share of the work from which on the time it took foretells that of the rest."""
NEARLY = 0.95
"""Share of a stage at which the bar waits while the stage takes longer than was foreseen."""
FORM = "{percentage:3.0f} % |{bar:30}| {elapsed}{postfix}"
ITEMS = "{percentage:3.0f} % |{bar:30}| {elapsed}, about {remaining} left"


def with_bar(items: Sequence[T] | np.ndarray) -> Iterable[T]:
    """The items one by one, with a bar and the time left in a terminal, without in pipes and files."""
    return tqdm(items, file=beneath(sys.stderr), leave=False, delay=PATIENCE, disable=None, bar_format=ITEMS)


class Stopwatch:
    """Prints sentences on standard error with the seconds since it was made; a context manager.

    Where standard error is a terminal and the stages or the time are known, a bar below them has the time
    left; in pipes and files there are the sentences alone.

    Args:
        shares: Stage -> its usual share of the work; they add up to one. A sentence without a stage, or of
            another one, belongs to the stage before.
        seconds: What the work is given, in place of stages [s]; what comes after it has no time left.
    """

    def __init__(self, shares: Mapping[str, float] | None = None, seconds: float = 0.0) -> None:
        self._start = time.perf_counter()
        self._shares, self._seconds = dict(shares or {}), seconds
        self._stage, self._entered = "", self._start
        self._before = 0.0
        self._bar: tqdm | None = None
        self._over = Event()
        self._thread: Thread | None = None

    def __enter__(self) -> Self:
        if (self._shares or self._seconds) and sys.stderr.isatty():
            self._thread = Thread(target=self._redraw, daemon=True)
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Take the bar away, before results are printed."""
        self._over.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def __call__(self, sentence: str) -> None:
        """Print a sentence, and enter the stage that it begins."""
        since = f"{time.perf_counter() - self._start:6.1f} s  "
        line = "\n".join(paragraph(sentence, " " * len(since), since))
        if self._bar is not None:
            tqdm.write(visible(line), beneath(sys.stderr))
        else:
            print(line, file=sys.stderr, flush=True)
        if isinstance(sentence, StageText) and sentence.stage in self._shares:
            self.enter(sentence.stage)

    def enter(self, stage: str) -> None:
        """Enter a stage without a sentence."""
        if stage != self._stage:
            names = list(self._shares)
            self._before = sum(self._shares[name] for name in names[: names.index(stage)])
            self._stage, self._entered = stage, time.perf_counter()

    def left(self, now: float) -> tuple[float, float]:
        """Share of the work that is done [-] and the time left [s] at a time; NaN where it is unknown yet."""
        if self._seconds:
            gone = now - self._start
            left = self._seconds - gone
            return min(gone / self._seconds, NEARLY), left if left > 0.0 else float("nan")
        if self._before < KNOWN:
            return 0.0, float("nan")
        whole = (self._entered - self._start) / self._before
        own = self._shares[self._stage]
        inside = min((now - self._entered) / (own * whole), NEARLY) if own else 0.0
        done = self._before + own * inside
        return done, max(1.0 - done, 0.0) * whole

    def _redraw(self) -> None:
        if self._over.wait(PATIENCE):
            return
        width, height = shutil.get_terminal_size()  # of one that states none, what is usual
        look = {"leave": False, "bar_format": FORM, "ncols": width - 1, "nrows": height}
        with tqdm(total=1.0, file=beneath(sys.stderr), **look) as self._bar:
            while not self._over.wait(REDRAW):
                done, left = self.left(time.perf_counter())
                words = f"about {tqdm.format_interval(left)} left" if math.isfinite(left) else ""
                self._bar.set_postfix_str(words, refresh=False)
                self._bar.n = done
                self._bar.refresh()
        self._bar = None
