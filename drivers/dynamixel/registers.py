"""Registers, units and models of Dynamixel X servos, and of MX servos with firmware 2.0.

The numbers are from the manufacturer. Models without a unit of current have a load in its place, computed
from the applied voltage.
"""

from typing import NamedTuple

import numpy as np

from ..servo.servo_line import Register, Sign

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
