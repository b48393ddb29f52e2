"""The faults of controllers, links and people, each with what must happen and why."""

import os
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from threading import Timer

import numpy as np

from exidyn.acquire.run.perform import Job
from exidyn.drivers import StopLevel
from exidyn.trajectories.families.phases import Phases

from ..controllers import Peer
from ..motion import FR3, START, job
from .checks import (
    all_recorded,
    comes_to_rest,
    ends_orderly,
    goes_on,
    in_state,
    missing,
    no_jump,
    no_old_samples,
    nothing_commanded,
    peer_says,
    reports,
    stops,
    time_goes_on,
)
from .fault import Action, Fault

BRAKE, QUICK = StopLevel.BRAKE, StopLevel.QUICK
ALWAYS = (all_recorded, no_jump, time_goes_on)
BORNE = (*ALWAYS, goes_on)
FEW = 100
"""Cycles that a busy machine may miss by itself in some seconds: 5 %, which a run bears elsewhere."""


def at(cycle: int, action: Callable[[Peer], object]) -> Callable[[Peer], list[Action]]:
    """Do something to the peer in a cycle of the motion."""
    return lambda peer: [(cycle, lambda: action(peer))]


def line(text: str) -> Callable[[Peer], object]:
    """Send the peer what goes wrong."""
    return lambda peer: os.write(peer.process.stdin.fileno(), f"{text}\n".encode())


def halted(seconds: float) -> Callable[[Peer], object]:
    """The peer's process stands still for a while."""

    def act(peer: Peer) -> None:
        peer.process.send_signal(signal.SIGSTOP)
        Timer(seconds, peer.process.send_signal, (signal.SIGCONT,)).start()

    return act


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


def of_franka(seconds: float) -> Job:
    """The motion of seven joints."""
    return job(seconds, FR3)


FRANKA_MOMENT = 1000
"""Cycles of the motion after which a Franka's faults come."""

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
    Fault(
        "Franka: states of 4 ms lost",
        "borne: a command has gone out for each of them, from those that are held back",
        "franka",
        (*BORNE, missing(1, 10 + FEW)),
        acts=at(FRANKA_MOMENT, line("hold 0.004")),
        task=of_franka,
        quick=True,
    ),
    Fault(
        "Franka: silence of 200 ms",
        "QUICK: for that long the arm's position is unknown, and the controller has stopped it",
        "franka",
        (*ALWAYS, stops(QUICK, "silence", "link lost", "drive fault"), comes_to_rest),
        acts=at(FRANKA_MOMENT, line("hold 0.2")),
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
        acts=at(FRANKA_MOMENT, line("reflex joint_reflex")),
        task=of_franka,
    ),
    Fault(
        "Franka: user stop",
        "QUICK: as a reflex",
        "franka",
        (*ALWAYS, stops(QUICK, "drive fault"), comes_to_rest, in_state("robot_mode", 5.0)),
        acts=at(FRANKA_MOMENT, line("user")),
        task=of_franka,
    ),
    Fault(
        "Franka: the process that talks to it is killed",
        "QUICK, which cannot be sent: the controller stops the arm by itself",
        "franka",
        (*ALWAYS, stops(QUICK, "link lost"), peer_says("connection lost while moving")),
        acts=at(FRANKA_MOMENT, kill_its_process),
        task=of_franka,
    ),
    Fault(
        "Franka: connection cut",
        "QUICK, which cannot be sent: the controller stops the arm by itself",
        "franka",
        (*ALWAYS, stops(QUICK, "link lost"), peer_says("connection lost while moving")),
        acts=at(FRANKA_MOMENT, line("cut")),
        task=of_franka,
    ),
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
        (*BORNE, missing(3, 6 + FEW), reports("no whole answer")),
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
