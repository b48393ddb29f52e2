"""Progress and remaining time of a command that takes long."""

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
"""Function that takes a sentence at each stage."""

PATIENCE = 2.0
"""Time until a bar appears [s]: shorter work needs none."""
REDRAW = 0.5
"""Update period of the bar [s]."""
KNOWN = 0.02
"""Share of the work after which its remaining time is estimated."""
NEARLY = 0.95
"""Share of a stage at which the bar waits while the stage takes longer than expected; the remaining time is
then unknown."""
FORM = "{percentage:3.0f} % |{bar:30}| {elapsed}{postfix}"
ITEMS = "{percentage:3.0f} % |{bar:30}| {elapsed}, about {remaining} left"


def with_bar(items: Sequence[T] | np.ndarray) -> Iterable[T]:
    """Iterate over the items, in a terminal with a bar and the remaining time."""
    return tqdm(items, file=beneath(sys.stderr), leave=False, delay=PATIENCE, disable=None, bar_format=ITEMS)


class Stopwatch:
    """Print sentences on standard error with the seconds since the start; a context manager.

    If standard error is a terminal and the stages or the time are known, a bar below the sentences shows the
    remaining time. Pipes and files get the sentences only.

    Args:
        shares: Stage -> its usual share of the work; the shares add up to 1. A sentence without a known
            stage belongs to the current stage.
        seconds: Time allotted to the work, instead of stages [s]; later work shows no remaining time.
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
        """Remove the bar, before results are printed."""
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

    def time_left(self, now: float) -> tuple[float, float]:
        """Share of the work that is done [-], and the remaining time [s], NaN while it is unknown."""
        if self._seconds:
            elapsed = now - self._start
            remaining = self._seconds - elapsed
            return min(elapsed / self._seconds, NEARLY), remaining if remaining > 0.0 else float("nan")
        if self._before < KNOWN:
            return 0.0, float("nan")
        total = (self._entered - self._start) / self._before
        share = self._shares[self._stage]
        inside = (now - self._entered) / (share * total) if share else 0.0
        if inside > NEARLY:
            return self._before + share * NEARLY, float("nan")
        done = self._before + share * inside
        return done, max(1.0 - done, 0.0) * total

    def _redraw(self) -> None:
        if self._over.wait(PATIENCE):
            return
        width, height = shutil.get_terminal_size()  # 80 by 24 if the terminal does not state its size
        look = {"leave": False, "bar_format": FORM, "ncols": width - 1, "nrows": height}
        with tqdm(total=1.0, file=beneath(sys.stderr), **look) as self._bar:
            while not self._over.wait(REDRAW):
                done, remaining = self.time_left(time.perf_counter())
                words = f"about {tqdm.format_interval(remaining)} left" if math.isfinite(remaining) else ""
                self._bar.set_postfix_str(words, refresh=False)
                self._bar.n = done
                self._bar.refresh()
        self._bar = None
