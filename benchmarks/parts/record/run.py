"""One run as `exidyn record` makes it, everything counted; the arms that benchmarks record, and their motion.

The recorder is in its own process, the loop in real time.
"""

import os
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from exidyn.acquire.run.frames import END, text_frame
from exidyn.acquire.run.perform import Job, Outcome, perform
from exidyn.acquire.run.pipe import PipeSink, Sink
from exidyn.acquire.run.realtime import realtime
from exidyn.acquire.run.recorder import RunHead, start_recorder
from exidyn.acquire.run.stopping.stop import Stop
from exidyn.acquire.terminal import run_summary
from exidyn.drivers import Driver, Info, Sample
from exidyn.identification.arm.robot import Limits
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.usable_limits import Margins, usable
from exidyn.trajectories.planning.planner import plan, whole_run
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.search.delivery import inside_kinematics
from exidyn.trajectories.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class BenchArm:
    """An arm that peers simulate."""

    file: str  # Of the robot, or its name

    @cached_property
    def model(self) -> Model:
        """Nominal, which is what it is too."""
        return read_model(self.file)

    @cached_property
    def limits(self) -> Limits:
        """Finite ones."""
        return usable(self.model.robot, Margins(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)).limits

    @cached_property
    def start(self) -> np.ndarray:
        """Where the peers' arms stand, shape (n,) [rad]."""
        limits = self.model.robot.limits
        middle: np.ndarray = 0.5 * (
            np.maximum(limits.position_lower, -np.pi) + np.minimum(limits.position_upper, np.pi)
        )
        return middle


COBOT = BenchArm("cobot")
FR3 = BenchArm(str(Path(__file__).parents[3] / "tests" / "peers" / "fr3.toml"))
"""Of a driver whose controller has seven joints."""
ROBOT, MODEL, START = COBOT.file, COBOT.model, COBOT.start
TICK = 0.02
"""Of the motions [s]: a whole number of every controller's cycles."""
PLANNED = 8.0
"""Motions as long as this are planned to identify the parameters; shorter ones are random [s]."""
SHARE = 0.35
"""Of the limits, in a short motion [-]: full speed would leave no time but for getting there."""
AROUND = 6.5
"""Of rests and leads of a planned motion, at most [s]."""
REST = 0.5
"""At both ends [s]: rest shows the noise."""


@cache
def motion(seconds: float, arm: BenchArm = COBOT) -> Trajectory:
    """A motion of about so many seconds, from the middle of the range and back, inside all limits."""
    if seconds < PLANNED:
        return _random(seconds, arm)
    period = min(10.0, 0.5 * TICK * round(seconds / TICK))
    wishes = Wishes(
        seconds=max(seconds, period + AROUND), period=period, start=arm.start, tick=TICK, rest=REST
    )
    return plan(arm.model, wishes, starts=1, seconds=5.0)[0].trajectory


def _random(seconds: float, arm: BenchArm) -> Trajectory:
    period = TICK * max(round((seconds - 2.0) / TICK), 50)
    sine, cosine = np.random.default_rng(0).normal(size=(2, len(arm.start), 2)) / [1.0, 2.0]
    series = inside_kinematics(Fourier(period, arm.start, sine, cosine), arm.limits, SHARE)
    wishes = Wishes(tick=TICK, seconds=period + 2.0, start=arm.start, rest=0.1)
    return whole_run(series, arm.limits, wishes)


def job(seconds: float, arm: BenchArm = COBOT, **other: object) -> Job:
    """To play that motion; `other` as in `Job`."""
    return Job(arm.model.robot, motion(seconds, arm=arm), arm.limits, **other)  # type: ignore[arg-type]


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
