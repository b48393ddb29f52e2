"""Feetech STS and SMS servos on a serial port.

Each cycle is one write: the goals of all servos, and the question for position, velocity, temperature and
current of all. These servos have no known way to stop by themselves when the computer falls silent.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..driver import Info
from ..servo.servo_bus import LENGTHS, ServoBus
from ..servo.servo_driver import ServoDriver
from ..servo.servo_line import Codec, Goals, Measured, Reading, Register, ServoSettings, Sign, Status
from ..settings import setting
from . import packet as packets

BAUDRATES = (38_400, 57_600, 115_200, 250_000, 500_000, 1_000_000)
"""Baud rates that the servos support [bit/s]."""

MODEL = Register(3, 2, "model number")
RETURN_DELAY = Register(7, 1, "return delay")
LOWEST = Register(9, 2, "minimum position limit")
HIGHEST = Register(11, 2, "maximum position limit")
PHASE = Register(18, 1, "phase")
UNLOADING = Register(19, 1, "unloading condition")
MODE = Register(33, 1, "operating mode")
TORQUE = Register(40, 1, "torque enable")
ACCELERATION = Register(41, 1, "acceleration")
GOAL = Register(42, 2, "goal position", Sign.HIGHEST_BIT)
GOAL_TIME = Register(44, 2, "goal time")
GOAL_VELOCITY = Register(46, 2, "goal velocity")
LOCK = Register(55, 1, "lock")
PRESENT = Register(56, 2, "present position", Sign.HIGHEST_BIT)

MEASURED = np.dtype(
    [
        ("position", "<u2"), ("velocity", "<u2"), ("load", "<u2"), ("voltage", "u1"), ("temperature", "u1"),
        ("between", "V5"), ("current", "<u2")
    ]
)  # fmt: skip
"""Registers 56 to 70, read in every cycle."""

SIGNED = ("position", "velocity", "current")
"""Measurements whose bit 15 is the sign."""

FINE, FULL_SPEED, NO_CURRENT = 4, 8, 32
"""Bits of the phase: velocity in counts per second instead of 50 counts per second; a goal velocity of 0 is
the fastest; a bridge that measures no current."""

FASTEST = {True: 3400, False: 68}
"""Goal velocity of servos for which 0 is standstill, in fine and coarse units [counts/s], [50 counts/s]."""

FURTHEST = 30719
"""Largest magnitude of a goal of servos without position limits [counts]."""

ALARMS = ("voltage", "encoder", "overheating", "overcurrent", "", "overload")
"""Meanings of the bits of the error byte."""


@dataclass(frozen=True)
class FeetechSettings(ServoSettings):
    """Settings of an arm of Feetech servos."""

    current_unit: tuple[float, ...] = setting(6.5e-3, "current of a count", unit="A", low=1e-6, high=1.0)
    acceleration: int = setting(
        254, "acceleration with which servos follow their goals", unit="100 counts/s^2", low=0, high=254
    )


class Feetech(ServoDriver):
    """Feetech STS and SMS servos."""

    Settings = FeetechSettings
    codec: ClassVar[Codec] = packets
    baudrates = BAUDRATES
    torque, goal, present = TORQUE, GOAL, PRESENT
    return_delay, lock = RETURN_DELAY, LOCK

    def _set_up(self, bus: ServoBus) -> Info:
        settings, n = self.settings, self.arm.dof
        bus.find(settings.baudrate, BAUDRATES)
        bus.require(MODE, 0, f"(position). Set its register {MODE.address} to 0")
        self._set_return_delay(bus)
        phases = bus.read(PHASE)
        self._velocity_unit = np.array(
            [(1.0 if phase & FINE else 50.0) * 2.0 * np.pi / turn
             for phase, turn in zip(phases, settings.counts_per_turn, strict=True)]
        )  # fmt: skip
        bus.set_checked(ACCELERATION, [settings.acceleration] * n)
        bus.set_checked(GOAL_TIME, [0] * n)
        bus.set_checked(
            GOAL_VELOCITY, [0 if phase & FULL_SPEED else FASTEST[bool(phase & FINE)] for phase in phases]
        )
        self._unloading = bus.read(UNLOADING)
        self._allowed = _goals_allowed(bus)
        self._questions = [
            packets.sync_read(PRESENT.address - more, MEASURED.itemsize + more, settings.ids)
            for more in range(LENGTHS)
        ]
        self._measures = np.array([not phase & NO_CURRENT for phase in phases])
        self._ampere = np.where(self._measures, settings.current_unit, np.nan)
        models = ", ".join(f"{s} model {model}" for s, model in zip(bus.servos, bus.read(MODEL), strict=True))
        signals = ("position", "velocity", *["current"] * bool(self._measures.any()), "temperature")
        return self._info(bus, signals, self._warnings(), dead_man="", servos=models)

    def _warnings(self) -> list[str]:
        warnings = [
            "these servos keep moving to their last goal if this computer falls silent: they cannot stop by "
            "themselves"
        ]
        if not self._measures.all():
            warnings.append("some servos measure no current; only [drive] servo_gain identifies their joints")
        return warnings

    def _question(self) -> Reading:
        return packets.sync_read(PRESENT.address, MEASURED.itemsize, self.settings.ids)

    def _readings(self, number: int) -> Sequence[Reading]:
        return self._questions

    def _decode(self, data: bytes, length: int) -> Measured:
        rows = np.frombuffer(data, MEASURED)
        numbers = np.array([rows[name] for name in SIGNED])
        magnitude = (numbers & 0x7FFF).astype(float)
        position, velocity, current = np.where(numbers & 0x8000, -magnitude, magnitude)
        return Measured(
            position,
            velocity * self._velocity_unit,
            current * self._ampere,
            rows["temperature"].astype(float),
        )

    def _begin(self) -> None:
        super()._begin()
        self._reported = [0] * self.arm.dof

    def _find_fault(self, answers: Sequence[Status | None], now: int, events: list[str]) -> str:
        """Report alarms; an alarm for which a servo is set to switch its torque off is a fault."""
        faults = []
        for place, answer in enumerate(answers):
            if answer is None or answer.error == self._reported[place]:
                continue
            new, self._reported[place] = answer.error & ~self._reported[place], answer.error
            name = self._names[self.settings.ids[place]]
            if new & self._unloading[place]:
                faults.append(f"{name} gives way: {_alarms(new & self._unloading[place])}")
            elif new:
                events.append(f"{name} warns: {_alarms(new)}")
        return "; ".join(faults)


def _alarms(bits: int) -> str:
    named = [name for place, name in enumerate(ALARMS) if bits >> place & 1 and name]
    return ", ".join(named) or f"alarm {bits}"


def _goals_allowed(bus: ServoBus) -> Goals:
    """Range of goals of the servos; a servo whose limits are both zero has no limits."""
    lowest, highest = np.array(bus.read(LOWEST)), np.array(bus.read(HIGHEST))
    free = (lowest == 0) & (highest == 0)
    return Goals(np.where(free, -FURTHEST, lowest), np.where(free, FURTHEST, highest))
