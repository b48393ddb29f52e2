"""Dynamixel servos."""

from functools import partial

from ...parts.controllers.servo_parts import is_off, running
from . import DriverPeer

PEER = DriverPeer(
    partial(running, "dynamixel", watchdog=2.0),
    is_off=partial(is_off, torque=64, goal=116),
    cobot=("--lockstep", "--cycle", 0.01),
)
