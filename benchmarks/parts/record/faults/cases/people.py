"""What people do: an arm elsewhere than it should be, signals from the keyboard."""

import os
import signal
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from exidyn.acquire.run.perform import Job
from exidyn.trajectories.families.phases import Phases

from ...controllers import Peer
from ...motion import START, job
from ..checks import all_recorded, comes_to_rest, nothing_commanded, peer_says, stops
from ..fault import Action, Fault
from .expected import ALWAYS, BRAKE, QUICK


def asks(*numbers: signal.Signals) -> Callable[[Peer], list[Action]]:
    """A person at the keyboard; the next signal comes ten cycles later."""
    return lambda peer: [
        (500 + 10 * place, lambda number=number: os.kill(os.getpid(), number))
        for place, number in enumerate(numbers)
    ]


def from_elsewhere(seconds: float) -> Job:
    """A motion that begins six degrees from where the arm stands."""
    usual = job(seconds)
    return replace(usual, motion=Phases.hold(START + np.radians(6.0), seconds))


FAULTS = (
    Fault(
        "first state six degrees from the command",
        "nothing is commanded: the first command would tear the arm there",
        "canopen_402",
        (all_recorded, stops(BRAKE, "start"), nothing_commanded),
        task=from_elsewhere,
    ),
    Fault(
        "Ctrl-C",
        "BRAKE: along the path's own limits, and all is recorded",
        "canopen_402",
        (*ALWAYS, stops(BRAKE, "asked"), comes_to_rest),
        acts=asks(signal.SIGINT),
    ),
    Fault(
        "Ctrl-C twice",
        "QUICK: somebody who asks again wants it now",
        "canopen_402",
        (*ALWAYS, stops(QUICK, "asked"), comes_to_rest, peer_says(": stopping", 6)),
        acts=asks(signal.SIGINT, signal.SIGINT),
    ),
    Fault(
        "SIGTERM",
        "BRAKE: as Ctrl-C",
        "canopen_402",
        (*ALWAYS, stops(BRAKE, "asked"), comes_to_rest),
        acts=asks(signal.SIGTERM),
    ),
)
