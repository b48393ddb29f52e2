"""What goes wrong with a Franka: lost states, reflexes, its process, its connection."""

import os
import signal
from pathlib import Path

from exidyn.acquire.run.perform import Job

from ...controllers import Peer
from ...motion import FR3, job
from ..actions import at, line
from ..checks import comes_to_rest, in_state, missing, peer_says, stops
from ..fault import Fault
from .expected import ALWAYS, BORNE, FEW, QUICK

MOMENT = 1000
"""Cycles of the motion after which a fault comes."""


def kill_its_process(peer: Peer) -> None:
    """The process of this program that talks to a Franka's controller."""
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_text().split("\0")
            parent = (process / "stat").read_text().rpartition(")")[2].split()[1]
        except OSError:
            continue
        if "exidyn.drivers.franka.fci_process" in words and int(parent) == os.getpid():
            os.kill(int(process.name), signal.SIGKILL)


def of_franka(seconds: float) -> Job:
    """The motion of seven joints."""
    return job(seconds, FR3)


FAULTS = (
    Fault(
        "Franka: states of 4 ms lost",
        "borne: a command has gone out for each of them, from those that are held back",
        "franka",
        (*BORNE, missing(1, 10 + FEW)),
        acts=at(MOMENT, line("hold 0.004")),
        task=of_franka,
        quick=True,
    ),
    Fault(
        "Franka: silence of 200 ms",
        "QUICK: for that long the arm's position is unknown, and the controller has stopped it",
        "franka",
        (*ALWAYS, stops(QUICK, "silence", "link lost", "drive fault"), comes_to_rest),
        acts=at(MOMENT, line("hold 0.2")),
        task=of_franka,
    ),
    Fault(
        "Franka: reflex of a joint",
        "QUICK: the controller has stopped the arm, and the recording has the error",
        "franka",
        (
            *ALWAYS,
            stops(QUICK, "drive fault"),
            comes_to_rest,
            in_state("error", 7.0),
        ),
        acts=at(MOMENT, line("reflex joint_reflex")),
        task=of_franka,
    ),
    Fault(
        "Franka: user stop",
        "QUICK: as a reflex",
        "franka",
        (*ALWAYS, stops(QUICK, "drive fault"), comes_to_rest, in_state("robot_mode", 5.0)),
        acts=at(MOMENT, line("user")),
        task=of_franka,
    ),
    Fault(
        "Franka: the process that talks to it is killed",
        "QUICK, which cannot be sent: the controller stops the arm by itself",
        "franka",
        (*ALWAYS, stops(QUICK, "link lost"), peer_says("connection lost while moving")),
        acts=at(MOMENT, kill_its_process),
        task=of_franka,
    ),
    Fault(
        "Franka: connection cut",
        "QUICK, which cannot be sent: the controller stops the arm by itself",
        "franka",
        (*ALWAYS, stops(QUICK, "link lost"), peer_says("connection lost while moving")),
        acts=at(MOMENT, line("cut")),
        task=of_franka,
    ),
)
