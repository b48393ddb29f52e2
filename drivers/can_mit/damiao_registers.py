"""Registers of Damiao motors: read and written over the bus, and gone with the next power-off.

Frames to 0x7FF are for the motor named in their first two bytes; it answers on its own master identifier.
"""

import struct
import time
from typing import NamedTuple

from ..can.can_bus import CanBus

TO_ALL = 0x7FF
"""Identifier of requests."""
READ, WRITE, REFRESH = 0x33, 0x55, 0xCC
"""Third byte of a request: read a register, write one, answer with the state."""
TRIES, ANSWER = 3, 0.1
"""How often a register is asked for, and how long each answer is waited for [s]."""


class Register(NamedTuple):
    """One register.

    Attributes:
        number: Of the register.
        form: Of its value, as `struct` writes it.
        name: As its maker calls it.
    """

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
