"""What goes wrong with a controller of Universal Robots, and what its operator does."""

from ..actions import at, line
from ..checks import comes_to_rest, in_state, missing, peer_says, stops
from ..fault import Fault
from .expected import ALWAYS, BORNE, FEW, QUICK

FAULTS = (
    Fault(
        "UR: packages 6 ms late",
        "borne: the newest counts, the program holds the last target",
        "ur_rtde",
        (*BORNE, missing(1, 4 + FEW), peer_says("program ended: to its end")),
        acts=at(500, line("hold 0.006")),
        quick=True,
    ),
    Fault(
        "UR: silence of 100 ms",
        "QUICK: for that long the arm's position is unknown",
        "ur_rtde",
        (*ALWAYS, stops(QUICK, "silence", "link lost"), comes_to_rest, peer_says("stopping")),
        acts=at(500, line("hold 0.1")),
    ),
    Fault(
        "UR: protective stop",
        "QUICK: the controller has stopped the arm, and the recording has its safety mode",
        "ur_rtde",
        (*ALWAYS, stops(QUICK, "drive fault"), comes_to_rest, in_state("safety_mode", 3.0)),
        acts=at(500, line("protective")),
    ),
    Fault(
        "UR: emergency stop",
        "QUICK: as a protective stop",
        "ur_rtde",
        (*ALWAYS, stops(QUICK, "drive fault"), comes_to_rest, in_state("safety_mode", 7.0)),
        acts=at(500, line("emergency")),
    ),
    Fault(
        "UR: speed slider to 50 %",
        "QUICK: servoj takes twice as long for each target, and leaves out others",
        "ur_rtde",
        (*ALWAYS, stops(QUICK, "drive fault"), comes_to_rest, in_state("speed_slider", 0.5)),
        acts=at(500, line("slider 0.5")),
    ),
    Fault(
        "UR: program stopped at the pendant",
        "QUICK: nothing follows the targets any more",
        "ur_rtde",
        (*ALWAYS, stops(QUICK, "drive fault"), comes_to_rest, in_state("program", 1.0)),
        acts=at(500, line("halt")),
    ),
    Fault(
        "UR: connection cut",
        "QUICK, which cannot be sent: the program stops the arm by itself after 0.2 s",
        "ur_rtde",
        (*ALWAYS, stops(QUICK, "link lost")),
        acts=at(500, line("cut")),
    ),
)
