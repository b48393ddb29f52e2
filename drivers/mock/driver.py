"""Mock: a simulated arm with drives, encoders and noise, on its own clock or that of the host.

The arm follows each command one cycle later, as drives on a bus do. Each cycle is simulated before the driver
waits for its deadline, so that a sample comes back as quickly as from hardware.
"""

from copy import deepcopy
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..driver import Arm, Driver, Info, Measured, StopLevel
from ..errors import BadSettings, LinkLost, NotReady
from ..host_clock import HostClock, Tick
from ..settings import setting
from ..values import Command, Sample
from .drives import MockDrives
from .faults import START, Reply, read_faults

EPOCH = 1_767_225_600_000_000_000
"""Host time at which a simulation begins [ns since 1970]: the year 2026."""


class SteppedClock:
    """A clock like `HostClock` that does not wait: its time advances with each call."""

    def __init__(self, cycle: float) -> None:
        self._cycle = round(cycle * 1e9)
        self._now, self._number = 0, -1

    def wait(self) -> Tick:
        due = (self._number + 1) * self._cycle
        late = max(self._now - due, 0)
        skipped = late // self._cycle
        self._number += 1 + skipped
        self._now = max(self._now, due)
        return Tick(self._number, (late - skipped * self._cycle) * 1e-9, skipped)

    def sleep(self, seconds: float) -> None:
        self._now += round(seconds * 1e9)

    @property
    def host_time(self) -> int:
        return EPOCH + self._now


class RealClock(HostClock):
    """The host's clock, for a mock that runs in real time."""

    def sleep(self, seconds: float) -> None:
        self._clock.sleep(seconds)

    @property
    def host_time(self) -> int:
        return self._clock.host_time()


SIGNALS = ("position", "velocity", "current", "temperature")
"""Signals that the mock can measure."""


@dataclass(frozen=True)
class MockSettings:
    """Settings of the simulated controller."""

    cycle: float = setting(0.002, "time between commands", unit="s", low=0.0005, high=0.1)
    clock: str = setting(
        "stepped",
        "stepped: a cycle takes as long as its computation; real: its nominal time",
        choices=("stepped", "real"),
    )
    silent: str = setting("", f"signals not measured, separated by commas: any of {', '.join(SIGNALS[1:])}")
    window: tuple[float, ...] = setting(
        0.0, "largest distance from the initial position; 0 for no limit", unit="rad", low=0.0, high=100.0
    )
    deceleration: tuple[float, ...] = setting(
        10.0, "deceleration of drives that stop by themselves", unit="rad/s^2", low=0.1, high=1e3
    )
    dead_man: float = setting(
        0.2, "time without a command after which drives stop by themselves", unit="s", low=0.002, high=10.0
    )
    faults: str = setting("", "faults to inject, such as 'drop at 2 for 0.1; stall 0.1 at 3'")


class Mock(Driver):
    """A simulated arm."""

    Settings = MockSettings
    simulated: ClassVar[bool] = True

    def __init__(self, settings: MockSettings, arm: Arm) -> None:
        super().__init__(settings, arm)
        silent = {name.strip() for name in settings.silent.split(",")} - {""}
        wrong = silent - set(SIGNALS[1:])
        if wrong:
            raise BadSettings(
                f"driver mock: silent: no signal '{sorted(wrong)[0]}'. Valid: {', '.join(SIGNALS[1:])}"
            )
        self._signals = tuple(name for name in SIGNALS if name not in silent)
        self._faults = read_faults(settings.faults, arm.joints)
        self._window = np.where(np.array(settings.window) > 0.0, settings.window, np.inf)
        self._nothing = np.full(arm.dof, np.nan)
        self._fresh = np.zeros(arm.dof, bool)
        self._began: int | None = None
        self._time = START - 1.0
        self._drives: MockDrives | None = None

    @property
    def in_real_time(self) -> bool:
        return bool(self.settings.clock == "real")

    def open(self) -> Info:
        settings = self.settings
        if self.arm.plant is None:
            raise BadSettings("driver mock: there is no arm to simulate; name a robot")
        deceleration = np.array(settings.deceleration)
        self._drives = MockDrives(self.arm.plant(), settings.cycle, deceleration, settings.dead_man)
        for fault in self._faults:
            fault.kind.prepare(fault, self._drives)
        self._stood = np.array(self._drives.measure().position)
        self._clock = (
            RealClock(settings.cycle, self.clock) if self.in_real_time else SteppedClock(settings.cycle)
        )
        bounded = bool(np.any(np.isfinite(self._window)))
        return Info(
            cycle=settings.cycle,
            clock="host",
            signals=self._signals,
            dead_man=f"the drives stop by themselves after {settings.dead_man:g} s without a command",
            window_lower=-self._window if bounded else None,
            window_upper=self._window if bounded else None,
            settings={"clock": settings.clock, "faults": settings.faults},
            warnings=(f"faults are injected: {settings.faults}",) if self._faults else (),
        )

    def states(self) -> tuple[str, ...]:
        stopped = self._drives is not None and self._drives.stopped
        return ("simulated, stopped" if stopped else "simulated",) * self.arm.dof

    def exchange(self, command: Command | None) -> Sample:
        drives = self._drives
        if drives is None:
            raise NotReady("driver mock: not open")
        drives.step()
        tick = self._clock.wait()
        if tick.skipped and self._began is not None:  # before the first command, no cycle is missed
            drives.idle(tick.skipped)
        if self._began is None and command is not None:
            self._began = tick.number
        reply = self._reply(drives, drives.measure(), tick.number)
        host_time = self._clock.host_time
        if reply.late:
            self._clock.sleep(reply.late)
            host_time = self._clock.host_time
        if reply.lost:
            raise LinkLost(f"driver mock: {reply.lost}")
        self._take(drives, command)
        return Sample(
            host_time,
            round(tick.number * self.settings.cycle * 1e9),
            reply.position,
            reply.velocity,
            reply.current,
            self._nothing,
            reply.temperature,
            tick.lateness + reply.late,
            tick.skipped,
            reply.stale,
            tuple(reply.events),
            drives.fault,
        )

    def stop(self, level: StopLevel) -> None:
        """Stop as in `Driver`. Unlike real drivers, this raises if the fault "stop fails" is injected."""
        drives = self._drives
        if drives is None:
            return
        if level <= drives.refused:
            raise LinkLost(f"driver mock: {level.name} was not sent to the drives, as this fault demands")
        if level == StopLevel.QUICK and not drives.deaf:
            drives.stop()
        elif level == StopLevel.OFF:
            drives.release()

    def close(self) -> None:
        self._drives = None

    def _reply(self, drives: MockDrives, measured: Measured, number: int) -> Reply:
        """Reply of this cycle, with the injected faults."""
        position, velocity, current, temperature = (
            getattr(measured, name) if name in self._signals else self._nothing for name in SIGNALS
        )
        reply = Reply(position, velocity, current, temperature, self._fresh)
        if self._faults:
            before = self._time
            self._time = START if self._began is None else (number - self._began) * self.settings.cycle
            reply = deepcopy(reply)
            for fault in self._faults:
                if fault.acts(before, self._time):
                    fault.kind.act(fault, reply, drives)
        return reply

    def _take(self, drives: MockDrives, command: Command | None) -> None:
        """Pass a command on to the drives, which trip if it is outside the window."""
        if command is None:
            drives.hold()
            return
        away = np.abs(command.position - self._stood)
        if (away > self._window).any():
            joint = int(np.argmax(away - self._window))
            drives.trip(
                f"{self.arm.joints[joint]}: commanded {away[joint]:.4f} rad from its initial position, limit "
                f"{self._window[joint]:.4f}"
            )
        drives.command(command.position, command.velocity)
