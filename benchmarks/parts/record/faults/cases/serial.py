"""What goes wrong with servos on a serial bus."""

from ..actions import at, halted, line
from ..checks import comes_to_rest, missing, no_old_samples, reports, stops
from ..fault import Fault
from .expected import ALWAYS, BORNE, FEW, QUICK

FAULTS = (
    Fault(
        "serial: a reply 7 ms late",
        "borne: those cycles are silent, and no later one takes an old reply for a new one",
        "dynamixel",
        (*BORNE, missing(1, 10 + FEW), no_old_samples),
        acts=at(500, line("late 0.007 1")),
    ),
    Fault(
        "serial: three replies with a wrong checksum",
        "borne: that servo is silent in those cycles",
        "dynamixel",
        (*BORNE, missing(3, 6 + FEW), reports("no complete answer")),
        acts=at(500, line("corrupt 12 3")),
    ),
    Fault(
        "serial: bytes that were not asked for",
        "borne: thrown away before the next question",
        "dynamixel",
        (*BORNE, no_old_samples),
        acts=at(500, line("babble 40")),
    ),
    Fault(
        "serial: a servo silent",
        "QUICK: as on CAN",
        "dynamixel",
        (*ALWAYS, stops(QUICK, "silence"), comes_to_rest),
        acts=at(500, line("silent 12")),
    ),
    Fault(
        "serial: a servo overloaded",
        "QUICK: it has switched its torque off",
        "dynamixel",
        (*ALWAYS, stops(QUICK, "drive fault")),
        acts=at(500, line("error 12 32")),
    ),
    Fault(
        "serial: all servos stand still for 100 ms",
        "QUICK: as silence of one",
        "dynamixel",
        (*ALWAYS, stops(QUICK, "silence", "drive fault"), comes_to_rest),
        acts=at(500, halted(0.1)),
    ),
)
