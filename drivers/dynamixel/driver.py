"""Dynamixel servos with protocol 2.0 (X series, MX with firmware 2.0) on a serial port.

Each cycle is one write: the goals of all servos, and the question for current, velocity and position of all.
Each servo has a bus watchdog: if nothing arrives for a while, it stops, holds, and ignores goals until reset.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..driver import Arm, Info, StopLevel
from ..errors import NotReady
from ..servo.servo_bus import LENGTHS, TRIES, ServoBus
from ..servo.servo_driver import ServoDriver
from ..servo.servo_line import Codec, Goals, Measured, Reading, ServoSettings, Status
from ..settings import setting
from . import packet as packets
from . import registers
from .registers import (
    MEASURED,
    TRIPPED,
    WARM,
    DynamixelHealth,
    ServoData,
    current_units,
    joins_answers,
    model_name,
    require_healthy,
    stops_in_silence,
)

WARM_EVERY = 100
"""Number of cycles between two readings of the temperatures."""


@dataclass(frozen=True)
class DynamixelSettings(ServoSettings):
    """Settings of an arm of Dynamixel servos."""

    operating_mode: str = setting("position", "operating mode of the servos", choices=tuple(registers.MODES))
    current_unit: tuple[float, ...] = setting(
        0.0, "current per count; 0 looks it up by model", unit="A", low=0.0, high=1.0
    )
    fast_sync_read: str = setting(
        "auto", "whether all servos answer in one packet, which is shorter", choices=("auto", "on", "off")
    )
    watchdog: float = setting(
        0.1, "silence after which servos stop by themselves; 0 disables it", unit="s", low=0.0, high=2.54
    )


class Dynamixel(ServoDriver):
    """Dynamixel servos, protocol 2.0."""

    Settings = DynamixelSettings
    codec: ClassVar[Codec] = packets
    baudrates, joining = registers.BAUDRATES, ", servos that know the fast sync read"
    torque, goal, present = registers.TORQUE, registers.GOAL, registers.PRESENT
    return_delay = registers.RETURN_DELAY

    def __init__(self, settings: DynamixelSettings, arm: Arm) -> None:
        self._joined = settings.fast_sync_read != "off"
        self._watchdog = int(np.ceil(settings.watchdog / registers.WATCHDOG_UNIT - 1e-9))
        super().__init__(settings, arm)

    def _set_up(self, bus: ServoBus) -> Info:
        settings, warnings = self.settings, list[str]()
        answers = bus.find(settings.baudrate, registers.BAUDRATES)
        servos = [ServoData(int.from_bytes(data[:2], "little"), data[2]) for data in answers]
        bus.set_checked(registers.STATUS_LEVEL, [2] * self.arm.dof)
        self._reset_watchdog(bus, warnings)
        self._shutdown = bus.read(registers.SHUTDOWN)
        require_healthy(bus, self._shutdown)
        self._require_mode(bus)
        self._set_return_delay(bus)
        for register in (registers.PROFILE_ACCELERATION, registers.PROFILE_VELOCITY):
            bus.set_checked(register, [0] * self.arm.dof)  # else each servo would smooth the motion by itself
        self._current_unit = current_units(bus, servos, settings.current_unit)
        self._ampere = np.where(self._current_unit > 0.0, self._current_unit, np.nan)
        self._allowed = self._goals_allowed(bus)
        self._choose_reading(bus, servos)
        warnings += self._warnings(bus, servos)
        return self._info(
            bus, self._signals(), warnings, self._dead_man(servos), **self._identities(bus, servos)
        )

    def _require_mode(self, bus: ServoBus) -> None:
        name, register = self.settings.operating_mode, registers.MODE
        modes = ", ".join(f"{word} is {number}" for word, number in registers.MODES.items())
        advice = (
            f"({name}). Set its register {register.address} with DYNAMIXEL Wizard, or try another "
            f"operating_mode: {modes}"
        )
        bus.require(register, registers.MODES[name], advice)

    def _reset_watchdog(self, bus: ServoBus, warnings: list[str]) -> None:
        """Check that the watchdog takes its value, and leave it off until the drives are armed."""
        tripped = [
            bus.names[s]
            for s, value in zip(bus.servos, bus.read(registers.WATCHDOG), strict=True)
            if value == TRIPPED
        ]
        if tripped:
            warnings.append(f"the bus watchdog had stopped {', '.join(tripped)} before; it was reset")
        self._guard(bus)
        self._unguard(bus)

    def _choose_reading(self, bus: ServoBus, servos: Sequence[ServoData]) -> None:
        """Decide whether servos join their answers, and whether there is time for temperatures."""
        choice = self.settings.fast_sync_read
        self._joined = choice == "on" or (choice == "auto" and all(joins_answers(*s) for s in servos))
        if self._joined and not _all_answer(bus, self._ask(MEASURED.itemsize)):
            if choice == "on":
                raise NotReady(
                    "the servos do not answer a fast sync read; X430 and X540 know it from firmware 45, X330 "
                    'from 46. Try fast_sync_read = "auto", or new firmware'
                )
            self._joined = False
        longest = self._traffic(self._ask(WARM.itemsize)).shortest_cycle(self.settings.baudrate)
        self._cool, self._warm = (
            [self._ask(record.itemsize, more) for more in range(LENGTHS)] for record in (MEASURED, WARM)
        )
        self._has_time = longest <= self.settings.cycle

    def _signals(self) -> tuple[str, ...]:
        current = ["current"] * bool(np.any(self._current_unit))
        return ("position", "velocity", *current, *["temperature"] * self._has_time)

    def _dead_man(self, servos: Sequence[ServoData]) -> str:
        if not self._watchdog or not all(stops_in_silence(*servo) for servo in servos):
            return ""
        seconds = self._watchdog * registers.WATCHDOG_UNIT
        return f"bus watchdog: servos stop and hold after {seconds:g} s of silence"

    def _warnings(self, bus: ServoBus, servos: Sequence[ServoData]) -> Iterator[str]:
        if not np.all(self._current_unit):
            yield "some servos measure no current; only [drive] servo_gain identifies their joints"
        if not self._watchdog:
            yield "without bus watchdog, servos keep moving to their last goal if this computer falls silent"
        unstopped = [
            bus.names[s] for s, servo in zip(bus.servos, servos, strict=True) if not stops_in_silence(*servo)
        ]
        if self._watchdog and unstopped:
            yield (
                f"the bus watchdog of {', '.join(unstopped)} may trip without stopping the servo, as was "
                "reported of its firmware. Try firmware 52 or newer, and unplug the cable once to test it"
            )
        if any(bus.read(registers.HOMING)) and self.settings.operating_mode != "position":
            yield (
                "servos have homing offsets, with which some firmware moves when its bus watchdog stops it. "
                "Try homing offsets of 0, and `zero` in the settings instead"
            )

    def _identities(self, bus: ServoBus, servos: Sequence[ServoData]) -> dict[str, str]:
        texts = (
            f"{servo} {model_name(servo_data.model)} firmware {servo_data.firmware}"
            for servo, servo_data in zip(bus.servos, servos, strict=True)
        )
        return {
            "servos": ", ".join(texts),
            "current_unit": " ".join(f"{unit:g}" for unit in self._current_unit),
            "fast_sync_read": "on" if self._joined else "off",
        }

    def _goals_allowed(self, bus: ServoBus) -> Goals:
        if self.settings.operating_mode == "position":
            return Goals(np.array(bus.read(registers.LOWEST)), np.array(bus.read(registers.HIGHEST)))
        furthest = np.full(self.arm.dof, registers.FURTHEST)
        return Goals(-furthest, furthest)

    def _ask(self, length: int, more: int = 0) -> Reading:
        """Question for the measurements, with `more` bytes before them.

        Servos have no registers after the temperature, and refuse to read there.
        """
        ask = packets.fast_sync_read if self._joined else packets.sync_read
        return ask(registers.FIRST - more, length + more, self.settings.ids)

    def _question(self) -> Reading:
        return self._ask(MEASURED.itemsize)

    def _readings(self, number: int) -> Sequence[Reading]:
        return self._warm if self._has_time and number % WARM_EVERY == 0 else self._cool

    def _decode(self, data: bytes, length: int) -> Measured:
        warm = length == WARM.itemsize
        rows = np.frombuffer(data, WARM if warm else MEASURED)
        temperature = rows["temperature"].astype(float) if warm else self._samples.unknown
        return Measured(
            rows["position"].astype(float),
            rows["velocity"] * registers.VELOCITY_UNIT,
            rows["current"] * self._ampere,
            temperature,
        )

    @property
    def patience(self) -> float:
        return self._watchdog * registers.WATCHDOG_UNIT or float("inf")

    def _begin(self) -> None:
        super()._begin()
        self._health = DynamixelHealth(self._opened(), self._shutdown, self.clock.host_time())

    def _find_fault(self, answers: Sequence[Status | None], now: int, events: list[str]) -> str:
        return self._health.look(answers, now, self._armed and self._stopped < StopLevel.OFF, events)

    def _guard(self, bus: ServoBus) -> bytes:
        """Start the watchdog; it may trip before the first cycle, which therefore resets it once."""
        off, on = [0] * self.arm.dof, [self._watchdog] * self.arm.dof
        bus.set_checked(registers.WATCHDOG, off)
        bus.set_checked(registers.WATCHDOG, on)
        return bus.packet(registers.WATCHDOG, off) + bus.packet(registers.WATCHDOG, on)

    def _unguard(self, bus: ServoBus) -> None:
        bus.set_checked(registers.WATCHDOG, [0] * self.arm.dof)


def _all_answer(bus: ServoBus, reading: Reading) -> bool:
    """Whether all servos answer a question."""
    for _ in range(TRIES):
        bus.drain()
        if all(answer is not None and len(answer.data) == reading.length for answer in bus.ask(reading)):
            return True
    return False
