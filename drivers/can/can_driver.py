"""What drivers on a CAN bus have in common: the host owns the clock, asks once a cycle, parts politely."""

import time
from abc import abstractmethod
from typing import Any, Generic, TypeVar

import numpy as np

from ..driver import SIGNALS, Arm, Command, Driver, Sample, StopLevel
from ..errors import LinkLost, NotReady
from ..host_clock import HostClock, Tick
from .can_bus import CanBus
from .can_round import CanRound

PATIENCE = 0.85
"""Share of a cycle for which answers are waited for [-]."""
RESTING = 2.0
"""How long a quick stop may take before the bus is let go all the same [s]."""
AT_REST = 1e-3
"""A joint that moves less than this in ten cycles is at rest [rad]."""
RUNNING_ON = 0.5
"""How long is looked then whether a joint runs [s]."""
RUNS_ON = 0.2
"""Way in that time that no arm on springs swings [rad], two seconds after it was stopped."""
SILENCE = 1.0
"""Without any frame of any joint for so long, the link is lost [s]."""

Round = TypeVar("Round", bound=CanRound)


class CanDriver(Driver, Generic[Round]):
    """A driver whose joints answer once a cycle on a CAN bus.

    Args:
        settings: With interface, channel, bitrate, options, cycle and at_close.
        arm: What it needs to know of the arm.
    """

    def __init__(self, settings: Any, arm: Arm) -> None:
        super().__init__(settings, arm)
        self._patience = PATIENCE * settings.cycle
        self._bus: CanBus | None = None
        self._round: Round | None = None
        self._clock: HostClock | None = None
        self._armed = False
        self._level = 0
        self._unknown, self._none_stale = np.full(arm.dof, np.nan), np.zeros(arm.dof, bool)
        self._none_stale.setflags(write=False)  # samples share it

    @abstractmethod
    def _aim(self, talk: Round, command: Command) -> None:
        """Make a command the next target."""

    @abstractmethod
    def _look(self, talk: Round) -> None:
        """Look at what was answered, while joints are commanded and there was no stop."""

    @abstractmethod
    def _sample(self, talk: Round, tick: Tick, sent: int) -> Sample:
        """What was answered, in our units."""

    def _answered(self, talk: Round, tick: Tick, sent: int, **values: np.ndarray) -> Sample:
        """A sample of what is known, by name and each (n,); NaN for all else and for stale joints."""
        stale = self._none_stale
        if not all(talk.fresh):
            stale = ~np.array(talk.fresh)
            values = {name: np.where(stale, np.nan, value) for name, value in values.items()}
        known: dict[str, Any] = {name: values.get(name, self._unknown) for name in SIGNALS}
        return Sample(
            sent,
            sent,
            **known,
            lateness=tick.lateness,
            skipped=tick.skipped,
            stale=stale,
            events=talk.events(),
            fault=talk.fault,
        )

    @abstractmethod
    def _position(self, talk: Round) -> np.ndarray:
        """Position that the joints last sent, shape (n,) [rad]."""

    @abstractmethod
    def _stopped(self, talk: Round) -> bool:
        """Whether all joints have taken a quick stop for one, moving or not."""

    @abstractmethod
    def _part(self, talk: Round) -> None:
        """Leave joints that no longer miss the host."""

    def exchange(self, command: Command | None) -> Sample:
        """As in `Driver`: a command, or the last one again, and what is answered in the same cycle."""
        talk = self._opened()
        if self._clock is None:
            self._begin(talk)
        tick = self._tick()
        commanding = self._armed and not self._level
        if command is not None and commanding:
            self._aim(talk, command)
        sent = talk.cycle(self._patience)
        if commanding and not talk.fault:
            self._look(talk)
        if time.monotonic() - talk.received > SILENCE:
            raise LinkLost(
                f"nothing was received from any joint on the CAN bus for {SILENCE:g} s. Check power and cable"
            )
        return self._sample(talk, tick, sent)

    def close(self) -> None:
        """As in `Driver`: quick stop until at rest, then held or switched off by `at_close`."""
        try:
            if self._round is not None:
                if self._armed:
                    self._come_to_rest(self._round)
                self._part(self._round)
        except Exception:  # nothing that goes wrong now is of use to anybody
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
        self._bus = CanBus(s.interface, s.channel, s.bitrate, s.options)
        return self._bus

    def _begin(self, talk: Round) -> None:
        """Begin to exchange, after a pause."""
        self._clock = HostClock(self.settings.cycle)
        talk.begin()

    def _tick(self) -> Tick:
        assert self._clock is not None
        return self._clock.wait()

    def _cycles(self, talk: Round, count: int) -> None:
        for _ in range(count):
            self._tick()
            talk.cycle(self._patience)

    def _come_to_rest(self, talk: Round) -> None:
        """Quick stop, wait until all joints rest or there is no use in waiting, and switch off if wanted."""
        self.stop(StopLevel.QUICK)
        end, resting = time.monotonic() + RESTING, False
        while not resting and time.monotonic() < end:
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
        """Whether a quick stop has not stopped a joint, and no drive reports that it let go by itself.

        To leave then would leave an arm that runs, and take from it what stops it when the host is silent.
        """
        if talk.fault:
            return False
        before = self._position(talk)
        self._cycles(talk, round(RUNNING_ON / self.settings.cycle))
        return bool(np.any(np.abs(self._position(talk) - before) > RUNS_ON))
