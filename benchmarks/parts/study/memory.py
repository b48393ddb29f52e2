"""Memory: a study of the six joints of the README, with a body on offer, as far as its first choice."""

import os
import subprocess
import sys
from pathlib import Path

from common import imports_as_here

WORDS = ("study", "robot.toml", "--driver", "mock", "--plant", "truth.toml", "--minutes", "0.2")
BODY = ("--mass", "8", "--com", "0.1", "0", "0.1")


def peak_gb(folder: Path, quick: bool) -> float:
    """Largest memory of the process [GB]."""
    run = [sys.executable, "-m", "exidyn.acquire.command_line"]
    subprocess.run(
        [*run, "example", "files", "--output", "."], cwd=folder, env=imports_as_here(), check=True,
        capture_output=True,
    )  # fmt: skip
    length = ["--length", "10", "--search", "1" if quick else "5"]
    process = subprocess.Popen(
        [*run, *WORDS, *BODY, *length], cwd=folder, env=imports_as_here(), stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    _, status, used = os.wait4(process.pid, 0)
    if status:
        raise RuntimeError(f"the study of six joints ended with {os.waitstatus_to_exitcode(status)}")
    return used.ru_maxrss / 2**20
