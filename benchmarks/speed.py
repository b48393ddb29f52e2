"""Speed and memory beside FIGAROH and the bare Pinocchio loop, in one run on the same data.

60 s at 500 Hz of a 6-joint arm (built-in cobot) with viscous and Coulomb friction, rotor inertia and
offset. Times are CPU seconds of one thread, the best of several; what is compared is their ratio.
Identification includes filtering, base parameters, solution and standard deviations on both sides. exidyn's
includes its check of units, signs and order of joints, which FIGAROH lacks; the check's share is shown.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"  # before numpy: one thread on both sides

import numpy as np
from common import options, save, show
from parts.figaroh import FigarohArm, Settings, regressor_floor, why_absent

from exidyn.identification.arm.motion import Motion
from exidyn.identification.fit.estimators import weighted
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.model import Model
from exidyn.identification.plausible.gate import doubts
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model, urdf_text
from exidyn.trajectories.random_motion import random_fourier

NOISE = np.array([1.0, 1.0, 0.6, 0.3, 0.3, 0.15])
"""Torque noise of each joint [N m]."""
FILTERS = Filtering(position_cutoff=20.0, torque_cutoff=10.0)
"""10 Hz is what FIGAROH is given too; below it lies a motion of 0.5 Hz with its harmonics."""
CHUNK = 2000


def best(repeats: int, work: Callable[[], Any]) -> tuple[float, Any]:
    """Least CPU time of several calls [s], and what the last one returned."""
    times, result = [], None
    for _ in range(repeats):
        start = time.process_time()
        result = work()
        times.append(time.process_time() - start)
    return min(times), result


def simulated(model: Model, seconds: float) -> tuple[Motion, np.ndarray, np.ndarray]:
    """Motion, measured position and measured torque."""
    motion = random_fourier(model.robot.limits, seconds).at(np.arange(0.0, seconds, 0.002))
    random = np.random.default_rng(0)
    torque = np.concatenate(
        [model.torque(motion[k : k + CHUNK], model.nominal_values) for k in range(0, len(motion), CHUNK)]
    )
    position = motion.position + 5e-6 * random.normal(size=torque.shape)
    return motion, position, torque + NOISE * random.normal(size=torque.shape)


def our_regressor(model: Model, motion: Motion) -> np.ndarray:
    """The whole regressor, formed piece by piece as the identification does."""
    out = np.empty((*motion.position.shape, len(model.names)))
    for start in range(0, len(motion), CHUNK):
        out[start : start + CHUNK] = model.regressor(motion[start : start + CHUNK])
    return out


def recording(model: Model, time_axis: np.ndarray, position: np.ndarray, torque: np.ndarray) -> Recording:
    """The measured signals as a recording."""
    signals = {"position": Signal(time_axis, position), "torque": Signal(time_axis, torque)}
    return Recording("speed", model, signals)


def our_fit(model: Model, time_axis: np.ndarray, position: np.ndarray, torque: np.ndarray) -> Fit:
    """The whole identification; every base parameter is kept, as FIGAROH keeps them."""
    run = recording(model, time_axis, position, torque)
    return identify([run], estimator=weighted, filtering=FILTERS, drop=False)


def against_peers(repeats: int) -> dict[str, float]:
    """Table and figures of regressor and identification."""
    model = read_model("cobot")
    motion, position, torque = simulated(model, 60.0)
    arrays = (motion.position, motion.velocity, motion.acceleration)
    floor, _ = best(repeats, lambda: regressor_floor(model.robot.kinematics, *arrays))
    ours, _ = best(repeats, lambda: our_regressor(model, motion))
    fitting, fit = best(repeats, lambda: our_fit(model, motion.time, position, torque))
    run = recording(model, motion.time, position, torque)
    checking, _ = best(repeats, lambda: doubts([run], model))
    residual = fit.agreement[0].relative
    rows = [
        ["regressor", "bare Pinocchio loop", floor, 1.0, None],
        ["regressor", "exidyn", ours, ours / floor, None],
        ["identification", "exidyn", fitting, 1.0, float(np.max(residual))],
        ["identification", "exidyn, its check alone", checking, checking / fitting, None],
    ]
    figures = {
        "regressor_over_floor": ours / floor,
        "identify_cpu_s": fitting,
        "check_cpu_s": checking,
        "check_share_of_identify": checking / fitting,
    }
    absent = why_absent()
    if absent:
        print(absent)
    else:
        figures |= _figaroh(model, arrays, position, torque, repeats, fitting, ours, rows)
        fit_alone = figures["identify_speedup_over_figaroh"] * fitting / (fitting - checking)
        figures["identify_speedup_over_figaroh_without_check"] = fit_alone
    show("30,000 samples x 6 joints", ["what", "who", "CPU s", "ratio", "worst relative residual"], rows)
    return figures


def _figaroh(
    model: Model,
    arrays: tuple[np.ndarray, ...],
    position: np.ndarray,
    torque: np.ndarray,
    repeats: int,
    fitting: float,
    ours: float,
    rows: list,
) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        urdf = Path(folder) / "arm.urdf"
        urdf.write_text(urdf_text(model))
        arm = FigarohArm(urdf)
    theirs, _ = best(repeats, lambda: arm.regressor(*arrays))
    rows.insert(2, ["regressor", "FIGAROH", theirs, theirs / ours, None])
    speedups = {}
    for name, settings in (
        ("every row, its best filter", Settings.best(decimation=1)),
        ("one row in ten, its defaults", Settings()),
        ("one row in ten, its best filter", Settings.best(decimation=10)),
    ):
        taken, residual = best(repeats, lambda s=settings: arm.identify(position, torque, 500.0, s))
        worst = float(np.max(residual))
        rows.append(["identification", f"FIGAROH, {name}", taken, taken / fitting, worst])
        speedups[name] = taken / fitting
    return {
        "regressor_speedup_over_figaroh": theirs / ours,
        "identify_speedup_over_figaroh": speedups["every row, its best filter"],
        "identify_speedup_over_figaroh_decimated": speedups["one row in ten, its best filter"],
        "identify_speedup_over_figaroh_defaults": speedups["one row in ten, its defaults"],
    }


def long_recording(minutes: float) -> tuple[float, float]:
    """CPU time [s] and peak memory [GiB] of identifying a long recording, in a process of its own."""
    command = [sys.executable, __file__, "--long", str(minutes)]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    taken, memory = text.split()[-2:]
    return float(taken), float(memory)


def _long(minutes: float) -> None:
    model = read_model("cobot")
    motion, position, torque = simulated(model, 60.0 * minutes)
    time_axis = motion.time
    del motion
    start = time.process_time()
    our_fit(model, time_axis, position, torque)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(time.process_time() - start, peak)


def growth(lengths: tuple[float, ...]) -> dict[str, Any]:
    """Time and memory against length."""
    measured = [long_recording(minutes) for minutes in lengths]
    rows = [
        [minutes, taken, taken / minutes, memory]
        for minutes, (taken, memory) in zip(lengths, measured, strict=True)
    ]
    show(
        "A long recording at 500 Hz, data in memory included", ["minutes", "CPU s", "s/min", "peak GiB"], rows
    )
    return {
        "minutes": lengths,
        "identify_cpu_s_by_length": [taken for taken, _ in measured],
        "peak_gib": measured[-1][1],
        "time_per_minute_growth": rows[-1][2] / rows[0][2],
    }


def main() -> None:
    if sys.argv[1:2] == ["--long"]:
        _long(float(sys.argv[2]))
        return
    chosen = options(__doc__.splitlines()[0])
    figures: dict[str, Any] = against_peers(2 if chosen.quick else 5)
    figures |= growth((2.0, 6.0) if chosen.quick else (6.0, 20.0, 60.0))
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
