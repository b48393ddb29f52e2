"""What goes wrong with KUKA's RSI: telegrams lost, late, twice, in disorder, and silence."""

from ..checks import comes_to_rest, missing, peer_says, reports, stops
from ..fault import Fault
from .expected import ALWAYS, BORNE, FEW, QUICK

FAULTS = (
    Fault(
        "RSI: three telegrams lost",
        "borne: the controller holds its last correction (HOLDON), the motion's time waits",
        "kuka_rsi",
        (*BORNE, missing(3, 3 + FEW), peer_says("stopped by the Stop channel")),
        ("--drop", "500,520-521"),
    ),
    Fault(
        "RSI: telegrams 20 ms late",
        "borne, and reported: old ones are no news and are not answered",
        "kuka_rsi",
        (*BORNE, missing(1, 10 + FEW), reports("too late")),
        ("--delay", "500:0.02,600:0.02"),
    ),
    Fault(
        "RSI: ten telegrams twice",
        "borne, and reported: the second is no news, else the motion would run ahead",
        "kuka_rsi",
        (*BORNE, missing(0, FEW), reports("twice")),
        ("--duplicate", "500-509"),
    ),
    Fault(
        "RSI: telegrams in the wrong order",
        "borne, and reported: time never goes back",
        "kuka_rsi",
        (*BORNE, missing(1, 5 + FEW), reports("too late")),
        ("--reorder", "500,510,520"),
        quick=True,
    ),
    Fault(
        "RSI: silence of 100 ms",
        "QUICK: for that long the arm's position is unknown, and it stands still under its last command",
        "kuka_rsi",
        (
            *ALWAYS,
            stops(QUICK, "silence", "link lost"),
            comes_to_rest,
            peer_says("stopped by the Stop channel"),
        ),
        ("--stall", "500:0.1"),
    ),
    Fault(
        "RSI: IPOC jumps by 100 s",
        "QUICK: a new session counts corrections from another pose, so that ours would move the arm",
        "kuka_rsi",
        (*ALWAYS, stops(QUICK, "drive fault"), reports("new RSI session")),
        ("--jump", "500:100000"),
    ),
)
