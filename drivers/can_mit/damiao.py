"""Damiao motors: their registers, set before a run and gone with the next power-off.

Frames to 0x7FF are for the motor named in their first two bytes; it answers on its own master identifier.
"""

import struct
import time
from dataclasses import dataclass, field
from typing import NamedTuple

from ..can.can_bus import CanBus
from ..errors import NotReady
from .mit_frame import Motor

TO_ALL = 0x7FF
"""Identifier of requests."""
READ, WRITE, STORE, REFRESH = 0x33, 0x55, 0xAA, 0xCC
"""Third byte of a request: read a register, write one, store all of them, answer with the state."""
TRIES, ANSWER = 3, 0.1
"""How often a register is asked for, and how long each answer is waited for [s]."""


class Register(NamedTuple):
    """A register: its number, the form of its value as `struct` writes it, and its maker's name for it."""

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
    """The request that makes a motor answer with its state and do nothing else."""
    return struct.pack("<HBx4x", motor, REFRESH)


def is_register(motor: int, data: bytes) -> bool:
    """Whether an answer of a motor has a register, as another program may have asked for, and no state.

    A state with the same bytes would be of a motor that is off, at a two-hundredth of its range from the end.
    """
    return len(data) == 8 and data[:2] == struct.pack("<H", motor) and data[2] in (READ, WRITE, STORE)


def read(bus: CanBus, motor: int, master: int, register: Register) -> float | None:
    """The value of a register; None where there is no answer for it."""
    return _ask(bus, motor, master, register, READ, bytes(4))


def write(bus: CanBus, motor: int, master: int, register: Register, value: int) -> float | None:
    """Write a register and read it back; None where there is no answer for it."""
    _ask(bus, motor, master, register, WRITE, struct.pack(register.form, value))
    return read(bus, motor, master, register)


def _ask(bus: CanBus, motor: int, master: int, register: Register, what: int, data: bytes) -> float | None:
    head = struct.pack("<HBB", motor, what, register.number)
    for _ in range(TRIES):
        bus.send_frames([(TO_ALL, head + data)])
        end = time.monotonic() + ANSWER
        while (left := end - time.monotonic()) > 0.0:
            identifier, answer = bus.receive(left) or (-1, b"")
            if identifier == master and len(answer) == 8 and answer[:4] == head:
                return float(struct.unpack(register.form, answer[4:])[0])
    return None


@dataclass
class MotorData:
    """Data of a motor: facts that explain the measurement later, and warnings, a sentence each.

    Attributes:
        guarded: Whether it is verified that it switches off when the host falls silent.
        timeout: Its TIMEOUT before the set-up; None if it did not answer.
    """

    guarded: bool = False
    timeout: int | None = None
    facts: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def set_up(bus: CanBus, motor: Motor, dead_man: float | None) -> MotorData:
    """Check a motor's registers, and make it switch off after so long a silence of the host [s].

    Without `dead_man`, for a motor that is only read, nothing is changed. Raises NotReady if its ranges are
    not those that were set, or it does not take the MIT mode.
    """
    found = MotorData()
    if _reading(bus, motor, MODE) is None:
        found.warnings.append(
            f"{motor.name} does not show its registers: its ranges could not be checked, and it goes on with "
            "its last command if this computer falls silent"
        )
        return found
    _require_ranges(bus, motor)
    if dead_man is not None:
        _set_mode(bus, motor)
    for register in (TORQUE_CONSTANT, GEAR, SOFTWARE):
        value = _reading(bus, motor, register)
        if value is not None:
            found.facts.append(f"{register.name} {value:g}")
    if dead_man is not None:
        _set_dead_man(bus, motor, dead_man, found)
    return found


def leave(bus: CanBus, motor: Motor, timeout: int) -> None:
    """Write TIMEOUT without waiting for an answer."""
    head = struct.pack("<HBB", motor.number, WRITE, TIMEOUT.number)
    bus.send_frames([(TO_ALL, head + struct.pack(TIMEOUT.form, timeout))])


def _reading(bus: CanBus, motor: Motor, register: Register) -> float | None:
    return read(bus, motor.number, motor.master, register)


def _require_ranges(bus: CanBus, motor: Motor) -> None:
    for register, nominal in zip(RANGES, motor.commanded, strict=True):
        value = _reading(bus, motor, register)
        if value is not None and abs(value - nominal) > 1e-3 * nominal:
            raise NotReady(
                f"{motor.name} has {register.name} = {value:g}, its model here has {nominal:g}: every "
                "number would be wrong. Correct model, or set position_range, velocity_range and torque_range"
            )


def _set_mode(bus: CanBus, motor: Motor) -> None:
    if _reading(bus, motor, MODE) == MIT_MODE:
        return
    mode = write(bus, motor.number, motor.master, MODE, MIT_MODE)
    if mode != MIT_MODE:
        raise NotReady(f"{motor.name} was set to mode {MIT_MODE} (MIT) and is in mode {mode}")


def _set_dead_man(bus: CanBus, motor: Motor, dead_man: float, found: MotorData) -> None:
    before = _reading(bus, motor, TIMEOUT)
    found.timeout = None if before is None else int(before)
    wanted = round(dead_man / TIMEOUT_UNIT)
    found.guarded = write(bus, motor.number, motor.master, TIMEOUT, wanted) == wanted
    if not found.guarded:
        found.warnings.append(f"{motor.name} does not take TIMEOUT: it goes on if this computer falls silent")
