"""Runs damaged files through a parser and reports the results."""

import resource
import shutil
import signal
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from exidyn.drivers.errors import DriverError
from exidyn.identification.errors import ExidynError, RobotWarning

from ..runs.parser_files import write
from .fuzz_mutations import mutated
from .fuzz_parsers import PARSERS

PATIENCE = 150
"""Seconds after which a parser hangs: more than twice what a reader in a process of its own is given, so that
a busy machine, on which starting such a process takes a minute, is no failure."""
MEMORY = 4 << 30
"""Bytes of address space beyond what is in use that no parser of these small files needs."""
LONGEST = 300
"""Characters of the one line that a command prints, its name at the beginning included."""
COMMAND = "exidyn: "


@dataclass
class Outcome:
    """What came of one parser's inputs."""

    read: int = 0  # inputs that were read
    refused: int = 0  # inputs that were refused with an error for the user
    longest: str = ""  # of the lines that give the reason
    # seed of the input and what else was raised
    failures: list[tuple[int, str]] = field(default_factory=list)

    @property
    def inputs(self) -> int:
        """How many there were."""
        return self.read + self.refused + len(self.failures)

    def kinds(self) -> Counter[str]:
        """How often each failure was seen, by its last lines."""
        return Counter(text for _, text in self.failures)


class Hang(BaseException):
    """A parser that did not come to an end."""


def fuzz(name: str, count: int, folder: Path, seed: int = 0) -> Outcome:
    """Damaged inputs of one parser, always the same for a seed."""
    outcome = Outcome()
    with bounded_memory():
        for place in range(count):
            _try(name, seed + place, folder, outcome)
    return outcome


def damage(name: str, seed: int, folder: Path) -> str:
    """Write the input of a seed into an emptied folder; the name of the file that is damaged."""
    random = np.random.default_rng([seed, *name.encode()])
    damages = PARSERS[name].damages()
    chosen = damages[seed % len(damages)]
    shutil.rmtree(folder, ignore_errors=True)
    files = dict(chosen.files)
    files[chosen.name] = chosen.finish(mutated(files[chosen.name], random, chosen.mutations))
    write(files, folder)
    return chosen.name


def _try(name: str, seed: int, folder: Path, outcome: Outcome) -> None:
    file = damage(name, seed, folder)
    try:
        with bounded_time(), warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", RobotWarning)  # a line for the user, as an error is
            PARSERS[name].read(folder, file)
        outcome.read += 1
    except (ExidynError, DriverError) as error:
        outcome.refused += 1
        line = COMMAND + " ".join(str(error).split())
        outcome.longest = max(outcome.longest, line, key=len)
    except (Exception, Hang) as error:
        outcome.failures.append((seed, _told(error)))


def _told(error: BaseException) -> str:
    """An exception and where in exidyn it was raised."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "/tests/" not in f.filename]
    ours = [f for f in frames if "site-packages" not in f.filename and "/lib/python" not in f.filename]
    where = f"{Path(ours[-1].filename).name}:{ours[-1].lineno}" if ours else "?"
    return f"{where} {type(error).__name__}: {str(error)[:100]}"


@contextmanager
def bounded_time() -> Iterator[None]:
    """Raise `Hang` in what takes too long."""

    def stop(*_: Any) -> None:
        raise Hang(f"more than {PATIENCE} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@contextmanager
def bounded_memory() -> Iterator[None]:
    """MemoryError in what asks for far more than it needs."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
