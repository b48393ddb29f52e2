"""Registers of Damiao motors, which are set before a run and lost at the next power-off.

Frames to 0x7FF are for the motor named in their first two bytes, which answers on its master identifier.
"""

import struct
from dataclasses import dataclass, field
from typing import NamedTuple

from ..can.can_bus import CanBus
from ..errors import NotReady
from .mit_frame import Motor

TO_ALL = 0x7FF
"""Identifier of requests."""
READ, WRITE, STORE, REFRESH = 0x33, 0x55, 0xAA, 0xCC
"""Third byte of a request: read a register, write a register, store all of them, answer with the state."""
TRIES, ANSWER = 3, 0.1
"""Number of attempts to read a register, and maximum time to wait for each answer [s]."""


class Register(NamedTuple):
    """A register: its number, the `struct` format of its value, and the maker's name for it."""

    number: int
    form: str
    name: str


TORQUE_CONSTANT = Register(1, "<f", "KT_Value")
TIMEOUT = Register(9, "<I", "TIMEOUT")
MODE = Register(10, "<I", "CTRL_MODE")
SOFTWARE = Register(14, "<I", "sw_ver")
GEAR = Register(20, "<f", "Gr")
RANGES = (Register(21, "<f", "PMAX"), Register(22, "<f", "VMAX"), Register(23, "<f", "TMAX"))

MIT_MODE = 1
"""Value of CTRL_MODE."""
TIMEOUT_UNIT = 50e-6
"""Unit of TIMEOUT [s]; zero is never."""


def refresh(motor: int) -> bytes:
    """Encode the request that makes a motor answer with its state and do nothing else."""
    return struct.pack("<HBx4x", motor, REFRESH)


def is_register(motor: int, data: bytes) -> bool:
    """Whether an answer contains a register, which another program may have asked for, instead of a state.

    A state with the same bytes would mean a motor that is off, within 0.5 % of the end of its range.
    """
    return len(data) == 8 and data[:2] == struct.pack("<H", motor) and data[2] in (READ, WRITE, STORE)


def _read(bus: CanBus, motor: Motor, register: Register) -> float | None:
    """Read a register; None if there is no answer."""
    return _ask(bus, motor, register, READ, bytes(4))


def _write(bus: CanBus, motor: Motor, register: Register, value: int) -> float | None:
    """Write a register and read it back; None if there is no answer."""
    _ask(bus, motor, register, WRITE, struct.pack(register.form, value))
    return _read(bus, motor, register)


def _ask(bus: CanBus, motor: Motor, register: Register, action: int, data: bytes) -> float | None:
    head = struct.pack("<HBB", motor.number, action, register.number)
    for _ in range(TRIES):
        bus.send_frames([(TO_ALL, head + data)])
        end = bus.clock.monotonic() + ANSWER
        while (remaining := end - bus.clock.monotonic()) > 0.0:
            identifier, answer = bus.receive(remaining) or (-1, b"")
            if identifier == motor.master and len(answer) == 8 and answer[:4] == head:
                return float(struct.unpack(register.form, answer[4:])[0])
    return None


@dataclass
class MotorData:
    """Data of a motor."""

    guarded: bool = False  # whether it is verified that the motor switches off when the host falls silent
    timeout: int | None = None  # value of TIMEOUT before the set-up; None if the motor did not answer
    facts: list[str] = field(default_factory=list)  # facts that explain the measurements later
    warnings: list[str] = field(default_factory=list)  # warnings, a sentence each


def set_up(bus: CanBus, motor: Motor, dead_man: float | None) -> MotorData:
    """Check a motor's registers, and make it switch off after `dead_man` [s] without a frame of the host.

    Without `dead_man`, for a motor that is only read, nothing is changed. Raises NotReady if its ranges
    differ from the settings, or it does not take the MIT mode.
    """
    motor_data = MotorData()
    if _read(bus, motor, MODE) is None:
        motor_data.warnings.append(
            f"{motor.name} does not show its registers: its ranges could not be checked, and it keeps "
            "following its last command if this computer falls silent"
        )
        return motor_data
    _require_ranges(bus, motor)
    if dead_man is not None:
        _set_mode(bus, motor)
    for register in (TORQUE_CONSTANT, GEAR, SOFTWARE):
        value = _read(bus, motor, register)
        if value is not None:
            motor_data.facts.append(f"{register.name} {value:g}")
    if dead_man is not None:
        _set_dead_man(bus, motor, dead_man, motor_data)
    return motor_data


def leave(bus: CanBus, motor: Motor, timeout: int) -> None:
    """Write TIMEOUT without waiting for an answer."""
    head = struct.pack("<HBB", motor.number, WRITE, TIMEOUT.number)
    bus.send_frames([(TO_ALL, head + struct.pack(TIMEOUT.form, timeout))])


def _require_ranges(bus: CanBus, motor: Motor) -> None:
    for register, nominal in zip(RANGES, motor.commanded, strict=True):
        value = _read(bus, motor, register)
        if value is not None and abs(value - nominal) > 1e-3 * nominal:
            raise NotReady(
                f"{motor.name} has {register.name} = {value:g}, its model here has {nominal:g}: every number "
                "would be wrong. Correct model, or set position_range, velocity_range and torque_range"
            )


def _set_mode(bus: CanBus, motor: Motor) -> None:
    if _read(bus, motor, MODE) == MIT_MODE:
        return
    mode = _write(bus, motor, MODE, MIT_MODE)
    if mode != MIT_MODE:
        raise NotReady(f"{motor.name} was set to mode {MIT_MODE} (MIT) and is in mode {mode}")


def _set_dead_man(bus: CanBus, motor: Motor, dead_man: float, motor_data: MotorData) -> None:
    before = _read(bus, motor, TIMEOUT)
    motor_data.timeout = None if before is None else int(before)
    wanted = round(dead_man / TIMEOUT_UNIT)
    motor_data.guarded = _write(bus, motor, TIMEOUT, wanted) == wanted
    if not motor_data.guarded:
        motor_data.warnings.append(
            f"{motor.name} does not take TIMEOUT: it keeps moving if this computer falls silent"
        )
