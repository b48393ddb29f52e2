"""Whether a person is told that an arm moves, or may: `exidyn record` on a peer that misbehaves."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from exidyn.acquire.run.stopping.stop import WORDS
from exidyn.acquire.terminal.run_summary import UNATTENDED
from exidyn.drivers import StopLevel
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.trajectories.limits.moves import move
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import write_plan
from exidyn.trajectories.trajectory import State

from ...peers.can_arm import canopen_settings, mit_settings
from ...peers.peer_process import Peer
from ...peers.ur_settings import ur_settings
from ..controllers import rsi_controller
from ..controllers.can_peers import peer as can_peer
from .commissioning_parts import POSE, controller_file
from .run_parts import LIMITS, MODEL, START

TICK = 0.04
"""Of the motion [s]: a whole number of all controllers' cycles."""
ALONG = 1.0
"""Time from where a controller takes commands until it misbehaves [s]: in the middle of the motion."""
REAL_TIME = ("--fifo", 70)
"""Of peers, where it is allowed: a controller has a computer of its own."""
ATTEMPTS = 3
"""At a case."""
PATIENCE = 120.0
"""How long a command may take on a busy machine [s]."""
STANDS, MOVES, UNKNOWN = False, True, None
"""Whether the arm moves at the end, as the peer has it; with a lost link nobody knows."""


@dataclass(frozen=True)
class Case:
    """A controller that misbehaves.

    Attributes:
        name: In words.
        cell: Context manager of a folder that gives the peer and the path of its controller file.
        moves: Whether the arm moves at the end.
        levels: Stops that must be in the recording, in order.
        words: What the reason must say.
        lines: What the peer is told once commands are taken; "pause S" stops this computer's program for so
            long [s].
    """

    name: str
    cell: object
    moves: bool | None
    levels: tuple[str, ...]
    words: str = ""
    lines: tuple[str, ...] = ()


@dataclass
class Told:
    """What a person and a program get.

    Attributes:
        code: Exit code.
        page: Standard output.
        errors: Lines of standard error.
        waited: Time from each stop to the line that says so [s]; infinite where there is none.
        table: The JSON.
        recording: The file's own words about its end.
        levels: Stops in the recording, in order.
        info: What `exidyn info` prints.
    """

    code: int
    page: str
    errors: list[str]
    table: dict
    recording: dict = field(default_factory=dict)
    levels: tuple[str, ...] = ()
    info: str = ""
    waited: tuple[float, ...] = ()


def ur(folder):
    return _ur(folder)


@contextmanager
def _ur(folder):
    with Peer("ur_controller.py", "--series", "cb3", *REAL_TIME) as peer:
        given = ur_settings(peer.address) | {"cycle": 0.008, "dead_man": 2.0}
        yield peer, controller_file(folder, "ur_rtde", given), "program started"


def krc(*faults):
    @contextmanager
    def cell(folder):
        config = rsi_controller.config_file(folder)
        start = ",".join(map(str, POSE))
        given = {"controller": "127.0.0.1", "config": str(config), "wait": 20.0, "timeout": 500}
        given |= {"window_lower": -360.0, "window_upper": 360.0, "overall": 360.0, "probe": False}
        wide = ("--axiscorr", 360, "--axiscorrmon", 360, "--timeout", 500, "--seconds", 90, *REAL_TIME)
        with rsi_controller.running(config, *wide, "--start", start, *faults) as peer:
            yield peer, controller_file(folder, "kuka_rsi", given), ""

    return cell


def can(*faults, dead_man=2.0):
    @contextmanager
    def cell(folder):
        wrong = [word for fault in faults for word in ("--fault", fault)]
        with can_peer("can_nodes.py", "--robot", "cobot", "--lockstep", "--fifo", *wrong) as peer:
            given = canopen_settings(peer.address) | {"cycle": 0.01, "dead_man": dead_man, "heartbeat": 0.2}
            yield peer, controller_file(folder, "canopen_402", given), "node 6: enabled"

    return cell


def mit(folder):
    return _mit(folder)


@contextmanager
def _mit(folder):
    with can_peer("mit_motors.py", "--robot", "cobot", "--lockstep", "--fifo", "--cycle", 0.01) as peer:
        given = mit_settings(peer.address) | {"cycle": 0.01, "dead_man": 0.5}
        yield peer, controller_file(folder, "can_mit", given), "motor 6: on"


CASES = (
    Case("UR: clock stands still", ur, STANDS, ("QUICK",), "clock", ("clock stop",)),
    Case("UR: clock goes back", ur, STANDS, ("QUICK",), "clock", ("clock back",)),
    Case("UR: clock is no number", ur, UNKNOWN, ("QUICK",), "", ("clock nan",)),
    Case("UR: clock shows 1e30", ur, UNKNOWN, ("QUICK",), "", ("clock huge",)),
    Case("UR: clock stands still, arm runs on", ur, MOVES, ("OFF",), "", ("clock stop", "runs 0.8")),
    Case("UR: arm runs on", ur, MOVES, ("OFF",), "", ("runs 0.8",)),
    Case("UR: dashboard silent", ur, MOVES, ("OFF",), "", ("dashboard silent", "runs 0.8")),
    Case("UR: dashboard floods", ur, MOVES, ("OFF",), "", ("dashboard flood", "runs 0.8")),
    Case("UR: dashboard ends no line", ur, MOVES, ("OFF",), "", ("dashboard babble", "runs 0.8")),
    Case("UR: arm creeps on", ur, MOVES, ("OFF",), "", ("runs 0.08",)),
    Case("UR: connection cut", ur, UNKNOWN, ("QUICK",), "", ("cut",)),
    Case("UR: power lost", ur, STANDS, ("QUICK",), "power off", ("unpowered",)),
    Case("KUKA: axis runs on", krc("--runs", "400:60"), MOVES, ("OFF",)),
    Case("KUKA: axis creeps on", krc("--runs", "400:5"), MOVES, ("OFF",)),
    Case("KUKA: silent", krc("--mute", "400"), UNKNOWN, ("QUICK",)),
    Case("CAN: joint runs on", can("deaf:2@120"), MOVES, ("OFF",)),
    Case("CAN: joint creeps on", can("creep:2@120"), MOVES, ("OFF",)),
    Case("CAN: power of a drive lost", can("unpowered:2@120"), STANDS, ("QUICK",), "supply"),
    Case(
        "CAN: this computer pauses",
        can(dead_man=0.5),
        STANDS,
        ("QUICK",),
        "sent nothing for",
        ("pause 3",),
    ),
    Case("MIT: this computer pauses", mit, STANDS, ("QUICK",), "sent nothing for", ("pause 3",)),
    Case("UR: this computer pauses", ur, STANDS, ("QUICK",), "", ("pause 3",)),
    Case("CAN: a drive leaves operational", can("leave:2@120"), UNKNOWN, ("QUICK",), "no longer operational"),
)


def told(case, folder):
    """Let it happen, and gather what a person and a program get."""
    motion = move(State.at_rest(START), State.at_rest(START + 0.5), _slow(), TICK)
    write_plan(Plan.of(motion, MODEL, tick=TICK), folder / "plan.toml")
    with case.cell(folder) as (peer, controller, begins):
        command = [
            sys.executable, "-m", "exidyn.acquire.command_line", "record", "plan.toml", "--robot", "cobot",
            "--controller", str(controller), "--yes", "--no-rehearsal", "--approach",
            "-o", "run.mcap", "--json", "run.json",
        ]  # fmt: skip
        environment = {**os.environ, UNATTENDED: "yes"}
        with subprocess.Popen(
            command, cwd=folder, env=environment, text=True, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        ) as process:  # fmt: skip
            if case.lines:
                arguments = peer, begins, case.lines, process.pid
                threading.Thread(target=_misbehave, args=arguments, daemon=True).start()
            errors = []
            reader = threading.Thread(target=_timed, args=(process.stderr, errors), daemon=True)
            reader.start()
            threading.Timer(PATIENCE, process.kill).start()
            page = process.stdout.read()
            process.wait()
            reader.join()
    return _gathered(process.returncode, page, errors, folder)


def _timed(stream, lines):
    """Keep each line and when it came [s since 1970]."""
    for line in stream:
        lines.append((time.time(), line.rstrip("\n")))


def attempted(case, folder):
    """What `told`, `untold` and `wrong` give, tried again where something is amiss, and how often.

    A machine that misses ten milliseconds by itself stops a run for another reason than the case's.
    """
    for attempt in range(1, ATTEMPTS + 1):
        place = folder / f"attempt-{attempt}"
        place.mkdir()
        seen = told(case, place)
        places, bad = untold(case, seen), wrong(case, seen)
        if not (places or bad):
            break
    return seen, places, bad, attempt


def _slow():
    """A tenth of the limits, so that the motion lasts."""
    names = ("velocity", "velocity_lower", "acceleration", "acceleration_lower")
    limits = {name: 0.1 * getattr(LIMITS, name) for name in names}
    return LIMITS.__class__(**{**vars(LIMITS), **limits})


def _misbehave(peer, begins, lines, process):
    peer.wait_for(begins, 60.0)
    time.sleep(ALONG)
    for line in lines:
        if line.startswith("pause"):
            os.kill(process, signal.SIGSTOP)
            time.sleep(float(line.split()[1]))
            os.kill(process, signal.SIGCONT)
        else:
            peer.tell(line)


def _gathered(code, page, errors, folder):
    path = folder / "run.json"
    table = json.loads(path.read_text()) if path.exists() else {}
    found = Told(code, page, [line for _, line in errors], table)
    if (folder / "run.mcap").exists():
        recording = read_recording(folder / "run.mcap")
        found.waited = tuple(_waited(recording, errors))
        found.recording = dict(recording.outcome)
        stops = [event for event in recording.events if event.kind == "stop"]
        found.levels = tuple(str(event.details["level"]) for event in stops)
        command = [sys.executable, "-m", "exidyn.acquire.command_line", "info", "run.mcap"]
        found.info = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False).stdout
    return found


def _waited(recording, lines):
    """Time from each stop in a recording to its line on the terminal [s]."""
    time = recording.signals["position"].time
    for event in recording.events:
        if event.kind == "stop":
            words = WORDS[StopLevel[str(event.details["level"])]]
            told = (when for when, line in lines if line.startswith(f"exidyn: {words}: "))
            yield next(told, float("inf")) - 1e-9 * float(np.interp(event.time, time, recording.host_time))


def untold(case, found):
    """Places that do not say that the arm moves, or may; for an arm that stands, those that say it does."""
    unsafe = case.moves is not STANDS
    words = {True: "STILL MOVES", None: "IS NOT KNOWN", False: ""}[case.moves]
    last = found.errors[-1] if found.errors else ""
    shown = {
        "terminal's last line": words in last and ("EMERGENCY STOP" in last) == unsafe,
        "page": words in _joined(found.page) if unsafe else "EMERGENCY" not in found.page,
        "exit code": found.code == 5 if unsafe else found.code == 1,
        "JSON": found.table.get("moving", "absent") is case.moves,
        "recording": found.recording.get("moving") == str(case.moves),
        "info": words in _joined(found.info) if unsafe else "EMERGENCY" not in found.info,
    }
    return [place for place, right in shown.items() if not right]


def _joined(text):
    return " ".join(text.split())


def wrong(case, found):
    """What else is not as it must be, a sentence each."""
    text = f"{found.table.get('text', '')}"
    bad = [] if "Traceback" not in "\n".join(found.errors) else ["a traceback"]
    if case.levels[-1] not in found.levels:
        bad.append(f"stops are {found.levels}, and {case.levels[-1]} is not among them")
    if case.words not in text:
        bad.append(f"the reason is '{text}', without '{case.words}'")
    if float("inf") in found.waited:
        bad.append("a stop was not printed while the run went on")
    return bad
