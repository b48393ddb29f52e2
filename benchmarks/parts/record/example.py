"""README's first command: how long it takes, and whether what it finds is inside its intervals."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from common import show

from exidyn.acquire.examples.example_arm import BODY
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.robot_files.robot_file import read_model

INSIDE = 1.96
"""Deviation of 95 % of normal numbers [standard deviations]."""

LENGTHS = {True: ("--length", "20", "--search", "2"), False: ()}
"""Options of the command, in a hurry and not."""


def main(quick: bool) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        began = time.monotonic()
        command = [
            str(Path(sys.executable).with_name("exidyn")),
            "example",
            "--output",
            folder,
            *LENGTHS[quick],
        ]
        subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=True)
        seconds = time.monotonic() - began
        fit = read_fit(Path(folder) / "fit.json")
    error = errors(fit)
    inside = float(np.mean(np.abs(error) < INSIDE))
    joints = len(fit.estimate.gain)
    header = ["seconds", "base parameters", "drive gains", "truth in 95 % %", "most std off"]
    row = [seconds, len(error) - joints, joints, 100 * inside, np.max(np.abs(error))]
    show("Excite, record three runs on the mock, identify: exidyn example", header, [row])
    return {"example_seconds": seconds, "example_inside": inside}


def errors(fit: Fit) -> np.ndarray:
    """Base parameters (b,), then drive gains (n,), away from the truth [standard deviations]."""
    truth = read_model("kr270")
    true = dict(zip(truth.names, truth.nominal_values, strict=True))
    true |= {f"{name}L": value for name, value in BODY}
    values = np.array([true[parameter.name] for parameter in fit.base.parameters])
    parameters = (fit.estimate.values - fit.base.regrouping @ values) / fit.estimate.std
    gains = (fit.estimate.gain - truth.robot.drive_gain) / fit.estimate.gain_std
    return np.concatenate([parameters, gains])
