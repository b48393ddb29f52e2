"""Health of Dynamixel servos: whether they are fit for a run, and whether one has stopped itself."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import BadSettings, NotReady
from ..servo.servo_bus import ServoBus
from ..servo.servo_line import Status
from .packet import ALERT
from .registers import HARDWARE_ERROR, MODELS, TORQUE, TRIPPED, WATCHDOG, hardware_errors


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
