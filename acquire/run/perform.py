"""Perform: one run from opening the driver to closing it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from threading import Thread
from typing import TypeVar

import numpy as np

from exidyn.drivers import Driver, Info, Sample, StopLevel
from exidyn.identification.arm.newton_euler import flange_position
from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.errors import ExidynError
from exidyn.trajectories.families.phases import Phases
from exidyn.trajectories.trajectory import Trajectory

from .announcer import Silent
from .before import StartRules, plan_start
from .errors import CannotStart
from .loop import Counts, Loop, of_failure
from .pipe import Sink
from .player import Player
from .realtime import yield_to_the_loop
from .stopping.signs import Signs
from .stopping.standstill import Standstill
from .stopping.stop import Stop
from .stopping.watch import CommandCheck, Watch, WatchLimits

LISTEN = 0.1
"""How long the arm is listened to before anything is commanded [s]; its position is the median of that."""
FEWEST = 5
"""Samples that at least are taken of it."""
TO_START = 60.0
"""What a person is given to start the motion at the controller, where it is only listened to [s]."""
T = TypeVar("T")


@dataclass(frozen=True)
class Job:
    """What is to be done with an arm.

    Attributes:
        robot: Nominal.
        motion: At the speed at which it is to be played.
        limits: The robot's, finite in velocity, acceleration and jerk.
        start: How to get there.
        watch: What stops the run.
        current: Largest current, shape (n,) [A]; None for what makes the largest torque.
        settle: How long rest is recorded at the end [s].
    """

    robot: Robot
    motion: Trajectory
    limits: Limits
    start: StartRules = field(default_factory=StartRules)
    watch: WatchLimits = field(default_factory=WatchLimits)
    current: np.ndarray | None = None
    settle: float = 0.5


@dataclass(frozen=True)
class Outcome:
    """How a run went.

    Attributes:
        info: Metadata of the driver.
        counts: Cycles, and what happened to them.
        stop: Why it ended before its time; None if it did not.
        escalated: What was asked of the driver since, because that stop did not work, in order.
        standstill: Whether the arm stood at the end; None where something else moves it.
    """

    info: Info
    counts: Counts
    stop: Stop | None
    escalated: tuple[Stop, ...] = ()
    standstill: Standstill | None = None

    @property
    def notice(self) -> str:
        """What a person must know about the arm at the end; empty if it stands where it was commanded."""
        return "" if self.standstill is None or self.standstill.expected else self.standstill.text

    @property
    def unsafe(self) -> str:
        """What a person must be told: that the arm still moves, or may; empty where it stands."""
        return "" if self.standstill is None or self.standstill.stands else self.standstill.text


def perform(
    driver: Driver,
    job: Job | Callable[[Info], Job],
    sinks: Sequence[Sink] = (),
    head: Callable[[Info], Callable[[Sample], bytes]] | None = None,
    asked: Callable[[], Stop | None] = lambda: None,
    opened: Callable[[Info], None] = lambda info: None,
    announcer: Silent | None = None,
) -> Outcome:
    """Run the job and hand over every cycle of it; the driver is closed in the end, come what may.

    A fault of this program is a quick stop, as a lost link is, and the reason of the outcome.

    Args:
        driver: Not open yet.
        job: What to do, or what gives it once the driver is open, before its drives are powered.
        sinks: Recorder first, then who else wants to know.
        head: What explains the run to them: made before anything is exchanged, ready with the first sample.
        asked: What a person asks for while it goes on.
        opened: Called with the driver's metadata, before its drives are powered.
        announcer: Prints stops as they happen, and whether the arm stands, before the driver is closed.

    Raises:
        DriverError: The driver could not be opened or armed.
    """
    try:
        info = driver.open()
        opened(info)
        work = job if isinstance(job, Job) else job(info)
        explain = head(info) if head else None
        watch = Watch(work.robot, info, work.watch, work.current)
        signs = None if info.listens else _signs(work, info, watch)
        loop = Loop(driver, watch, info.cycle, sinks, explain, asked, signs, announcer)
        driver.arm_drives()
        if info.listens:
            return Outcome(info, loop.counts, _listened(loop, work, info))
        _play_to_rest(loop, work, info, driver)
        standstill = loop.standstill()
        return Outcome(info, loop.counts, loop.stops.reason, tuple(loop.stops.escalated), standstill)
    finally:
        if announcer is not None:
            announcer.leave()
        driver.close()


def _signs(job: Job, info: Info, watch: Watch) -> Signs:
    robot = job.robot
    with np.errstate(divide="ignore"):
        current = robot.limits.torque / np.abs(robot.drive_gain)
    return Signs(
        robot.joints,
        job.limits,
        current,
        job.watch,
        info.cycle,
        robot.unit,
        watch.tracking_error,
        partial(flange_position, robot.kinematics, robot.flange, data=robot.kinematics.createData()),
    )


def _play_to_rest(loop: Loop, job: Job, info: Info, driver: Driver) -> None:
    """Play, and listen until the arm is at rest; whatever fails on the way, the arm is stopped."""
    try:
        _play(loop, job, info, driver)
        loop.finish()
    except BaseException as error:
        try:
            loop.fail(error)
            loop.finish()
        except Exception as again:
            loop.lose(f"exidyn failed again: {of_failure(again)}")
        if not isinstance(error, Exception):  # asked for by a person or the operating system
            raise


def _listened(loop: Loop, job: Job, info: Info) -> Stop | None:
    """Record what something else moves, for as long as the motion lasts and a while to start it in.

    Gives why it ended before; that the controller has ended its session is no reason to complain.
    """
    end = round((job.motion.duration + TO_START) / info.cycle)
    loop.listen(lambda: loop.counts.cycles + loop.counts.skipped >= end)
    stop = loop.stops.reason
    ended = stop is not None and stop.kind == "link lost" and loop.counts.cycles > 0
    return None if ended else stop


def _play(loop: Loop, job: Job, info: Info, driver: Driver) -> None:
    loop.listen(lambda: driver.ready)
    measured = _standing(loop, info)
    if loop.stops.reason is not None:
        return
    commanded = driver.held()
    held = measured if commanded is None else commanded

    def work() -> tuple[Player, Phases]:
        player = Player(job.motion, job.limits, info.cycle, job.settle)
        unit = job.robot.unit
        return player, plan_start(player, held, job.robot.joints, job.limits, job.start, info, unit)

    try:
        _require_near(held, measured, job)
        # A simulation off the wall clock need not be listened to meanwhile, and is then the same every time.
        prepared = _meanwhile(loop, work) if driver.in_real_time else work()
        if prepared is None:
            return
        _require_still(loop, measured, job)
    except ExidynError as error:
        loop.begin_stop(Stop(StopLevel.BRAKE, "start", str(error)))
        return
    player, way = prepared
    lower = None if info.window_lower is None else held + info.window_lower
    upper = None if info.window_upper is None else held + info.window_upper
    robot = job.robot
    check = CommandCheck(robot.joints, job.limits, info.cycle, held, lower, upper, robot.unit)
    loop.play(player, check, way)


def _standing(loop: Loop, info: Info) -> np.ndarray:
    """Where the arm stands: the median of some samples, shape (n,) [rad]; NaN for a joint that is silent."""
    seen: list[np.ndarray] = []
    count = max(round(LISTEN / info.cycle), FEWEST)

    def enough() -> bool:
        if loop.last is not None:
            seen.append(loop.last.position)
        return len(seen) >= count

    loop.listen(enough)
    known = [position for position in seen if np.isfinite(position).all()] or seen
    return np.median(known, axis=0) if known else np.empty(0)


def _require_near(held: np.ndarray, measured: np.ndarray, job: Job) -> None:
    """Raise where the arm does not stand where its drives are commanded to hold it."""
    away = np.abs(held - measured)
    if np.any(away > job.watch.tracking):
        joint = int(np.nanargmax(away))
        unit = job.robot.unit(joint, "rad")
        raise CannotStart(
            f"{job.robot.joints[joint]} stands {away[joint]:.4f} {unit} from where its drive was commanded, "
            f"allowed are {job.watch.tracking:.4f} {unit} (--tracking). Is its drive on, are its gains high "
            "enough?"
        )


def _require_still(loop: Loop, measured: np.ndarray, job: Job) -> None:
    """Raise where the arm is no longer where the way was planned from."""
    assert loop.last is not None
    moved = np.abs(loop.last.position - measured)
    if np.any(moved > job.start.tolerance):
        joint = int(np.nanargmax(moved))
        unit = job.robot.unit(joint, "rad")
        raise CannotStart(
            f"{job.robot.joints[joint]} has moved by {moved[joint]:.4f} {unit} while the way was planned, "
            f"allowed are {job.start.tolerance:.4f} {unit}. Let the arm stand still, then start again"
        )


def _meanwhile(loop: Loop, work: Callable[[], T]) -> T | None:
    """What the work gives, done in a thread while the loop listens: no controller likes to wait.

    None if there is a reason to stop; the work is not waited for then.
    """
    result: list[T] = []
    errors: list[Exception] = []

    def worker() -> None:
        yield_to_the_loop()
        try:
            result.append(work())
        except Exception as error:  # raised again below, in the thread that waits for it
            errors.append(error)

    thread = Thread(target=worker, daemon=True)
    thread.start()
    loop.listen(lambda: not thread.is_alive())
    if loop.stops.reason is not None:
        return None
    if errors:
        raise errors[0]
    return result[0]
