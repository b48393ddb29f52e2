"""Common part of drivers on a CAN bus: the host keeps the clock and queries all joints once per cycle.

There is no thread. Frames that are not understood are ignored.
"""

from abc import ABC, abstractmethod
from typing import Any, Generic, TypeVar

import numpy as np

from ..driver import Arm, Driver, StopLevel
from ..errors import LinkLost, NotReady
from ..host_clock import AnswerTime, HostClock, Pause, Tick, require_patience
from ..samples import HostSamples
from ..values import Command, Sample
from .answers import Answers
from .can_bus import CanBus
from .transports import STANDARD, Frame

MOST_EVENTS = 50
"""Maximum number of events kept for one sample."""
MOST = 500
"""Maximum number of frames read before a question and after its cycle: more are a flood, and can wait."""
FORGET = 0.1
"""Maximum time for discarding unread frames [s]."""


class CanRound(ABC):
    """A question to all joints and their answers, once per cycle; joints that `may_skip` can be left out."""

    def __init__(self, bus: CanBus, names: list[str], may_skip: bool) -> None:
        self._bus, self._names, self._clock = bus, names, bus.clock
        self._answers = Answers(names, self.report, may_skip, bus.clock)
        self.target: list[Any] = []  # commanded position of each joint, in the unit of its drive
        self.fault = ""  # first reason why the arm can no longer be commanded; empty while it can
        self.received = self._clock.monotonic()  # time of the last answer of any joint [s]
        self._answer_time = AnswerTime(bus.clock)
        self._events: list[str] = []
        self._data = b""

    @property
    def fresh(self) -> list[bool]:
        """Whether each joint answered the last question."""
        return self._answers.fresh

    @abstractmethod
    def cycle(self, patience: float) -> int:
        """Ask all joints, wait `patience` [s] for answers, and return when they measured [ns since 1970]."""

    @abstractmethod
    def _understand(self, identifier: int, data: bytes) -> bool:
        """Handle a frame with an 11-bit identifier; returns whether it came from a joint."""

    @abstractmethod
    def _commanded_by(self, identifier: int) -> str:
        """Content of a command frame with this identifier that only this program may send; else empty."""

    def begin(self) -> None:
        """Discard unread frames and earlier faults."""
        self._answers.begin()
        end = self._clock.monotonic() + FORGET
        while self._bus.receive(0.0) is not None and self._clock.monotonic() < end:
            pass
        self.fault = self._bus.trouble
        self.received = self._clock.monotonic()

    def fail(self, why: str) -> None:
        """Record why the arm can no longer be commanded; all reasons are reported, the first is kept."""
        self.fault = self.fault or why
        self.report(why)

    def report(self, text: str) -> None:
        """Keep an event for the next sample."""
        if len(self._events) < MOST_EVENTS:
            self._events.append(text)

    def events(self) -> tuple[str, ...]:
        """Events since the last call."""
        events, self._events = tuple(self._events), []
        return events

    def _ask(self) -> list[bool]:
        """Read late frames and begin the next cycle; returns which joints are to be asked."""
        for _ in range(MOST):
            unreadable, received = self._bus.unreadable, self._bus.receive(0.0)
            if received is not None:
                self._read(received)
            elif self._bus.unreadable == unreadable:
                break
        return self._answers.ask()

    def _collect(self, end: float) -> None:
        """Read until all joints have answered or the time is up; frames already there are always read."""
        self._answer_time.sleep()
        waited, read = False, 0
        while self._answers.waiting and (read < MOST or self._clock.monotonic() < end):
            received, read = self._bus.receive(0.0), read + 1
            if received is None:
                waited, remaining = True, end - self._clock.monotonic()
                received = self._bus.receive(max(remaining, 0.0))
                if received is None and (remaining <= 0.0 or self._bus.trouble):
                    break
            if received is not None:
                self._read(received)
        else:
            self._answer_time.adjust(waited)
        self._answers.end()
        for text in self._bus.events():
            self.report(text)
        if self._bus.trouble and not self.fault:
            self.fail(self._bus.trouble)

    def _answered(self, joint: int) -> None:
        """Count the current frame as the end of a joint's answer."""
        self._answers.take(joint, self._data)

    def _read(self, received: Frame) -> None:
        identifier, self._data = received
        if identifier > STANDARD:
            return
        if self._understand(identifier, self._data):
            self.received = self._clock.monotonic()
        elif not self.fault and (content := self._commanded_by(identifier)):
            self.fail(
                f"another program sends {content} (identifier 0x{identifier:03X}) on this bus: two programs "
                "that command one arm disturb each other. End the other program"
            )


PATIENCE = 0.85
"""Fraction of a cycle spent waiting for answers [-]."""
RESTING = 2.0
"""Maximum duration of a quick stop before the bus is released in any case [s]."""
AT_REST = 1e-3
"""Largest motion in ten cycles of a joint at rest [rad]."""
RUNNING_ON = 0.5
"""Time for which joints are then observed, to see whether one keeps moving [s]."""
FEWEST = 3
"""Minimum patience of drives [cycles]: in two, this computer may have nothing to send."""
RUNS_ON = 0.2
"""Motion in that time that proves a moving joint [rad]: two seconds after a stop, no arm swings this far."""
SILENCE = 1.0
"""Time without any frame of any joint after which the link is lost [s]."""

Round = TypeVar("Round", bound=CanRound)


class CanDriver(Driver, Generic[Round]):
    """A driver whose joints answer once per cycle on a CAN bus."""

    def __init__(self, settings: Any, arm: Arm) -> None:
        super().__init__(settings, arm)
        self._patience = PATIENCE * settings.cycle
        self._bus: CanBus | None = None
        self._round: Round | None = None
        self._clock: HostClock | None = None
        self._armed = False
        self._level = 0
        self._samples = HostSamples(arm.dof)
        self._pause = Pause(self._host_patience, self.clock)
        require_patience("dead_man", self._host_patience, settings.cycle, FEWEST)

    @property
    def _host_patience(self) -> float:
        """Silence of this computer after which drives stop by themselves [s]; infinite if they do not."""
        patience: float = self.settings.dead_man
        return patience

    @abstractmethod
    def _set_target(self, talk: Round, command: Command) -> None:
        """Make a command the next target."""

    @abstractmethod
    def _check_answers(self, talk: Round) -> None:
        """Check the answers for faults, while joints are commanded and not stopped."""

    @abstractmethod
    def _measured(self, talk: Round) -> dict[str, np.ndarray]:
        """Measured signals in the units of `Sample`, each of shape (n,)."""

    @abstractmethod
    def _position(self, talk: Round) -> np.ndarray:
        """Position that the joints last sent, shape (n,) [rad]."""

    @abstractmethod
    def _stopped(self, talk: Round) -> bool:
        """Whether all joints have accepted a quick stop, moving or not."""

    @abstractmethod
    def _detach(self, talk: Round) -> None:
        """Make the joints no longer expect frames from the host."""

    def exchange(self, command: Command | None) -> Sample:
        """Send a command, or the last one again, and return the answers of the same cycle."""
        talk = self._opened()
        if self._clock is None:
            self._begin(talk)
        tick = self._tick()
        commanding, before = self._armed and not self._level, talk.target
        if command is not None and commanding:
            self._set_target(talk, command)
        paused, measured_at = self._pause.count, self._run_cycle(talk, before)
        if commanding and not talk.fault:
            self._check_answers(talk)
        if self.clock.monotonic() - talk.received > SILENCE:
            raise LinkLost(
                f"nothing was received from any joint on the CAN bus for {SILENCE:g} s. Check power and cable"
            )
        events, measured = talk.events(), self._measured(talk)
        sent = command is None or self._pause.count == paused
        return self._samples.of(
            measured_at, tick, talk.fresh, events=events, fault=talk.fault, sent=sent, **measured
        )

    def close(self) -> None:
        """Stop quickly, wait until the arm is at rest, then hold it or switch it off as `at_close` says."""
        try:
            if self._round is not None:
                if self._bus is not None:  # a stop enables nothing, and must not be held back
                    self._bus.watch_for(Pause(float("inf")))
                if self._armed:
                    self._come_to_rest(self._round)
                self._detach(self._round)
        except Exception:  # closing never raises
            pass
        finally:
            if self._bus is not None:
                self._bus.shutdown()
            self._bus = self._round = self._clock = None
            self._armed = False

    def _opened(self) -> Round:
        if self._round is None:
            raise NotReady("the driver is not open yet, or not any more")
        return self._round

    def _open_bus(self) -> CanBus:
        s = self.settings
        self._bus = CanBus(s.interface, s.channel, s.bitrate, s.options, self.clock)
        return self._bus

    def _begin(self, talk: Round) -> None:
        self._clock = HostClock(self.settings.cycle, self.clock)
        talk.begin()

    def _begin_commands(self, talk: Round) -> None:
        """Begin; from now on, nothing is sent right after a pause of this computer."""
        assert self._bus is not None
        self._begin(talk)
        self._pause.begin()
        self._bus.watch_for(self._pause)

    def _run_cycle(self, talk: Round, before: list[Any] | None = None) -> int:
        """Run a cycle of the bus, as `CanRound.cycle`; after a pause of this computer, stop quickly.

        `before` contains the targets of the last cycle, which the stop holds.
        """
        paused, measured_at = self._pause.count, talk.cycle(self._patience)
        if self._pause.count == paused:
            return measured_at
        talk.received = self.clock.monotonic()  # nothing was asked
        if self._armed and not self._level:
            talk.target = talk.target if before is None else before
            talk.fault = ""  # faults that drives report now are consequences of the pause
            talk.fail(self._pause.text())
            self.stop(StopLevel.QUICK)
        return measured_at

    def _tick(self) -> Tick:
        assert self._clock is not None
        return self._clock.wait()

    def _cycles(self, talk: Round, count: int) -> None:
        for _ in range(count):
            self._tick()
            self._run_cycle(talk)

    def _come_to_rest(self, talk: Round) -> None:
        """Stop quickly, wait until all joints rest or none answers, and switch off if requested."""
        self.stop(StopLevel.QUICK)
        end, resting = self.clock.monotonic() + RESTING, False
        while not resting and self.clock.monotonic() < end:
            before = self._position(talk)
            self._cycles(talk, 10)
            moved = np.abs(self._position(talk) - before)
            resting = self._stopped(talk) and bool((moved < AT_REST).all())
            if not any(talk.fresh):
                break
        if self.settings.at_close == "off" or (not resting and self._runs_on(talk)):
            self.stop(StopLevel.OFF)
            self._cycles(talk, 10)

    def _runs_on(self, talk: Round) -> bool:
        """Whether a joint still moves after a quick stop, and no drive reports that it switched itself off.

        Detaching then would leave a moving arm without the dead-man function that stops it.
        """
        if talk.fault:
            return False
        before = self._position(talk)
        self._cycles(talk, round(RUNNING_ON / self.settings.cycle))
        return bool(np.any(np.abs(self._position(talk) - before) > RUNS_ON))
