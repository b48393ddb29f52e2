"""How the servos of the peers count: what their hosts must know."""

import numpy as np

TURN = 4096
"""Counts in a turn."""


GEARS = {"dynamixel": 50.0, "feetech": 7.0}
"""Turns of a servo in a turn of its joint: without gears a big arm would feel every count of its goals."""


def sign(joints):
    """Every second servo turns the other way, shape (n,)."""
    return np.where(np.arange(joints) % 2, -1.0, 1.0)


def zero(joints):
    """Counts where joints are at zero, shape (n,)."""
    return 2048 + 100 * np.arange(joints)


def ids(joints):
    return [10 + number for number in range(joints)]


def _settings(address, joints):
    return {
        "port": address,
        "ids": ids(joints),
        "sign": [int(one) for one in sign(joints)],
        "zero": [int(one) for one in zero(joints)],
    }


def dynamixel_settings(address, joints=6):
    """Settings of driver dynamixel for the servos of `dynamixel_bus.py`."""
    own = {"gear": GEARS["dynamixel"], "baudrate": 4_000_000, "operating_mode": "extended"}
    return {**_settings(address, joints), **own}


def feetech_settings(address, joints=6):
    """Settings of driver feetech for the servos of `feetech_bus.py`."""
    return {**_settings(address, joints), "gear": GEARS["feetech"]}
