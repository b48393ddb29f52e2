"""The control loop, from before the first command until after the last stop."""

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
from .stopping.stop import Standstill, Stop, Stops, harder, unknown_at_end
from .stopping.watch import CommandCheck, Watch

LISTEN_ON = 2.0
"""Maximum time to keep listening after the last command, and after each stop made by the controller [s]."""
FAILURES = 5
"""Consecutive driver errors, other than a lost link, after which the link counts as lost. A single unreadable
message must not keep the loop from seeing whether the arm stops."""


@dataclass
class Counts:
    """Statistics of the cycles of a run."""

    cycles: int = 0  # number of exchanges
    skipped: int = 0  # number of cycles without an exchange
    stale: int = 0  # number of samples in which a joint was silent
    lateness: list[float] = field(default_factory=list)  # lateness of each exchange [s]
    # CPU time of this thread in each cycle, from one exchange to the next [s].
    work: list[float] = field(default_factory=list)
    driver_work: list[float] = field(default_factory=list)  # CPU time within each exchange [s]
    block: float = 0.0  # maximum delay between two cycles, beyond the cycle time [s]

    def add(self, sample: Sample) -> None:
        """Count a sample."""
        self.cycles += 1
        self.skipped += sample.skipped
        self.stale += any_of(sample.stale)
        self.lateness.append(sample.lateness)


class Loop:
    """The control loop of a run.

    Args:
        driver: Open and armed driver.
        watch: Monitors that stop the run.
        cycle: Time between exchanges [s].
        sinks: Sinks that receive every cycle; a failure of the first, the recorder, stops the run.
        head: Function that makes the run's first frame from the first sample.
        stop_request: Function that returns a stop requested by a person, or None.
        signs: Signs that a stop does not work; None if something else moves the arm.
        announcer: Announcer of stops to a person.
    """

    def __init__(
        self,
        driver: Driver,
        watch: Watch,
        cycle: float,
        sinks: Sequence[Sink] = (),
        head: Callable[[Sample], bytes] | None = None,
        stop_request: Callable[[], Stop | None] = lambda: None,
        signs: Signs | None = None,
        announcer: Silent | None = None,
    ) -> None:
        self._driver, self._watch, self._cycle_time = driver, watch, cycle
        self._sinks, self._head, self._signs = [*sinks], head, signs
        self._stop_request = stop_request
        self._player: Player | None = None
        self._check: CommandCheck | None = None
        self._unsent: Command | None = None
        self._stage = -1
        self._lost, self._failures = "", 0
        self._cycles_listened, self._cpu_time, self._cycle_start = 0, 0, 0.0
        self._announcer = announcer or Silent()
        self.counts = Counts()  # statistics of the cycles
        # Why the run ends early, and the stops requested from the driver.
        self.stops = Stops(driver, self.report, self._announcer.say)
        self.last: Sample | None = None  # last sample

    def listen(self, until: Callable[[], bool]) -> None:
        """Receive samples without commanding until a condition holds or there is a reason to stop."""
        while not until() and self.stops.reason is None:
            self._cycle(None)

    def play(self, player: Player, check: CommandCheck, approach: Trajectory) -> None:
        """Command the approach and the motion until they end or a stop has ended; nothing after a stop."""
        if self.stops.reason is not None:
            return
        self._player, self._check = player, check
        player.begin(approach)
        while not self.stops.by_controller and (not player.finished or self._may_still_move()):
            if not self._cycle(self._next_command()):
                return

    def finish(self) -> None:
        """Listen until the arm is at rest: a stop is monitored for as long as the arm may move."""
        while not self._lost and self._may_still_move():
            self._cycle(None)

    def _may_still_move(self) -> bool:
        """Whether to keep listening, since the arm may still move; counts cycles up to `LISTEN_ON`."""
        self._cycles_listened += 1
        if self._cycles_listened > round(LISTEN_ON / self._cycle_time):
            return False
        calm = self.last is None or self._signs is None or self._signs.calm
        return self.stops.by_controller or not calm

    def fail(self, error: BaseException) -> None:
        """Request a quick stop since this program has failed; the loop keeps listening."""
        self.begin_stop(Stop(StopLevel.QUICK, "program failed", f"exidyn failed: {failure_text(error)}"))
        self.report("failure", failure_text(error), {"traceback": "".join(format_exception(error))})

    def lose(self, reason: str) -> None:
        """Note that the arm can no longer be observed, and why."""
        self._lost = self._lost or reason

    def standstill(self) -> Standstill | None:
        """Determine and record whether the arm stands at the end; None if something else moves it."""
        if self._signs is None:
            return None
        reason = self._lost or ("nothing was received" if self.last is None else "")
        standstill = unknown_at_end(reason) if reason else self._signs.at_end()
        self.report("standstill", standstill.text, standstill.details())
        if not standstill.stands:
            self._announcer.say(standstill.text)
        return standstill

    def _next_command(self) -> Command | None:
        """The next command or, if it fails the check, the first command of a stop."""
        assert self._player is not None
        assert self._check is not None
        if self._unsent is not None:
            return self._unsent
        command = self._player.next()
        violation = self._check.look(command) if command is not None else None
        if violation is None:
            return command
        self._player.take_back()
        stopping = self.stops.reason is not None  # if the stop itself fails the check, the controller stops
        self.begin_stop(replace(violation, level=StopLevel.QUICK) if stopping else violation)
        return None if stopping else self._next_command()

    def _cycle(self, command: Command | None) -> bool:
        """Make an exchange, hand it over and check it; return whether there was an answer."""
        self._begin_cycle()
        sample = self._exchange(command)
        if sample is None:
            return False
        if self.last is None and self._head:
            self._hand_over(self._head(sample))
        self.last = sample
        self._unsent = None if sample.sent else command
        command = command if sample.sent else None
        self.counts.add(sample)
        if (stage := self._current_stage()) != self._stage:
            self._stage = stage
            self.report("stage", STAGES[stage])
        self._hand_over(sample_frame(sample, command, self._stage))
        for text in sample.events:
            self.report("driver", text)
        stop = harder(self._stop_request(), self._watch.look(sample, command))
        if self._sinks and (failure := self._sinks[0].failure):
            text = f"the recording cannot continue: {failure}"
            stop = harder(stop, Stop(StopLevel.BRAKE, "recorder", text))
        self.begin_stop(stop)
        if sample.fault:
            self.stops.explain(sample.fault)
        self._escalate(sample, command)
        cpu_time = time.thread_time_ns()
        self.counts.work.append(1e-9 * (cpu_time - (self._cpu_time or cpu_time)))
        self._cpu_time = cpu_time
        return True

    def _begin_cycle(self) -> None:
        """Begin a cycle, and measure the time since the previous cycle began."""
        if not self._driver.in_real_time:
            return
        self._announcer.begin_cycle()
        now = self._driver.clock.monotonic()
        if self._cycle_start:
            self.counts.block = max(self.counts.block, now - self._cycle_start - self._cycle_time)
        self._cycle_start = now

    def _exchange(self, command: Command | None) -> Sample | None:
        """Send a command and return the sample; None if the link is lost or the driver fails."""
        cpu_time = time.thread_time_ns()
        try:
            sample = checked(self._driver.exchange(command))
        except Exception as error:  # whatever it is, the arm may move and has to be stopped
            self._handle_failed_exchange(error)
            return None
        self._failures = 0
        self.counts.driver_work.append(1e-9 * (time.thread_time_ns() - cpu_time))
        return sample

    def _handle_failed_exchange(self, error: Exception) -> None:
        """Request a quick stop, which the controller may still receive."""
        lost = isinstance(error, DriverError)
        self._failures += 1
        text = str(error) if lost else f"the driver failed: {failure_text(error)}"
        if lost or self._failures >= FAILURES:
            self.lose(text)
        stop = Stop(StopLevel.QUICK, "link lost" if lost else "driver failed", text)
        if not self.begin_stop(stop) and lost:
            unknown = f"whether the stop works is no longer known: {text}"
            self._announcer.say(unknown)
            self.report("driver", unknown)

    def begin_stop(self, stop: Stop | None) -> bool:
        """Stop for a reason unless an equally hard stop is under way; return whether a stop has begun."""
        if stop is None or not self.stops.begin(stop):
            return False
        self._cycles_listened = 0
        if self._player is not None and not self.stops.by_controller:
            self._player.brake()
        return True

    def _escalate(self, sample: Sample, command: Command | None) -> None:
        """Stop harder if the stop under way does not work."""
        if self._signs is None:
            return
        state = state_of(self.stops.level, self._stage)
        stop = escalate(state, self._signs.look(sample, command, state))
        if stop is not None:
            self.stops.escalate(stop)
            self._cycles_listened = 0

    def report(self, kind: str, text: str, details: dict[str, object] | None = None) -> None:
        """Hand over an event at the time of the last sample; events before the first sample are dropped."""
        if self.last is None:
            return
        host, controller = self.last.host_time, self.last.controller_time
        self._hand_over(event_frame(Event(host, controller, kind, text, details or {})))

    def _current_stage(self) -> int:
        """Index of the current stage; a quick stop is not visible to the player."""
        if self._player is None:
            return LISTENING
        return BRAKING if self.stops.by_controller else self._player.stage

    def _hand_over(self, frame: bytes) -> None:
        for place, sink in enumerate(self._sinks):
            try:
                sink.put(frame)
            except Exception as error:  # none should; the loop continues without this sink
                self._sinks[place] = Nobody(failure_text(error))


def failure_text(error: BaseException) -> str:
    """Description of an error of this program, with its file and line."""
    rows = extract_tb(error.__traceback__)
    place = f" ({Path(rows[-1].filename).name}:{rows[-1].lineno})" if rows else ""
    return f"{type(error).__name__}: {error}{place}"


def percentiles(name: str, values: Sequence[float]) -> dict[str, float]:
    """Median, 99th percentile and maximum as `name_p50`, `name_p99` and `name_max`; empty without values."""
    if not values:
        return {}
    p50, p99 = np.percentile(values, [50, 99])
    return {f"{name}_p50": float(p50), f"{name}_p99": float(p99), f"{name}_max": max(values)}
