"""Closed-loop simulation beside MuJoCo on the same arm.

The arm is the built-in KR270: six joints, friction, rotors, a spring balancer. Both simulators follow the
same commands under the same cascade, MuJoCo by the exported MJCF and with its loop closed in Python, as one
would write it; times are CPU seconds of one thread, the least of several.
"""

import os
from typing import Any

os.environ["OMP_NUM_THREADS"] = "1"  # before numpy: one thread on both sides

import numpy as np
from common import options, save, show
from parts.simulate import Run, bare, motion_of, ours, theirs

from exidyn.identification.arm.motion import Motion
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.plant import steps
from exidyn.identification.simulation.plant.typical import typical_parts

FINE = 2.5e-4
"""Step of MuJoCo to agree with [s]: its loop is closed once a step, and so lags behind by half of one."""


def against_mujoco(seconds: float, repeats: int) -> dict[str, float]:
    """Real-time factors, and how far the two trajectories are apart."""
    model = read_model("kr270")
    text, control = FORMATS["mjcf"].text(Portable.of(model)), typical_parts(model)[0]
    motion, taken = motion_of(model, seconds), []
    for _ in range(repeats):  # by turns, since the machine may be slower at one time than at another
        we, they = ours(model, control, motion), theirs(text, control, motion)
        taken.append((we.seconds, they.seconds, bare(text, motion)))
    least, length = np.min(taken, axis=0), motion.time[-1]
    how = "without Numba" if steps.compiled(steps.through) is steps.through else "compiled"
    names = (f"exidyn, {how}", "MuJoCo, loop closed in Python", "MuJoCo, steps alone")
    rows = [[name, t, length / t, 1e6 * t / len(motion)] for name, t in zip(names, least, strict=True)]
    head = ["simulator", "CPU s", "times real time", "us a tick"]
    show(f"{length:.0f} s of KR270, steps of 1 ms", head, rows)
    return {
        "real_time_factor": length / least[0],
        "real_time_factor_over_mujoco": least[1] / least[0],
        "real_time_factor_over_mujoco_steps_alone": least[2] / least[0],
        **_apart(motion, we, theirs(text, control, motion, FINE)),
    }


def _apart(motion: Motion, we: Run, they: Run) -> dict[str, float]:
    """Table and figures of the difference to MuJoCo in fine steps."""
    tracking = _rms(we.position - motion.position)
    position = _rms(we.position - they.position)
    torque = _rms((we.torque - they.torque)[1:]) / _rms(we.torque[1:])
    rows = [
        [f"joint{k + 1}", *numbers] for k, numbers in enumerate(zip(tracking, position, torque, strict=True))
    ]
    head = ["", "rms tracking error rad", "rms apart rad", "torque apart, share of rms"]
    show(f"The two simulations, MuJoCo in steps of {1e3 * FINE:g} ms", head, rows)
    return {
        "position_apart_over_tracking_error": float(np.max(position / tracking)),
        "torque_apart": max(torque),
    }


def _rms(values: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(values**2, axis=0))


def main() -> None:
    chosen = options(__doc__.splitlines()[0])
    figures: dict[str, Any] = against_mujoco(*((8.0, 3) if chosen.quick else (12.0, 12)))
    save(chosen.json, figures)


if __name__ == "__main__":
    main()
