"""Analysis without what only Unix or Linux has: on macOS and Windows."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from exidyn.identification.robot_files.robot_text import model_text

from .parts.small.small_diagnosis import nominal_model, recordings

WITHOUT = """
import os, signal, sys
for name in ("fcntl", "termios", "resource", "pwd", "grp", "pty", "tty"):
    sys.modules[name] = None
gone = {os: ("sched_", "fork", "killpg", "getuid"), signal: ("SIGHUP", "pthread_sigmask")}
for module, starts in gone.items():
    for name in [name for name in dir(module) if name.startswith(starts)]:
        delattr(module, name)
"""
ANALYSIS = """
import exidyn as ex

fit = ex.identify(ex.read("log.csv", "robot.toml"))
ex.report(fit, "report.html")
print(fit)
"""
COMMANDS = """
from exidyn.acquire.commands import COMMANDS, command

for name in COMMANDS:
    command(name).parser()
"""


def run(program: str, folder: Path) -> str:
    """What a program prints that ends well."""
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT + program], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def write_table(recording, path):
    """Position and current of a run as a table with the names that need no option."""
    position, current = recording.signals["position"], recording.signals["current"]
    names = ["t", *(f"{letter}{joint}" for letter in "qi" for joint in (1, 2))]
    rows = np.column_stack([position.time, position.values, current.values])
    np.savetxt(path, rows, delimiter=",", header=",".join(names), comments="")


def test_a_table_is_read_and_its_arm_identified(tmp_path):
    (tmp_path / "robot.toml").write_text(model_text(nominal_model()), encoding="utf-8")
    write_table(recordings()[0], tmp_path / "log.csv")
    assert "parameters" in run(ANALYSIS, tmp_path)
    assert (tmp_path / "report.html").exists()


def test_every_command_can_be_listed_and_explained(tmp_path):
    run(COMMANDS, tmp_path)
