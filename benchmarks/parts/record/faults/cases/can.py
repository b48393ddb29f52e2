"""What goes wrong with drives on CAN."""

from ..actions import at, halted
from ..checks import comes_to_rest, ends_orderly, peer_says, reports, stops
from ..fault import Fault
from .expected import ALWAYS, QUICK

FAULTS = (
    Fault(
        "CAN: a node silent",
        "QUICK: one joint without control drags the others; those that hear must stop",
        "canopen_402",
        (*ALWAYS, stops(QUICK, "silence"), comes_to_rest, peer_says(": stopping", 5)),
        ("--fault", "silent:3@800"),
        quick=True,
    ),
    Fault(
        "CAN: EMCY",
        "QUICK: a drive that reports an error may stop at any moment",
        "canopen_402",
        (*ALWAYS, stops(QUICK, "drive fault"), comes_to_rest, reports("emergency")),
        ("--fault", "emergency:2@800"),
    ),
    Fault(
        "CAN: a drive trips",
        "QUICK: it brakes by itself, the others must do the same",
        "canopen_402",
        (*ALWAYS, stops(QUICK, "drive fault"), comes_to_rest, peer_says(": stopping", 5)),
        ("--fault", "fault:2@800"),
    ),
    Fault(
        "CAN: noise on the bus",
        "foreign and broken frames are ignored; one that passes for a node's own may stop the arm",
        "canopen_402",
        (*ALWAYS, ends_orderly),
        ("--fault", "noise:1@800"),
    ),
    Fault(
        "CAN: all nodes stand still for 100 ms",
        "QUICK: as silence of one",
        "canopen_402",
        (*ALWAYS, stops(QUICK, "silence"), comes_to_rest),
        acts=at(500, halted(0.1)),
    ),
    Fault(
        "MIT: a motor silent",
        "QUICK: as on CANopen",
        "can_mit",
        (*ALWAYS, stops(QUICK, "silence"), comes_to_rest),
        ("--fault", "silent:3@800"),
    ),
    Fault(
        "MIT: a motor with an error",
        "QUICK: it has switched itself off and its joint falls",
        "can_mit",
        (*ALWAYS, stops(QUICK, "drive fault")),
        ("--fault", "error:3@800"),
    ),
)
