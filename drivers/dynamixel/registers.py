"""Registers, units and models of Dynamixel X servos and of MX servos with firmware 2.0, and their health.

The numbers are from the manufacturer. Models without a unit of current have a load in its place, computed
from the applied voltage.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import BadSettings, NotReady
from ..servo.servo_bus import ServoBus
from ..servo.servo_line import Register, Sign, Status
from .packet import ALERT

BAUDRATES = (57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
"""Baud rates that X servos support [bit/s]."""

MODES = {"position": 3, "extended": 4, "current_position": 5}
"""Operating modes in which a servo follows a position."""

FURTHEST = 256 * 4096 - 1
"""Largest magnitude of a goal in multi-turn modes [counts]."""

VELOCITY_UNIT = 0.229 * 2.0 * np.pi / 60.0
"""Velocity per count [rad/s]."""

WATCHDOG_UNIT = 0.02
"""Time per count of the watchdog [s]."""

RETURN_DELAY = Register(9, 1, "return delay")
MODE = Register(11, 1, "operating mode")
HOMING = Register(20, 4, "homing offset", Sign.COMPLEMENT)
HIGHEST = Register(48, 4, "maximum position limit", Sign.COMPLEMENT)
LOWEST = Register(52, 4, "minimum position limit", Sign.COMPLEMENT)
SHUTDOWN = Register(63, 1, "shutdown")
TORQUE = Register(64, 1, "torque enable")
STATUS_LEVEL = Register(68, 1, "status return level")
HARDWARE_ERROR = Register(70, 1, "hardware error status")
WATCHDOG = Register(98, 1, "bus watchdog", Sign.COMPLEMENT)
PROFILE_ACCELERATION = Register(108, 4, "profile acceleration")
PROFILE_VELOCITY = Register(112, 4, "profile velocity")
GOAL = Register(116, 4, "goal position", Sign.COMPLEMENT)
PRESENT = Register(132, 4, "present position", Sign.COMPLEMENT)

TRIPPED = -1
"""Value of the bus watchdog after it has stopped the servo."""

FIRST = 126
"""Register from which the measurements are read."""

MEASURED = np.dtype([("current", "<i2"), ("velocity", "<i4"), ("position", "<i4")])
"""Registers 126 to 135, read in every cycle."""

WARM = np.dtype([*MEASURED.descr, ("plan", "V8"), ("voltage", "<u2"), ("temperature", "u1")])
"""Registers 126 to 146, read in some cycles."""

_HARDWARE = ("input voltage", "hall sensor", "overheating", "encoder", "electrical shock", "overload")


def hardware_errors(bits: int) -> str:
    """Meaning of the register of hardware errors."""
    named = [name for place, name in enumerate(_HARDWARE) if bits >> place & 1]
    return ", ".join(named) or f"hardware error {bits}"


class Model(NamedTuple):
    """Printed name of a servo, and its current per count [A]; zero if it measures none."""

    name: str
    current_unit: float


MODELS: dict[int, Model] = {
    number: Model(name, unit)
    for number, name, unit in (
        (30, "MX-28(2.0)", 0.0), (311, "MX-64(2.0)", 3.36e-3), (321, "MX-106(2.0)", 3.36e-3),
        (1000, "XH430-W350", 2.69e-3), (1001, "XD430-T350", 2.69e-3), (1010, "XH430-W210", 2.69e-3),
        (1011, "XD430-T210", 2.69e-3), (1020, "XM430-W350", 2.69e-3), (1030, "XM430-W210", 2.69e-3),
        (1040, "XH430-V350", 1.34e-3), (1050, "XH430-V210", 1.34e-3), (1060, "XL430-W250", 0.0),
        (1070, "XC430-W150", 0.0), (1080, "XC430-W240", 0.0), (1090, "2XL430-W250", 0.0),
        (1100, "XH540-W270", 2.69e-3), (1101, "XD540-T270", 2.69e-3), (1110, "XH540-W150", 2.69e-3),
        (1111, "XD540-T150", 2.69e-3), (1120, "XM540-W270", 2.69e-3), (1130, "XM540-W150", 2.69e-3),
        (1140, "XH540-V270", 2.69e-3), (1150, "XH540-V150", 2.69e-3), (1160, "2XC430-W250", 0.0),
        (1170, "XW540-T260", 2.69e-3), (1180, "XW540-T140", 2.69e-3), (1190, "XL330-M077", 1e-3),
        (1200, "XL330-M288", 1e-3), (1210, "XC330-T181", 1e-3), (1220, "XC330-T288", 1e-3),
        (1230, "XC330-M181", 1e-3), (1240, "XC330-M288", 1e-3), (1270, "XW430-T333", 2.69e-3),
        (1280, "XW430-T200", 2.69e-3),
    )
}  # fmt: skip

_JOINED_FROM = {"330": 46, "430": 45, "540": 45}
"""Size of a servo -> first firmware that joins answers to one packet."""


def joins_answers(number: int, firmware: int) -> bool:
    """Whether a servo supports the fast sync read."""
    name = MODELS[number].name if number in MODELS else ""
    sizes = [since for size, since in _JOINED_FROM.items() if size in name and not name.startswith("2")]
    return bool(sizes) and firmware >= sizes[0]


def stops_in_silence(number: int, firmware: int) -> bool:
    """Whether the bus watchdog is reliable.

    With firmware 51, all X330 keep moving after their watchdog has tripped, as users and the maker reported.
    """
    return not (number in MODELS and "330" in MODELS[number].name and firmware <= 51)


def model_name(number: int) -> str:
    """Name of a model, or its number if unknown."""
    return MODELS[number].name if number in MODELS else f"model {number}"


class ServoData(NamedTuple):
    """Data of a servo: model number, which is a key of `MODELS` if known, and firmware version."""

    model: int
    firmware: int


def require_healthy(bus: ServoBus, shutdown: Sequence[int]) -> None:
    """Raise NotReady if a servo has an error for which it switches its torque off."""
    for servo, bits, mask in zip(bus.servos, bus.read(HARDWARE_ERROR), shutdown, strict=True):
        if bits & mask:
            raise NotReady(
                f"{bus.names[servo]} has stopped itself: {hardware_errors(bits & mask)}. Remove the cause, "
                "support the arm, and switch its power off and on"
            )


def current_units(bus: ServoBus, servos: Sequence[ServoData], units: Sequence[float]) -> np.ndarray:
    """Current per count [A], shape (n,), as set or else by model; zero for servos that measure none.

    Raises BadSettings for an unknown model if no unit is set.
    """
    for servo, (model, _), unit in zip(bus.servos, servos, units, strict=True):
        if not unit and model not in MODELS:
            raise BadSettings(
                f"{bus.names[servo]} is of model {model}, whose unit of current is not known. Look up its "
                "register 126 in the manual and set current_unit"
            )
    return np.array([unit or MODELS[s.model].current_unit for s, unit in zip(servos, units, strict=True)])


GAP = 50_000_000
"""Time without an answer after which a servo may have been stopped or have lost its power [ns]."""

AGAIN = 100
"""Number of cycles after which lasting hardware errors are read again."""


class DynamixelHealth:
    """Detects from alerts and gaps in the answers that servos have stopped themselves.

    `shutdown` contains the bits of hardware errors for which each servo switches its torque off; times are in
    [ns].
    """

    def __init__(self, bus: ServoBus, shutdown: Sequence[int], now: int) -> None:
        self._bus, self._shutdown = bus, shutdown
        self._answered, self._gap, self._watchdogs_asked = [now] * len(shutdown), 0, False
        self._alerts, self._reported, self._looks = set[int](), [0] * len(shutdown), 0

    def look(self, answers: Sequence[Status | None], now: int, armed: bool, events: list[str]) -> str:
        """Why servos have stopped themselves; empty if none has, or if it is not known yet.

        A cycle asks at most one question, so that the loop is not delayed. Warnings of servos are added to
        `events`. Raises LinkLost if the port is gone.
        """
        for place, answer in enumerate(answers):
            if answer is not None:
                self._gap = max(self._gap, now - self._answered[place])
                self._answered[place] = now
        alerts = self._new_alerts(answers)
        return self._gap_reason(armed) if alerts is None else self._errors(alerts, events)

    def _new_alerts(self, answers: Sequence[Status | None]) -> set[int] | None:
        """Places of servos with an alert if their errors must be read; else None."""
        alerts = {place for place in self._alerts if answers[place] is None}
        alerts |= {p for p, answer in enumerate(answers) if answer is not None and answer.error & ALERT}
        self._looks += 1
        return None if alerts == self._alerts and not (alerts and self._looks % AGAIN == 0) else alerts

    def _errors(self, alerts: set[int], events: list[str]) -> str:
        """Read hardware errors; an error for which a servo switches its torque off is a fault."""
        faults = []
        for place, bits in enumerate(self._bus.peek(HARDWARE_ERROR)):
            if bits is None:  # it is read again when its alert comes again
                alerts.discard(place)
                continue
            name, stops = self._name(place), bits & self._shutdown[place]
            if stops:
                faults.append(f"{name} has switched its torque off: {hardware_errors(stops)}")
            elif bits & ~self._reported[place]:
                events.append(f"{name} warns: {hardware_errors(bits & ~self._reported[place])}")
            self._reported[place] = bits
        self._alerts = alerts
        return "; ".join(faults)

    def _gap_reason(self, armed: bool) -> str:
        """Why a servo was silent: its watchdog has stopped it, or it has lost its power; else empty."""
        if not armed or self._gap < GAP:
            self._gap = 0
            return ""
        gap, self._watchdogs_asked = self._gap, not self._watchdogs_asked
        if self._watchdogs_asked:
            states = self._bus.peek(WATCHDOG)
            stopped = f"was stopped by its bus watchdog after {1e-9 * gap:.3f} s of silence"
            return next(
                (f"{self._name(p)} {stopped}" for p, state in enumerate(states) if state == TRIPPED), ""
            )
        torques = self._bus.peek(TORQUE)
        self._gap = 0 if any(on is not None for on in torques) else gap
        lost = "has its torque off, as after a loss of power"
        return next((f"{self._name(p)} {lost}" for p, on in enumerate(torques) if on == 0), "")

    def _name(self, place: int) -> str:
        return self._bus.names[self._bus.servos[place]]
