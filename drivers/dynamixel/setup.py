"""Before a run with Dynamixel servos: who is there, and whether each is fit for it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import BadSettings, NotReady
from ..servo.servo_bus import ServoBus
from .models import MODELS
from .registers import (
    BAUDRATES,
    HARDWARE_ERROR,
    MODE,
    MODES,
    RETURN_DELAY,
    RETURN_DELAY_UNIT,
    TORQUE,
    hardware_errors,
)


class Found(NamedTuple):
    """Data of a servo.

    Attributes:
        model: Its number, a key of `MODELS` if it is known.
        firmware: Version.
    """

    model: int
    firmware: int


def find(bus: ServoBus, baudrate: int) -> list[Found]:
    """All servos, in the order of the joints.

    Raises:
        LinkLost: Some do not answer.
    """
    data = bus.find(baudrate, BAUDRATES)
    return [Found(int.from_bytes(one[:2], "little"), one[2]) for one in data]


def require_healthy(bus: ServoBus, shutdown: Sequence[int]) -> None:
    """Nothing, if no servo has an error for which it switches its torque off.

    Raises:
        NotReady: One has.
    """
    for servo, bits, mask in zip(bus.servos, bus.read(HARDWARE_ERROR), shutdown, strict=True):
        if bits & mask:
            raise NotReady(
                f"{bus.names[servo]} has stopped itself: {hardware_errors(bits & mask)}. Remove the cause, "
                "support the arm, and switch its power off and on"
            )


def require_mode(bus: ServoBus, name: str) -> None:
    """Nothing, if all servos are in this operating mode.

    Raises:
        NotReady: One is in another.
    """
    for servo, found in zip(bus.servos, bus.read(MODE), strict=True):
        if found != MODES[name]:
            modes = ", ".join(f"{word} is {number}" for word, number in MODES.items())
            raise NotReady(
                f"{bus.names[servo]} is in operating mode {found}, not {MODES[name]} ({name}). Set its "
                f"register {MODE.address} with DYNAMIXEL Wizard, or try another operating_mode: {modes}"
            )


def set_return_delay(bus: ServoBus, seconds: float) -> None:
    """Set it where it is another: servos keep it for good, and take it only while torque is off.

    Raises:
        NotReady: Torque is on.
    """
    wanted = [round(seconds / RETURN_DELAY_UNIT)] * len(bus.servos)
    if bus.read(RETURN_DELAY) == wanted:
        return
    holding = [bus.names[s] for s, on in zip(bus.servos, bus.read(TORQUE), strict=True) if on]
    if holding:
        raise NotReady(
            f"{RETURN_DELAY} can be set to {1e6 * seconds:g} us only while torque is off, and "
            f"{', '.join(holding)} has it on. Support the arm and switch its power off and on"
        )
    bus.settle(RETURN_DELAY, wanted, pause=0.02)


def current_units(bus: ServoBus, found: Sequence[Found], given: Sequence[float]) -> np.ndarray:
    """[A] a count, shape (n,), as given or else by model; zero for servos that measure none.

    Raises:
        BadSettings: An unknown model, and no unit given.
    """
    for servo, one, unit in zip(bus.servos, found, given, strict=True):
        if not unit and one.model not in MODELS:
            raise BadSettings(
                f"{bus.names[servo]} is of model {one.model}, whose unit of current is not known. Look under "
                "its register 126 in the manual and set current_unit"
            )
    return np.array([unit or MODELS[one.model].current_unit for one, unit in zip(found, given, strict=True)])
