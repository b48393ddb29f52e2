"""One run as `exidyn record` makes it: recorder in its own process, loop in real time, everything counted."""

import os
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import NamedTuple

from exidyn.acquire.run.frames import END, text_frame
from exidyn.acquire.run.perform import Job, Outcome, perform
from exidyn.acquire.run.pipe import PipeSink, Sink
from exidyn.acquire.run.realtime import realtime
from exidyn.acquire.run.recorder import RunHead, start_recorder
from exidyn.acquire.run.stopping.stop import Stop
from exidyn.acquire.terminal import run_summary
from exidyn.drivers import Driver, Info, Sample

from .motion import COBOT, FR3, BenchArm


class Ran(NamedTuple):
    """A run."""

    outcome: Outcome  # How it went
    path: Path  # Of the recording
    seconds: float  # From opening the driver to closing it [s]
    cpu: float  # Of the loop's process in that time [s]
    cpu_recorder: float  # Of the recorder's [s]
    refused: Sequence[str]  # What the operating system refused of real time
    recorder: PipeSink  # As the loop saw it


def run(
    driver: Driver,
    job: Job,
    path: Path,
    asked: Callable[[], Stop | None] = lambda: None,
    sinks: Callable[[PipeSink], Sequence[Sink]] = lambda recorder: (),
    started: Callable[[int], None] = lambda recorder: None,
) -> Ran:
    """Play a job with a driver that is not open yet, and record it.

    `asked` is called every cycle and may ask to stop; `sinks` makes who else is handed every frame; `started`
    is called with the number of the recorder's process before the run.
    """
    arm = next(arm for arm in (COBOT, FR3) if arm.model.robot.joints == driver.arm.joints)
    with ExitStack() as stack:
        recorder = stack.enter_context(start_recorder(path))
        others = [stack.enter_context(closing(sink)) for sink in sinks(recorder)]
        everybody = [recorder, *others]
        started(recorder.process_id)
        refused = stack.enter_context(realtime()) if driver.in_real_time else []
        began, used = time.monotonic(), time.process_time()
        before = cpu_time(recorder.process_id)
        outcome = perform(driver, job, everybody, lambda info: _head(path, info, arm), asked)
        seconds, used = time.monotonic() - began, time.process_time() - used
        by_recorder = cpu_time(recorder.process_id) - before
        for sink in everybody:
            sink.put(text_frame(END, run_summary.end(outcome)))
    return Ran(outcome, path, seconds, used, by_recorder, refused, recorder)


def _head(path: Path, info: Info, arm: BenchArm) -> Callable[[Sample], bytes]:
    head = RunHead(
        name=path.stem,
        model=arm.model,
        signals=info.signals,
        settings=info.settings,
        warnings=info.warnings,
        state=info.state,
    )
    begun = head.prepare_frame()
    return lambda sample: begun(sample.host_time, sample.controller_time)


def cpu_time(process: int) -> float:
    """CPU time that a process has used [s]; NaN where unknown."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return float("nan")
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
