"""Faults on purpose, of controllers, links and people: how each run must end, and how it ended."""

import os
import signal
import tempfile
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path
from threading import Timer
from typing import Any, NamedTuple

import numpy as np
from common import show

from exidyn.acquire.run.frames import SAMPLE, Unframed, read_cycle
from exidyn.acquire.run.player import RUNNING
from exidyn.acquire.run.recorder import part_of
from exidyn.acquire.run.stopping.stop import StopRequests
from exidyn.drivers import DriverError, StopLevel
from exidyn.identification.errors import ExidynError
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.recording import Recording

from .controllers import ARMS, NoBus, Peer, controller
from .run import COBOT, Ran, job, run

SECONDS = 4.0
"""Duration of the motion that a fault hits."""
CRAWL = 1e-3
"""Displacement in 20 ms below which an arm counts as at rest [rad]."""
SOON = 1.0
"""Longest time to rest after a stop [s]: twice what a jerk-limited stop from full speed takes."""
ATTEMPTS = 3
"""Attempts at a fault: a machine that misses ten milliseconds by itself has another fault."""
QUICK, BRAKE = StopLevel.QUICK, StopLevel.BRAKE
LOST = ("silence", "link lost", "drive fault")
END = "the motion's end"


class Fault(NamedTuple):
    """A fault: its name, the driver, the end that it must have, and how it is made."""

    name: str
    driver: str
    stop: StopLevel | None  # Level of the stop that must follow; none if the run must bear the fault
    reasons: tuple[str, ...] = ()  # Kinds of stop that are allowed
    arguments: str = ""  # Further words of the peer's command line
    # What is sent to the peer in the middle of the motion; "pause S" halts its process for S seconds, "signal
    # NAMES" sends signals to this process
    action: str = ""


FAULTS = (
    Fault("three telegrams lost", "kuka_rsi", None, (), "--drop 500,520-521"),
    Fault("telegrams 20 ms late", "kuka_rsi", None, (), "--delay 500:0.02,600:0.02"),
    Fault("ten telegrams twice", "kuka_rsi", None, (), "--duplicate 500-509"),
    Fault("telegrams in the wrong order", "kuka_rsi", None, (), "--reorder 500,510,520"),
    Fault("silence of 100 ms", "kuka_rsi", QUICK, LOST, "--stall 500:0.1"),
    Fault("IPOC jumps by 100 s", "kuka_rsi", QUICK, ("drive fault",), "--jump 500:100000"),
    Fault("packages 6 ms late", "ur_rtde", None, (), "", "hold 0.006"),
    Fault("silence of 100 ms", "ur_rtde", QUICK, LOST, "", "hold 0.1"),
    Fault("protective stop", "ur_rtde", QUICK, ("drive fault",), "", "protective"),
    Fault("emergency stop", "ur_rtde", QUICK, ("drive fault",), "", "emergency"),
    Fault("speed slider to 50 %", "ur_rtde", QUICK, ("drive fault",), "", "slider 0.5"),
    Fault("program stopped at the pendant", "ur_rtde", QUICK, ("drive fault",), "", "halt"),
    Fault("connection cut", "ur_rtde", QUICK, ("link lost",), "", "cut"),
    Fault("states of 4 ms lost", "franka", None, (), "", "hold 0.004"),
    Fault("silence of 200 ms", "franka", QUICK, LOST, "", "hold 0.2"),
    Fault("reflex of a joint", "franka", QUICK, ("drive fault",), "", "reflex joint_reflex"),
    Fault("user stop", "franka", QUICK, ("drive fault",), "", "user"),
    Fault("connection cut", "franka", QUICK, ("link lost",), "", "cut"),
    Fault("a node silent", "canopen_402", QUICK, ("silence",), "--fault silent:3@800"),
    Fault("EMCY", "canopen_402", QUICK, ("drive fault",), "--fault emergency:2@800"),
    Fault("a drive trips", "canopen_402", QUICK, ("drive fault",), "--fault fault:2@800"),
    Fault("all nodes stand still for 100 ms", "canopen_402", QUICK, ("silence",), "", "pause 0.1"),
    Fault("Ctrl-C", "canopen_402", BRAKE, ("asked",), "", "signal SIGINT"),
    Fault("Ctrl-C twice", "canopen_402", QUICK, ("asked",), "", "signal SIGINT SIGINT"),
    Fault("SIGTERM", "canopen_402", BRAKE, ("asked",), "", "signal SIGTERM"),
    Fault("a motor silent", "can_mit", QUICK, ("silence",), "--fault silent:3@800"),
    Fault("a motor with an error", "can_mit", QUICK, ("drive fault",), "--fault error:3@800"),
    Fault("a reply 7 ms late", "dynamixel", None, (), "", "late 0.007 1"),
    Fault("three replies with a wrong checksum", "dynamixel", None, (), "", "corrupt 12 3"),
    Fault("bytes that were not asked for", "dynamixel", None, (), "", "babble 40"),
    Fault("a servo silent", "dynamixel", QUICK, ("silence",), "", "silent 12"),
    Fault("a servo overloaded", "dynamixel", QUICK, ("drive fault",), "", "error 12 32"),
    Fault("all servos stand still for 100 ms", "dynamixel", QUICK, LOST, "", "pause 0.1"),
)
IN_QUICK = (FAULTS[3], FAULTS[6], FAULTS[13], FAULTS[18])
MOMENT = {"franka": 1000}
"""Cycles of the motion after which an action comes; 500 of other drivers."""


class Trigger:
    """A sink that acts on the peer, or on this process, in a cycle of the motion."""

    failure = ""

    def __init__(self, fault: Fault, peer: Peer | None) -> None:
        self._fault, self._peer, self._count, self._frames = fault, peer, 0, Unframed()

    def put(self, frame: bytes) -> None:
        """Count the cycles of the motion."""
        for kind, body in self._frames.add(frame):
            if kind == SAMPLE and read_cycle(body).stage >= RUNNING:
                self._count += 1
                self._act(self._count - MOMENT.get(self._fault.driver, 500))

    def _act(self, since: int) -> None:
        verb, _, rest = self._fault.action.partition(" ")
        if verb == "signal":  # the next signal comes ten cycles later
            names = rest.split()
            if since % 10 == 0 and 0 <= since // 10 < len(names):
                os.kill(os.getpid(), signal.Signals[names[since // 10]])
        elif verb and since == 0:
            assert self._peer is not None
            if verb == "pause":
                os.kill(self._peer.process.pid, signal.SIGSTOP)
                Timer(float(rest), os.kill, (self._peer.process.pid, signal.SIGCONT)).start()
            else:
                self._peer.tell(self._fault.action)

    def close(self) -> None:
        """There is nothing to close."""


def stopping_time(ran: Ran, recording: Recording) -> float:
    """Time from the first stop until the arm was last seen moving [s]; NaN without a stop."""
    stops = [event.time for event in recording.events if event.kind == "stop"]
    position = recording.signals["position"]
    window = max(round(0.02 / ran.outcome.info.cycle), 1)
    moved = np.abs(position.values[window:] - position.values[:-window])
    moving = position.time[window:][np.nanmax(moved, axis=1, initial=0.0) > CRAWL]
    return max(float(max(moving, default=0.0)) - stops[0], 0.0) if stops else float("nan")


def wrong(fault: Fault, ran: Ran, recording: Recording) -> list[str]:
    """One sentence for everything that is not as it must be."""
    stop, sentences = ran.outcome.stop, []
    lost = ran.outcome.counts.cycles - (len(recording.timing) if recording.timing is not None else 0)
    if lost:
        sentences.append(f"{lost} cycles are not in the recording")
    command = recording.signals.get("command")
    if command is not None and len(command) > 1:
        fastest = recording.robot.limits.velocity * ran.outcome.info.cycle
        if np.max(np.abs(np.diff(command.values, axis=0)) / fastest) > 1.05:
            sentences.append("a command jumps by more than the limits allow")
    if np.any(np.diff(recording.signals["position"].time) <= 0.0):
        sentences.append("samples do not come after the one before")
    if (stop.level if stop else None) != fault.stop or (stop and stop.kind not in fault.reasons):
        sentences.append(f"ended by {stop.text if stop else END}")
    if ran.outcome.escalated:
        sentences.append(f"escalated, though the stop works: {ran.outcome.escalated[0].text}")
    if fault.stop and "link lost" not in fault.reasons[:1] and stopping_time(ran, recording) > SOON:
        sentences.append("still moving after the stop")
    return sentences


def suffered(fault: Fault, folder: Path) -> tuple[str, list[str]]:
    """How a run with the fault went, and what is wrong about it."""
    path, task = folder / "run.mcap", job(SECONDS, ARMS.get(fault.driver, COBOT))
    task = replace(
        task, watch=replace(task.watch, missed=1.0)
    )  # what this machine misses would hide the fault
    try:
        with (
            controller(fault.driver, folder, *fault.arguments.split()) as (driver, peer),
            StopRequests() as requests,
        ):
            ran = run(driver, task, path, requests.look, lambda recorder: [Trigger(fault, peer)])
        recording = read_recording(path if path.exists() else part_of(path))
    except (DriverError, ExidynError, OSError) as error:
        return "an error", [f"{type(error).__name__}: {error}"]
    counts, stop = ran.outcome.counts, ran.outcome.stop
    rest = f", at rest after {stopping_time(ran, recording):.2f} s" if stop else ""
    end = f"{stop.level.name} ({stop.kind}){rest}" if stop else END
    return f"{end}; {counts.skipped} cycles missed, {counts.stale} silent", wrong(fault, ran, recording)


def main(quick: bool, drivers: Collection[str] = ()) -> dict[str, Any]:
    rows: list[Sequence[Any]] = []
    failed, repeated = [], 0
    for fault in IN_QUICK if quick and not drivers else FAULTS:
        if drivers and fault.driver not in drivers:
            continue
        try:
            for attempt in range(1, ATTEMPTS + 1):  # noqa: B007
                with tempfile.TemporaryDirectory() as folder:
                    happened, bad = suffered(fault, Path(folder))
                if not bad:
                    break
        except NoBus as error:
            print(f"{fault.driver}: {error}")
            continue
        must = f"{fault.stop.name} for {' or '.join(fault.reasons)}" if fault.stop else "borne"
        rows.append([fault.driver, fault.name, must, happened, "; ".join(bad) or "ok", attempt])
        failed += [f"{fault.driver}: {fault.name}"] * bool(bad)
        repeated += attempt > 1
    show("Faults", ["driver", "fault", "must", "happened", "", "attempts"], rows)
    return {
        "faults": len(rows),
        "faults_repeated": repeated,
        "faults_failed": len(failed),
        "faults_failed_names": failed,
    }
