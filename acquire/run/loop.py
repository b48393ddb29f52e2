"""The only loop, from before the first command to after the last stop: exchange, hand over, look, command."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from traceback import extract_tb, format_exception

import numpy as np

from exidyn.drivers import Command, Driver, DriverError, Sample, StopLevel
from exidyn.drivers.values import any_of, checked
from exidyn.trajectories.trajectory import Trajectory

from .announcer import Silent
from .frames import STAGES, Event, event_frame, sample_frame
from .pipe import Nobody, Sink
from .player import BRAKING, LISTENING, Player
from .stopping.escalation import escalate, state_of
from .stopping.signs import Signs
from .stopping.standstill import Standstill, unknown_at_end
from .stopping.stop import Stop, Stops, harder
from .stopping.watch import CommandCheck, Watch

LISTEN_ON = 2.0
"""How long is listened after each stop that is left to the controller, which takes its own time, and at most
after the last command [s]."""
FAILURES = 5
"""Exchanges in a row in which a driver may fail otherwise than by a lost link, until the link is taken for
lost: one telegram that it cannot read is no reason not to see whether the arm stops."""


@dataclass
class Counts:
    """What happened to the cycles of a run.

    Attributes:
        cycles: Exchanges made.
        skipped: Cycles that went by without one.
        stale: Samples in which a joint was silent.
        lateness: Lateness of each exchange [s].
        work: Processor time of this thread in each cycle, from one exchange to the next [s].
        driver_work: Processor time within each exchange [s].
        block: Longest time between two cycles, less one cycle [s].
    """

    cycles: int = 0
    skipped: int = 0
    stale: int = 0
    lateness: list[float] = field(default_factory=list)
    work: list[float] = field(default_factory=list)
    driver_work: list[float] = field(default_factory=list)
    block: float = 0.0

    def add(self, sample: Sample) -> None:
        """Count one sample."""
        self.cycles += 1
        self.skipped += sample.skipped
        self.stale += any_of(sample.stale)
        self.lateness.append(sample.lateness)


class Loop:
    """One run.

    Args:
        driver: Open and armed.
        watch: What stops the run.
        cycle: Time between exchanges [s].
        sinks: Who is handed every cycle; the failure of the first, the recorder, stops the run.
        head: The frame that explains the run to them, ready but for the time of the first sample.
        asked: What a person asks for.
        signs: Signs that a stop does not work; None where something else moves the arm.
        announcer: Tells a person at once what happens.

    Attributes:
        counts: What happened to the cycles.
        stops: Why the run ends before its time, and what was asked of the driver.
        last: The last sample.
    """

    def __init__(
        self,
        driver: Driver,
        watch: Watch,
        cycle: float,
        sinks: Sequence[Sink] = (),
        head: Callable[[Sample], bytes] | None = None,
        asked: Callable[[], Stop | None] = lambda: None,
        signs: Signs | None = None,
        announcer: Silent | None = None,
    ) -> None:
        self._driver, self._watch, self._cycle_time = driver, watch, cycle
        self._sinks, self._head, self._asked, self._signs = [*sinks], head, asked, signs
        self._player: Player | None = None
        self._check: CommandCheck | None = None
        self._unsent: Command | None = None
        self._stage = -1
        self._lost, self._failures = "", 0
        self._listened, self._used, self._began = 0, 0, 0.0
        self._announcer = announcer or Silent()
        self.counts = Counts()
        self.stops = Stops(driver, self.report, self._announcer.say)
        self.last: Sample | None = None

    def listen(self, until: Callable[[], bool]) -> None:
        """Exchange nothing but samples until something is so, or there is a reason to stop."""
        while not until() and self.stops.reason is None:
            self._cycle(None)

    def play(self, player: Player, check: CommandCheck, way: Trajectory) -> None:
        """Command the way to a motion and the motion, to its end or to a stop; nothing after a stop."""
        if self.stops.reason is not None:
            return
        self._player, self._check = player, check
        player.begin(way)
        while not self.stops.by_controller and (not player.finished or self._unfinished()):
            if not self._cycle(self._next()):
                return

    def finish(self) -> None:
        """Listen on until the arm is at rest: a stop is watched as long as the arm may move."""
        while not self._lost and self._unfinished():
            self._cycle(None)

    def _unfinished(self) -> bool:
        """Whether the arm may still move, after so many cycles; a controller stops it in its own time."""
        self._listened += 1
        if self._listened > round(LISTEN_ON / self._cycle_time):
            return False
        calm = self.last is None or self._signs is None or self._signs.calm
        return self.stops.by_controller or not calm

    def fail(self, error: BaseException) -> None:
        """Stop by the controller's own means, for this program has failed; the arm is listened to further."""
        self.begin_stop(Stop(StopLevel.QUICK, "program failed", f"exidyn failed: {of_failure(error)}"))
        self.report("failure", of_failure(error), {"traceback": "".join(format_exception(error))})

    def lose(self, why: str) -> None:
        """Nothing more can be seen of the arm."""
        self._lost = self._lost or why

    def standstill(self) -> Standstill | None:
        """Whether the arm stands at the end, which is recorded; None where something else moves it."""
        if self._signs is None:
            return None
        why = self._lost or ("nothing was received" if self.last is None else "")
        seen = unknown_at_end(why) if why else self._signs.at_end()
        self.report("standstill", seen.text, seen.details())
        if not seen.stands:
            self._announcer.say(seen.text)
        return seen

    def _next(self) -> Command | None:
        """The next command, or where that is not in order, the first of a stop."""
        assert self._player is not None
        assert self._check is not None
        if self._unsent is not None:
            return self._unsent
        command = self._player.next()
        wrong = self._check.look(command) if command is not None else None
        if wrong is None:
            return command
        self._player.take_back()
        again = self.stops.reason is not None  # a stop that is itself not in order is left to the controller
        self.begin_stop(replace(wrong, level=StopLevel.QUICK) if again else wrong)
        return None if again else self._next()

    def _cycle(self, command: Command | None) -> bool:
        """One exchange, handed over and looked at; whether there is an answer."""
        self._come_round()
        sample = self._exchanged(command)
        if sample is None:
            return False
        if self.last is None and self._head:
            self._hand_over(self._head(sample))
        self.last = sample
        self._unsent = None if sample.sent else command
        command = command if sample.sent else None
        self.counts.add(sample)
        if (stage := self._stage_now()) != self._stage:
            self._stage = stage
            self.report("stage", STAGES[stage])
        self._hand_over(sample_frame(sample, command, self._stage))
        for text in sample.events:
            self.report("driver", text)
        found = harder(self._asked(), self._watch.look(sample, command))
        if self._sinks and (failure := self._sinks[0].failure):
            text = f"the recording cannot go on: {failure}"
            found = harder(found, Stop(StopLevel.BRAKE, "recorder", text))
        self.begin_stop(found)
        if sample.fault:
            self.stops.explain(sample.fault)
        self._escalate(sample, command)
        used = time.thread_time_ns()
        self.counts.work.append(1e-9 * (used - (self._used or used)))
        self._used = used
        return True

    def _come_round(self) -> None:
        """Begin a cycle, and measure the time since the previous one began."""
        if not self._driver.in_real_time:
            return
        self._announcer.come_round()
        now = time.monotonic()
        if self._began:
            self.counts.block = max(self.counts.block, now - self._began - self._cycle_time)
        self._began = now

    def _exchanged(self, command: Command | None) -> Sample | None:
        """What is measured in the cycle; None where the link is lost or the driver fails."""
        used = time.thread_time_ns()
        try:
            sample = checked(self._driver.exchange(command))
        except Exception as error:  # whatever it is, the arm may move, and has to be stopped
            self._not_exchanged(error)
            return None
        self._failures = 0
        self.counts.driver_work.append(1e-9 * (time.thread_time_ns() - used))
        return sample

    def _not_exchanged(self, error: Exception) -> None:
        """Stop by the controller's own means, as far as it still hears."""
        lost = isinstance(error, DriverError)
        self._failures += 1
        text = str(error) if lost else f"the driver failed: {of_failure(error)}"
        if lost or self._failures >= FAILURES:
            self.lose(text)
        found = Stop(StopLevel.QUICK, "link lost" if lost else "driver failed", text)
        if not self.begin_stop(found) and lost:
            unknown = f"whether the stop works is no longer known: {text}"
            self._announcer.say(unknown)
            self.report("driver", unknown)

    def begin_stop(self, found: Stop | None) -> bool:
        """Stop for a reason, unless a stop as hard is under way; whether it is begun."""
        if found is None or not self.stops.begin(found):
            return False
        self._listened = 0
        if self._player is not None and not self.stops.by_controller:
            self._player.brake()
        return True

    def _escalate(self, sample: Sample, command: Command | None) -> None:
        """Stop harder where a stop does not do what it should."""
        if self._signs is None:
            return
        state = state_of(self.stops.level, self._stage)
        found = escalate(state, self._signs.look(sample, command, state))
        if found is not None:
            self.stops.escalate(found)
            self._listened = 0

    def report(self, kind: str, text: str, details: dict[str, object] | None = None) -> None:
        """Hand an event over, at the time of the last sample; before the first there is no receiver."""
        if self.last is None:
            return
        host, controller = self.last.host_time, self.last.controller_time
        self._hand_over(event_frame(Event(host, controller, kind, text, details or {})))

    def _stage_now(self) -> int:
        """What the arm is doing: of a quick stop the player knows nothing."""
        if self._player is None:
            return LISTENING
        return BRAKING if self.stops.by_controller else self._player.stage

    def _hand_over(self, frame: bytes) -> None:
        for place, sink in enumerate(self._sinks):
            try:
                sink.put(frame)
            except Exception as error:  # none should; the arm is watched on without it
                self._sinks[place] = Nobody(of_failure(error))


def of_failure(error: BaseException) -> str:
    """What went wrong in this program, and in which line."""
    rows = extract_tb(error.__traceback__)
    place = f" ({Path(rows[-1].filename).name}:{rows[-1].lineno})" if rows else ""
    return f"{type(error).__name__}: {error}{place}"


def percentiles(name: str, values: Sequence[float]) -> dict[str, float]:
    """Median, 99th percentile and largest of some values, as `name_p50` and so on; nothing of none."""
    if not values:
        return {}
    p50, p99 = np.percentile(values, [50, 99])
    return {f"{name}_p50": float(p50), f"{name}_p99": float(p99), f"{name}_max": max(values)}
