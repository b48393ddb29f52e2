"""The only loop: exchange, hand over, look, command.

It runs from before the first command until after the last stop, and hands over every cycle on the way.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from exidyn.drivers import Command, Driver, DriverError, Sample, StopLevel
from exidyn.trajectories.trajectory import Trajectory

from .pipe.frames import STAGES, Event, event_frame, sample_frame
from .pipe.pipe_sink import Sink
from .player import BRAKING, LISTENING, Player
from .stopping.command_check import CommandCheck
from .stopping.escalation import escalate, state_of
from .stopping.signs import Signs
from .stopping.stop import Stop, harder
from .stopping.stops import Stops
from .stopping.watch import Watch

LISTEN_ON = 2.0
"""How long is listened after each stop that is left to the controller, which takes its own time, and at most
after the last command [s]."""


@dataclass
class Counts:
    """What happened to the cycles of a run.

    Attributes:
        cycles: Exchanges made.
        skipped: Cycles that went by without one.
        stale: Samples in which a joint was silent.
        lateness: Of each exchange [s].
    """

    cycles: int = 0
    skipped: int = 0
    stale: int = 0
    lateness: list[float] = field(default_factory=list)

    def add(self, sample: Sample) -> None:
        """Count one sample."""
        self.cycles += 1
        self.skipped += sample.skipped
        self.stale += bool(sample.stale.any())
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
    ) -> None:
        self._driver, self._watch, self._cycle_time = driver, watch, cycle
        self._sinks, self._head, self._asked, self._signs = sinks, head, asked, signs
        self._player: Player | None = None
        self._check: CommandCheck | None = None
        self._unsent: Command | None = None
        self._stage = -1
        self._lost = False
        self._listened = 0
        self.counts = Counts()
        self.stops = Stops(driver, self.report)
        self.last: Sample | None = None

    @property
    def stop(self) -> Stop | None:
        """Why the run ends before its time; None as long as it does not."""
        return self.stops.reason

    def listen(self, until: Callable[[], bool]) -> None:
        """Exchange nothing but samples until something is so, or there is a reason to stop."""
        while not until() and self.stop is None:
            self._cycle(None)

    def play(self, player: Player, check: CommandCheck, way: Trajectory) -> None:
        """Command the way to a motion and the motion, to its end or to a stop; nothing after a stop."""
        if self.stop is not None:
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

    def end(self, stop: Stop) -> None:
        """Stop for a reason found elsewhere."""
        self._to_stop(stop)

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
        again = self.stop is not None  # a stop that is itself not in order is left to the controller
        self._to_stop(replace(wrong, level=StopLevel.QUICK) if again else wrong)
        return None if again else self._next()

    def _cycle(self, command: Command | None) -> bool:
        """One exchange, handed over and looked at; whether there is an answer."""
        try:
            sample = self._driver.exchange(command)
        except DriverError as error:
            self._lost = True
            if not self._to_stop(Stop(StopLevel.QUICK, "link lost", str(error))):
                self.report("driver", f"whether the stop works is no longer known: {error}")
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
        self._to_stop(harder(self._asked(), harder(self._watch.look(sample, command), self._recording())))
        self._escalate(sample, command)
        return True

    def _recording(self) -> Stop | None:
        failure = self._sinks[0].failure if self._sinks else ""
        return (
            Stop(StopLevel.BRAKE, "recorder", f"the recording cannot go on: {failure}") if failure else None
        )

    def _to_stop(self, found: Stop | None) -> bool:
        """Begin a stop, unless one as hard is under way; whether it is begun."""
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
        for sink in self._sinks:
            sink.put(frame)


def lateness(counts: Counts) -> dict[str, float]:
    """Median, 99th percentile and largest lateness [s]."""
    if not counts.lateness:
        return {}
    p50, p99 = np.percentile(counts.lateness, [50, 99])
    return {"lateness_p50": float(p50), "lateness_p99": float(p99), "lateness_max": max(counts.lateness)}
