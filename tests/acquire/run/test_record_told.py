"""An arm that still moves, or may, is told of in every place: on real sockets, with peers that misbehave."""

import json
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from threading import Thread, current_thread, main_thread

import pytest

from exidyn.acquire.command_line import main
from exidyn.acquire.run.stopping.stop import WORDS
from exidyn.acquire.terminal.run_summary import UNATTENDED
from exidyn.drivers import StopLevel
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.trajectories.limits.moves import move
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import write_plan
from exidyn.trajectories.trajectory import State

from ...parts.controllers import rsi_controller
from ...parts.controllers.can_peers import peer as can_peer
from ...parts.runs.commissioning_parts import POSE, controller_file
from ...parts.runs.run_parts import LIMITS, MODEL, START
from ...peers.can_arm import canopen_settings, mit_settings
from ...peers.peer_process import Peer
from ...peers.ur_settings import ur_settings

TICK = 0.04
"""Of the motion [s]: a whole number of all controllers' cycles."""
ALONG = 1.0
"""Time from where a controller takes commands until it misbehaves [s]: in the middle of the motion."""
STANDS, MOVES, UNKNOWN = False, True, None
"""Whether the arm moves at the end, as the peer has it; with a lost link nobody knows."""


@dataclass(frozen=True)
class Case:
    """A controller that misbehaves."""

    name: str  # in words
    cell: object  # context manager of a folder that gives the peer and the path of its controller file
    moves: bool | None  # whether the arm moves at the end
    levels: tuple[str, ...]  # stops that must be in the recording, in order
    words: str = ""  # what the reason must say
    # what the peer is told once commands are taken; "pause WAIT S" lets a wait of this program end so much
    # later [s]
    lines: tuple[str, ...] = ()


@dataclass
class Told:
    """What a person and a program get."""

    code: int  # exit code
    page: str  # standard output
    errors: list[str]  # lines of standard error
    table: dict = field(default_factory=dict)  # the JSON
    recording: dict = field(default_factory=dict)  # the file's own words about its end
    levels: tuple[str, ...] = ()  # stops in the recording, in order
    info: str = ""  # what `exidyn info` prints


def ur(folder):
    return _ur(folder)


@contextmanager
def _ur(folder):
    with Peer("ur_controller.py", "--series", "cb3") as peer:
        given = ur_settings(peer.address) | {"cycle": 0.008, "dead_man": 2.0}
        yield peer, controller_file(folder, "ur_rtde", given), "program started"


def krc(*faults):
    @contextmanager
    def cell(folder):
        config = rsi_controller.config_file(folder)
        start = ",".join(map(str, POSE))
        given = {"controller": "127.0.0.1", "config": str(config), "wait": 20.0, "timeout": 500}
        given |= {"window_lower": -360.0, "window_upper": 360.0, "overall": 360.0, "probe": False}
        wide = ("--axiscorr", 360, "--axiscorrmon", 360, "--timeout", 500, "--seconds", 90)
        with rsi_controller.running(config, *wide, "--start", start, *faults) as peer:
            yield peer, controller_file(folder, "kuka_rsi", given), ""

    return cell


def can(*faults, dead_man=2.0):
    @contextmanager
    def cell(folder):
        wrong = [word for fault in faults for word in ("--fault", fault)]
        with can_peer("can_nodes.py", "--robot", "cobot", *wrong) as peer:
            given = canopen_settings(peer.address) | {"cycle": 0.01, "dead_man": dead_man, "heartbeat": 0.2}
            yield peer, controller_file(folder, "canopen_402", given), "node 6: enabled"

    return cell


def mit(folder):
    return _mit(folder)


@contextmanager
def _mit(folder):
    with can_peer("mit_motors.py", "--robot", "cobot", "--cycle", 0.01) as peer:
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
        ("pause sleep 3",),
    ),
    Case("MIT: this computer pauses", mit, STANDS, ("QUICK",), "sent nothing for", ("pause sleep 3",)),
    Case("UR: this computer pauses", ur, STANDS, ("QUICK",), "", ("pause readable 3",)),
    Case("CAN: a drive leaves operational", can("leave:2@120"), UNKNOWN, ("QUICK",), "no longer operational"),
)


def told(case, folder):
    """Let it happen, and gather what a person and a program get."""
    motion = move(State.at_rest(START), State.at_rest(START + 0.5), _slow(), TICK)
    write_plan(Plan.of(motion, MODEL, tick=TICK), folder / "plan.toml")
    with case.cell(folder) as (peer, controller, begins):
        if case.lines:
            peer.clock.start(Thread(target=_misbehave, args=(peer, begins, case.lines)))
        files = ["-o", folder / "run.mcap", "--json", folder / "run.json"]
        found = _command(
            *("record", folder / "plan.toml", "--robot", "cobot", "--controller", controller),
            *("--yes", "--no-rehearsal", "--approach", *files),
        )
    found.table = json.loads((folder / "run.json").read_text())
    recording = read_recording(folder / "run.mcap")
    found.recording = dict(recording.outcome)
    stops = [event for event in recording.events if event.kind == "stop"]
    found.levels = tuple(str(event.details["level"]) for event in stops)
    found.info = _command("info", folder / "run.mcap").page
    return found


def _command(*words):
    """Exit code and output of a command."""
    page, errors = StringIO(), StringIO()
    with redirect_stdout(page), redirect_stderr(errors):
        code = main(list(map(str, words)))
    return Told(code, page.getvalue(), errors.getvalue().splitlines())


def _slow():
    """A tenth of the limits, so that the motion lasts."""
    names = ("velocity", "velocity_lower", "acceleration", "acceleration_lower")
    limits = {name: 0.1 * getattr(LIMITS, name) for name in names}
    return LIMITS.__class__(**{**vars(LIMITS), **limits})


def _misbehave(peer, begins, lines):
    peer.wait_for(begins)
    peer.clock.sleep(ALONG)
    for line in lines:
        if line.startswith("pause"):
            _, wait, seconds = line.split()
            _pause(peer.clock, wait, float(seconds))
        else:
            peer.tell(line)


def _pause(clock, wait, seconds):
    """Let the run's next wait of a kind, "sleep" or "readable", end so much later."""
    in_time = getattr(clock, wait)

    def late(*arguments):
        if current_thread() is not main_thread():
            return in_time(*arguments)
        delattr(clock, wait)
        ready = in_time(*arguments)
        clock.sleep(seconds)
        return ready

    setattr(clock, wait, late)


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
    for words in (WORDS[StopLevel[level]] for level in found.levels):
        if not any(line.startswith(f"exidyn: {words}: ") for line in found.errors):
            bad.append(f"'{words}' was not printed")
    return bad


SHOWN = (
    "UR: clock stands still, arm runs on", "UR: clock is no number", "UR: arm creeps on",
    "UR: connection cut", "KUKA: axis runs on", "CAN: power of a drive lost",
    "CAN: a drive leaves operational", "CAN: this computer pauses",
)  # fmt: skip
"""One of each kind; `./check --long` runs all."""
ALL = [
    pytest.param(case, marks=[pytest.mark.long] * (case.name not in SHOWN), id=case.name) for case in CASES
]


@pytest.mark.parametrize("case", ALL)
def test_what_the_arm_does_at_the_end_is_told_everywhere(case, tmp_path, monkeypatch):
    monkeypatch.setenv(UNATTENDED, "yes")
    seen = told(case, tmp_path)
    assert untold(case, seen) == [], seen
    assert wrong(case, seen) == [], seen
