"""One fault on purpose, in a run that is otherwise as any other, and what is seen of it."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from exidyn.acquire.run.frames import SAMPLE, Unframed, read_cycle
from exidyn.acquire.run.perform import Job
from exidyn.acquire.run.player import RUNNING
from exidyn.acquire.run.recorder import part_of
from exidyn.acquire.run.stopping.stop import StopRequests
from exidyn.drivers import DriverError
from exidyn.identification.errors import ExidynError
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.recording import Recording

from ..controllers import Peer, controller
from ..motion import job
from ..run import Ran, run

SECONDS = 4.0
"""Of the motion that a fault hits."""
CRAWL = 1e-3
"""Way in 20 ms below which an arm counts as at rest [rad]."""

Action = tuple[int, Callable[[], object]]
"""A number of cycles from the beginning of the motion, and what to do then."""


@dataclass(frozen=True)
class Seen:
    """What a run with a fault has left.

    Attributes:
        ran: The run.
        recording: As it is read back.
        messages: Of the peer.
    """

    ran: Ran
    recording: Recording
    messages: str

    @property
    def last_motion(self) -> float:
        """When the arm was last faster than a crawl, on the recording's axis [s]; zero for never."""
        position = self.recording.signals["position"]
        window = max(round(0.02 / self.ran.outcome.info.cycle), 1)
        moved = np.abs(position.values[window:] - position.values[:-window])
        moving = np.flatnonzero(np.nanmax(moved, axis=1, initial=0.0) > CRAWL)
        return float(position.time[window:][moving[-1]]) if len(moving) else 0.0

    @property
    def stopping_time(self) -> float:
        """Time from a stop until the arm was last seen moving [s]; NaN without one."""
        stops = [event.time for event in self.recording.events if event.kind == "stop"]
        return max(self.last_motion - stops[0], 0.0) if stops else float("nan")

    @property
    def words(self) -> str:
        """How the run went."""
        counts, stop = self.ran.outcome.counts, self.ran.outcome.stop
        missed = f"{counts.skipped} cycles missed, {counts.stale} with silence"
        if stop is None:
            return f"to its end; {missed}"
        rest = "" if np.isnan(self.stopping_time) else f", at rest after {self.stopping_time:.2f} s"
        return f"{stop.level.name} ({stop.kind}){rest}; {missed}"


Check = Callable[[Seen], str]
"""What is wrong, in words; empty if nothing."""


@dataclass(frozen=True)
class Fault:
    """One fault.

    Attributes:
        name: What goes wrong.
        must: What must happen, and why.
        driver: Through which it is shown.
        checks: What must be so.
        arguments: Of the peer.
        acts: Makes what is done, out of the peer.
        task: Makes the job, out of the duration of the motion [s].
        quick: Whether it is shown in a hurry too.
    """

    name: str
    must: str
    driver: str
    checks: Sequence[Check]
    arguments: tuple[str, ...] = ()
    acts: Callable[[Peer], Sequence[Action]] = lambda peer: ()
    task: Callable[[float], Job] = job
    quick: bool = False


class Row:
    """What became of a fault.

    Args:
        name: Of the fault.
        must: What must happen.
        happened: What happened.
        wrong: What must not have, a sentence each; empty ones do not count.
    """

    def __init__(self, name: str, must: str, happened: str, wrong: Sequence[str]) -> None:
        self.name, self.wrong = name, [text for text in wrong if text]
        self.cells = [name, must, happened, "NO: " + "; ".join(self.wrong) if self.wrong else "ok"]


class Trigger:
    """A sink that does things at moments of the motion."""

    failure = ""

    def __init__(self, actions: Sequence[Action]) -> None:
        self._actions, self._count, self._frames = dict(actions), 0, Unframed()

    def put(self, frame: bytes) -> None:
        """Look whether it is time."""
        for kind, body in self._frames.add(frame):
            if kind == SAMPLE and read_cycle(body).stage >= RUNNING:
                self._count += 1
                if action := self._actions.get(self._count):
                    action()

    def close(self) -> None:
        """Nothing waits here."""


def shown(fault: Fault) -> Row:
    """Let it happen."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            seen = suffered(fault, Path(folder))
        except (DriverError, ExidynError, OSError) as error:
            return Row(fault.name, fault.must, "an error", [f"{type(error).__name__}: {error}"])
        return Row(fault.name, fault.must, seen.words, [check(seen) for check in fault.checks])


def of_interest(task: Job) -> Job:
    """The same job, not stopped by cycles that this machine misses by itself: that would hide the fault."""
    return replace(task, watch=replace(task.watch, missed=1.0))


def suffered(fault: Fault, folder: Path) -> Seen:
    """A run with the fault in it."""
    path, task = folder / "run.mcap", of_interest(fault.task(SECONDS))
    with controller(fault.driver, folder, *fault.arguments) as (driver, peer), StopRequests() as asked:
        trigger = Trigger(fault.acts(peer))
        ran = run(driver, task, path, asked.look, lambda recorder: [trigger])
    left = path if path.exists() else part_of(path)
    return Seen(ran, read_recording(left), "".join(peer.lines) if peer else "")
