"""Perform: a run, from opening the driver to closing it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from threading import Thread
from typing import TypeVar

import numpy as np

from exidyn.drivers import Driver, Info, Sample, StopLevel
from exidyn.drivers.host_clock import Clock
from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.errors import ExidynError
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.trajectory import Trajectory

from .announcer import Silent
from .before import StartRules, plan_start
from .errors import CannotStart
from .loop import Counts, Loop, failure_text
from .pipe import Sink
from .player import Player
from .realtime import yield_to_the_loop
from .stopping.signs import Signs
from .stopping.stop import Standstill, Stop
from .stopping.watch import CommandCheck, Watch, WatchLimits

LISTEN_TIME = 0.1
"""Time of listening before the first command [s]; the arm's position is the median over this time."""
MIN_SAMPLES = 5
"""Minimum number of samples for this position."""
START_TIME = 60.0
"""Time for a person to start the motion at a controller that is only listened to [s]."""
T = TypeVar("T")


@dataclass(frozen=True)
class Job:
    """A motion to perform with an arm."""

    robot: Robot  # nominal robot
    motion: Trajectory  # motion at playback speed
    limits: Limits  # limits of the robot, finite in velocity, acceleration and jerk
    start: StartRules = field(default_factory=StartRules)  # rules of the approach to the start of the motion
    watch: WatchLimits = field(default_factory=WatchLimits)  # limits that stop the run
    # Maximum current, shape (n,) [A]; None for the current that makes the maximum torque.
    current: np.ndarray | None = None
    settle: float = 0.5  # duration of rest to record at the end [s]


@dataclass(frozen=True)
class Outcome:
    """Result of a run."""

    info: Info  # metadata of the driver
    counts: Counts  # statistics of the cycles
    stop: Stop | None  # stop that ended the run early, or None
    escalated: tuple[Stop, ...] = ()  # harder stops requested because that stop did not work, in order
    standstill: Standstill | None = None  # whether the arm stood at the end; None if something else moves it

    @property
    def notice(self) -> str:
        """Notice about the arm at the end; empty if it stands where it was commanded."""
        return "" if self.standstill is None or self.standstill.expected else self.standstill.text

    @property
    def unsafe(self) -> str:
        """Warning that the arm still moves or may move; empty if it stands."""
        return "" if self.standstill is None or self.standstill.stands else self.standstill.text


def perform(
    driver: Driver,
    job: Job | Callable[[Info], Job],
    sinks: Sequence[Sink] = (),
    head: Callable[[Info], Callable[[Sample], bytes]] | None = None,
    stop_request: Callable[[], Stop | None] = lambda: None,
    opened: Callable[[Info], None] = lambda info: None,
    announcer: Silent | None = None,
) -> Outcome:
    """Perform a job and hand over each of its cycles; the driver is always closed at the end.

    An error of this program causes a quick stop, like a lost link, and is the reason in the outcome.

    Args:
        driver: Driver that is not open yet.
        job: Job, or function that makes it when the driver is open, before its drives are powered.
        sinks: Receivers of all frames, the recorder first.
        head: Function called before the first exchange; the function it returns makes the head frame.
        stop_request: Function that returns a stop requested by a person, or None.
        opened: Function called with the driver's metadata before its drives are powered.
        announcer: Announcer of stops and of the standstill, before the driver is closed.

    Raises:
        DriverError: If the driver cannot be opened or armed.
    """
    try:
        info = driver.open()
        opened(info)
        work = job if isinstance(job, Job) else job(info)
        explain = head(info) if head else None
        watch = Watch(work.robot, info, work.watch, work.current)
        signs = None if info.listens else _signs(work, info, watch)
        loop = Loop(driver, watch, info.cycle, sinks, explain, stop_request, signs, announcer)
        driver.arm_drives()
        if info.listens:
            return Outcome(info, loop.counts, _listen_only(loop, work, info))
        _play_to_rest(loop, work, info, driver)
        standstill = loop.standstill()
        return Outcome(info, loop.counts, loop.stops.reason, tuple(loop.stops.escalated), standstill)
    finally:
        if announcer is not None:
            announcer.stop_watching()
        driver.close()


def _signs(job: Job, info: Info, watch: Watch) -> Signs:
    robot = job.robot
    with np.errstate(divide="ignore"):
        current = robot.limits.torque / np.abs(robot.drive_gain)
    data = robot.kinematics.createData()
    flange = partial(flange_position, robot.kinematics, robot.flange, data=data)
    return Signs(robot, job.limits, current, job.watch, info.cycle, watch.history, flange)


def _play_to_rest(loop: Loop, job: Job, info: Info, driver: Driver) -> None:
    """Play the motion and listen until the arm is at rest; the arm is stopped if anything fails."""
    try:
        _play(loop, job, info, driver)
        loop.finish()
    except BaseException as error:
        try:
            loop.fail(error)
            loop.finish()
        except Exception as second_error:
            loop.lose(f"exidyn failed again: {failure_text(second_error)}")
        if not isinstance(error, Exception):  # requested by a person or the operating system
            raise


def _listen_only(loop: Loop, job: Job, info: Info) -> Stop | None:
    """Record an arm that something else moves, for the motion's duration and the time to start it.

    Returns the stop that ended this early, if any; the end of the controller's session does not count.
    """
    end = round((job.motion.duration + START_TIME) / info.cycle)
    loop.listen(lambda: loop.counts.cycles + loop.counts.skipped >= end)
    stop = loop.stops.reason
    ended = stop is not None and stop.kind == "link lost" and loop.counts.cycles > 0
    return None if ended else stop


def _play(loop: Loop, job: Job, info: Info, driver: Driver) -> None:
    loop.listen(lambda: driver.ready)
    measured = _standing_position(loop, info)
    if loop.stops.reason is not None:
        return
    commanded = driver.held()
    start = measured if commanded is None else commanded

    def prepare() -> tuple[Player, Phases]:
        player = Player(job.motion, job.limits, info.cycle, job.settle)
        return player, plan_start(player, start, job.robot, job.limits, job.start, info)

    try:
        _require_near(start, measured, job)
        # A simulation off the wall clock needs no exchanges meanwhile, and is reproducible without.
        prepared = _run_while_listening(loop, driver.clock, prepare) if driver.in_real_time else prepare()
        if prepared is None:
            return
        _require_still(loop, measured, job)
    except ExidynError as error:
        loop.begin_stop(Stop(StopLevel.BRAKE, "start", str(error)))
        return
    player, approach = prepared
    lower = None if info.window_lower is None else start + info.window_lower
    upper = None if info.window_upper is None else start + info.window_upper
    check = CommandCheck(job.robot, job.limits, info.cycle, start, lower, upper)
    loop.play(player, check, approach)


def _standing_position(loop: Loop, info: Info) -> np.ndarray:
    """Median position of some samples at rest, shape (n,) [rad] or [m]; NaN for a silent joint."""
    positions: list[np.ndarray] = []
    count = max(round(LISTEN_TIME / info.cycle), MIN_SAMPLES)

    def enough() -> bool:
        if loop.last is not None:
            positions.append(loop.last.position)
        return len(positions) >= count

    loop.listen(enough)
    known = [position for position in positions if np.isfinite(position).all()] or positions
    return np.median(known, axis=0) if known else np.empty(0)


def _require_near(commanded: np.ndarray, measured: np.ndarray, job: Job) -> None:
    """Raise if the arm does not stand where its drives are commanded to hold it."""
    away = np.abs(commanded - measured)
    if np.any(away > job.watch.tracking):
        joint = int(np.nanargmax(away))
        unit = job.robot.unit(joint, "rad")
        raise CannotStart(
            f"{job.robot.joints[joint]} stands {away[joint]:.4f} {unit} from where its drive was commanded, "
            f"limit {job.watch.tracking:.4f} {unit} (--tracking). Check that its drive is on and that its "
            "gains are high enough"
        )


def _require_still(loop: Loop, measured: np.ndarray, job: Job) -> None:
    """Raise if the arm has moved since the approach was planned."""
    assert loop.last is not None
    moved = np.abs(loop.last.position - measured)
    if np.any(moved > job.start.tolerance):
        joint = int(np.nanargmax(moved))
        unit = job.robot.unit(joint, "rad")
        raise CannotStart(
            f"{job.robot.joints[joint]} moved by {moved[joint]:.4f} {unit} while the approach was planned, "
            f"limit {job.start.tolerance:.4f} {unit}. Let the arm stand still, then start again"
        )


def _run_while_listening(loop: Loop, clock: Clock, work: Callable[[], T]) -> T | None:
    """Run a function in a thread while the loop listens, so that the controller need not wait.

    Returns the function's result, or None as soon as there is a reason to stop.
    """
    result: list[T] = []
    errors: list[Exception] = []

    def worker() -> None:
        yield_to_the_loop()
        try:
            result.append(work())
        except Exception as error:  # raised below, in the thread that waits for the result
            errors.append(error)

    thread = Thread(target=worker, daemon=True)
    clock.start(thread)
    loop.listen(lambda: not thread.is_alive())
    if loop.stops.reason is not None:
        return None
    if errors:
        raise errors[0]
    return result[0]
