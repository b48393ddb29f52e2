"""Faults: a study that is stopped in every way, and goes on with nothing repeated."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from common import imports_as_here

from exidyn.acquire.arguments.exit_codes import STOPPED, UNSAFE
from exidyn.identification.robot_files.robot_text import model_text

from .case import Case

FAULTS = {
    "drive fault": "fault elbow at 2",
    "runaway": "runaway elbow 2 at 1",
    "dropped link": "drop at 2 for 0.5",
    "controller gone": "silent at 2",
}
"""Name -> what the simulated controller does."""
WAIT = 300.0
"""For what has to happen [s]."""


def resumed(folder: Path) -> dict[str, bool]:
    """Whether a study goes on behind each fault, with the same motion and all that was done kept."""
    case, study = Case.drawn("nothing", 0), folder / "exidyn-study"
    (folder / "robot.toml").write_text(model_text(case.nominal))
    found, planned = {}, b""
    for name, fault in FAULTS.items():
        process = _begun(folder, "--set", f"faults={fault}")
        process.communicate(timeout=WAIT)
        plan = (study / "round-01" / "plan.toml").read_bytes()
        found[name] = process.returncode in (STOPPED, UNSAFE) and plan == (planned or plan)
        found[name] &= not (study / "round-01" / "run.mcap").exists()
        planned = plan
    found["Ctrl-C"] = _ended(folder, study, signal.SIGINT, lambda: study / "round-01" / "diagnosis.part")
    kept = {path: path.read_bytes() for path in (study / "round-01").glob("*.*") if path.is_file()}
    found["kill"] = _ended(folder, study, signal.SIGKILL, lambda: study / "round-01" / "diagnosis.part")
    last = _begun(folder)
    last.communicate(timeout=WAIT)
    whole = last.returncode == 0 and all(path.read_bytes() == content for path, content in kept.items())
    return {name: one and whole for name, one in found.items()}


def _begun(folder: Path, *more: str) -> "subprocess.Popen[str]":
    words = ["study", "robot.toml", "--length", "6", "--search", "1", "--minutes", "0.2", *more]
    return subprocess.Popen(
        [sys.executable, "-m", "exidyn.acquire.command_line", *words],
        cwd=folder,
        env=imports_as_here(),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def _ended(folder: Path, study: Path, by: signal.Signals, there: Callable[[], Path]) -> bool:
    """Whether a signal ends it once something is there, with nothing half done left under its name."""
    process, end = _begun(folder), time.monotonic() + WAIT
    while not there().exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    process.send_signal(by)
    process.communicate(timeout=WAIT)
    return process.returncode != 0 and not (study / "round-01" / "diagnosis").exists()
