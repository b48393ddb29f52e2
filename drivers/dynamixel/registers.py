"""Registers of Dynamixel X servos, and of MX servos with firmware 2.0, and their units."""

import numpy as np

from ..servo.servo_packet import Register

BAUDRATES = (57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
"""What X servos can be set to [bit/s]."""

MODES = {"position": 3, "extended": 4, "current_position": 5}
"""Operating modes in which a servo follows a position."""

FURTHEST = 256 * 4096 - 1
"""Largest goal, either way, of the modes of several turns [counts]."""

VELOCITY_UNIT = 0.229 * 2.0 * np.pi / 60.0
"""[rad/s] a count."""

RETURN_DELAY_UNIT = 2e-6
"""[s] a count."""

WATCHDOG_UNIT = 0.02
"""[s] a count."""

RETURN_DELAY = Register(9, 1, "return delay")
MODE = Register(11, 1, "operating mode")
HOMING = Register(20, 4, "homing offset", True)
HIGHEST = Register(48, 4, "maximum position limit", True)
LOWEST = Register(52, 4, "minimum position limit", True)
SHUTDOWN = Register(63, 1, "shutdown")
TORQUE = Register(64, 1, "torque enable")
STATUS_LEVEL = Register(68, 1, "status return level")
HARDWARE_ERROR = Register(70, 1, "hardware error status")
WATCHDOG = Register(98, 1, "bus watchdog", True)
PROFILE_ACCELERATION = Register(108, 4, "profile acceleration")
PROFILE_VELOCITY = Register(112, 4, "profile velocity")
GOAL = Register(116, 4, "goal position", True)
PRESENT = Register(132, 4, "present position", True)

TRIPPED = -1
"""Value of the bus watchdog after it has stopped the servo."""

FIRST = 126
"""Register from which the measurements are read."""

MEASURED = np.dtype([("current", "<i2"), ("velocity", "<i4"), ("position", "<i4")])
"""Registers 126 to 135, read in every cycle."""

WARM = np.dtype([*MEASURED.descr, ("plan", "V8"), ("voltage", "<u2"), ("temperature", "u1")])
"""Registers 126 to 146, read now and then."""

_HARDWARE = ("input voltage", "hall sensor", "overheating", "encoder", "electrical shock", "overload")


def hardware_errors(bits: int) -> str:
    """Meaning of the register of hardware errors."""
    named = [name for place, name in enumerate(_HARDWARE) if bits >> place & 1]
    return ", ".join(named) or f"hardware error {bits}"
