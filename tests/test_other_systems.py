"""Analysis without what only Unix or Linux has: on macOS and Windows."""

import subprocess
import sys

import numpy as np

from exidyn.identification.recordings.mcap.mcap_file import read_recording

PROGRAM = """
import os, signal, sys
for name in ("fcntl", "termios", "resource", "pwd", "grp", "pty", "tty"):
    sys.modules[name] = None
gone = {os: ("sched_", "fork", "killpg", "getuid"), signal: ("SIGHUP", "pthread_sigmask")}
for module, starts in gone.items():
    for name in [name for name in dir(module) if name.startswith(starts)]:
        delattr(module, name)

import exidyn as ex
from exidyn.acquire.commands import COMMANDS, command

fit = ex.identify(ex.read("log.csv", sys.argv[1]))
ex.report(fit, "report.html")
print(fit)
for name in COMMANDS:
    command(name).parser()
"""


def test_a_table_is_read_its_arm_identified_and_every_command_explained(tutorial, tmp_path):
    run = read_recording(tutorial / "run.mcap")
    position, current = run.signals["position"], run.signals["current"]
    rows = np.column_stack([position.time, position.values, current.values])
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header="t,q1,q2,i1,i2", comments="")
    command = [sys.executable, "-c", PROGRAM, tutorial / "robot.toml"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "parameters" in done.stdout
    assert (tmp_path / "report.html").exists()
