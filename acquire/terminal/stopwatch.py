"""Progress and remaining time of a command that takes long."""

import math
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import timedelta
from threading import Event, Thread
from typing import Self, TypeVar

import numpy as np

from exidyn.identification.progress import StageText
from exidyn.identification.text_table import paragraph
from exidyn.quoting import visible

from ..run.errors import CLEAR
from ..screen import beneath

T = TypeVar("T")
Progress = Callable[[str], None]
"""Function that takes a sentence at each stage."""

REDRAW = 0.5
"""Update period of the line [s]."""
KNOWN = 0.02
"""Share of the work after which its remaining time is estimated."""
NEARLY = 0.95
"""Share of a stage at which the line waits while the stage takes longer than expected; the remaining time is
then unknown."""


class Stopwatch:
    """Progress of a command on standard error; a context manager.

    In a terminal, one line shows the last sentence, the time since the start, and the remaining time if the
    stages or the time are known; it is rewritten, and removed at the end. Pipes and files get all sentences.

    Args:
        shares: Stage -> its usual share of the work; the shares add up to 1. A sentence without a known
            stage belongs to the current stage.
        seconds: Time allotted to the work, instead of stages [s]; later work shows no remaining time.
    """

    def __init__(self, shares: Mapping[str, float] | None = None, seconds: float = 0.0) -> None:
        self._start = time.perf_counter()
        self._shares, self._seconds = dict(shares or {}), seconds
        self._stage, self._entered = "", self._start
        self._before, self._sentence = 0.0, ""
        self._over = Event()
        self._thread: Thread | None = None

    def __enter__(self) -> Self:
        if sys.stderr.isatty():
            self._thread = Thread(target=self._redraw, daemon=True)
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the line, before results are printed."""
        self._over.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def __call__(self, sentence: str) -> None:
        """Show a sentence, and enter the stage that it begins."""
        self._sentence = sentence
        if self._thread is None:
            since = f"{time.perf_counter() - self._start:6.1f} s  "
            print("\n".join(paragraph(sentence, " " * len(since), since)), file=sys.stderr, flush=True)
        stage = sentence.stage if isinstance(sentence, StageText) else self._stage
        if stage in self._shares and stage != self._stage:
            names = list(self._shares)
            self._before = sum(self._shares[name] for name in names[: names.index(stage)])
            self._stage, self._entered = stage, time.perf_counter()

    def over(self, items: Sequence[T] | np.ndarray) -> Iterator[T]:
        """Iterate over items that take equal times."""
        began = time.perf_counter()
        for place, item in enumerate(items):
            if place:
                self._seconds = (time.perf_counter() - began) * len(items) / place
            yield item

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
        terminal = beneath(sys.stderr)
        while not self._over.wait(REDRAW):
            terminal.write(CLEAR + visible(self._line(time.perf_counter())))
            terminal.flush()
        terminal.write(CLEAR)
        terminal.flush()

    def _line(self, now: float) -> str:
        """The line of progress, cut to the width of the terminal."""
        done, remaining = self.time_left(now)
        ending = f"about {timedelta(seconds=round(remaining))} left" if math.isfinite(remaining) else ""
        words = filter(None, [f"{100.0 * done:.0f} %" if done else "", ending, self._sentence])
        # 80 columns if the terminal does not state its size
        return f"{now - self._start:6.1f} s  {', '.join(words)}"[: shutil.get_terminal_size().columns - 1]
