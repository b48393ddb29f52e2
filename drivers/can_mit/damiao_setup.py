"""Set-up of one Damiao motor by its registers: what was assumed about it is checked, its dead-man is set."""

import struct
from dataclasses import dataclass, field

from ..can.can_bus import CanBus
from ..errors import NotReady
from . import damiao_registers as r
from .mit_motors import Motor


@dataclass
class Found:
    """Data of a motor.

    Attributes:
        guarded: Whether it is verified that it switches off when the host falls silent.
        timeout: What its TIMEOUT was before; None if it did not answer.
        facts: What explains the measurement later.
        warnings: Warnings, a sentence each.
    """

    guarded: bool = False
    timeout: int | None = None
    facts: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def set_up(bus: CanBus, motor: Motor, dead_man: float | None) -> Found:
    """Look at a motor's registers, and make it switch off after so long a silence of the host.

    Args:
        bus: Open.
        motor: Of Damiao.
        dead_man: That silence [s]; None for a motor that is only read, of which nothing is changed.

    Raises:
        NotReady: Its ranges are not those that were set, or it does not take the MIT mode.
    """
    found = Found()
    if _reading(bus, motor, r.MODE) is None:
        found.warnings.append(
            f"{motor.name} does not show its registers: its ranges could not be checked, and it goes on with "
            "its last command if this computer falls silent"
        )
        return found
    _require_ranges(bus, motor)
    if dead_man is not None:
        _set_mode(bus, motor)
    for register in (r.TORQUE_CONSTANT, r.GEAR, r.SOFTWARE):
        value = _reading(bus, motor, register)
        if value is not None:
            found.facts.append(f"{register.name} {value:g}")
    if dead_man is not None:
        _set_dead_man(bus, motor, dead_man, found)
    return found


def leave(bus: CanBus, motor: Motor, timeout: int) -> None:
    """Write TIMEOUT without waiting for an answer."""
    head = struct.pack("<HBB", motor.number, r.WRITE, r.TIMEOUT.number)
    bus.send_frames([(r.TO_ALL, head + struct.pack(r.TIMEOUT.form, timeout))])


def _reading(bus: CanBus, motor: Motor, register: r.Register) -> float | None:
    return r.read(bus, motor.number, motor.master, register)


def _require_ranges(bus: CanBus, motor: Motor) -> None:
    for register, nominal in zip(r.RANGES, motor.commanded, strict=True):
        value = _reading(bus, motor, register)
        if value is not None and abs(value - nominal) > 1e-3 * nominal:
            raise NotReady(
                f"{motor.name} has {register.name} = {value:g}, its model here has {nominal:g}: every "
                "number would be wrong. Correct model, or set position_range, velocity_range and torque_range"
            )


def _set_mode(bus: CanBus, motor: Motor) -> None:
    if _reading(bus, motor, r.MODE) == r.MIT_MODE:
        return
    mode = r.write(bus, motor.number, motor.master, r.MODE, r.MIT_MODE)
    if mode != r.MIT_MODE:
        raise NotReady(f"{motor.name} was set to mode {r.MIT_MODE} (MIT) and is in mode {mode}")


def _set_dead_man(bus: CanBus, motor: Motor, dead_man: float, found: Found) -> None:
    before = _reading(bus, motor, r.TIMEOUT)
    found.timeout = None if before is None else int(before)
    wanted = round(dead_man / r.TIMEOUT_UNIT)
    found.guarded = r.write(bus, motor.number, motor.master, r.TIMEOUT, wanted) == wanted
    if not found.guarded:
        found.warnings.append(f"{motor.name} does not take TIMEOUT: it goes on if this computer falls silent")
