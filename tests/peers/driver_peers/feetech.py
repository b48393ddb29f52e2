"""Feetech servos."""

from functools import partial

from ...parts.controllers.servo_parts import is_off, running
from . import DriverPeer

PEER = DriverPeer(
    partial(running, "feetech"),
    is_off=partial(is_off, torque=40, goal=42),
    cobot=("--lockstep", "--cycle", 0.01),
)
