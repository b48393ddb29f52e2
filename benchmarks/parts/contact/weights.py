"""The servo with known masses: a heavier body than that of the fit, taken as an external force."""

from dataclasses import replace
from typing import Any

import numpy as np
from common import show

from exidyn.identification.contact.contact import observed
from exidyn.identification.contact.wrench import flange_jacobian
from exidyn.identification.effects import LoadDependentFriction
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.robot_files.robot_file import read_model

from ..real.data import FOLDER
from ..real.servo_masses import GAIN, TOLERANCE

TRAIN = ("sin_sin_kp16", "sin_time_square_kp16", "up_and_down_kp16")
RUN = "sin_sin_kp24"
BODIES = (535, 741, 969, 1168)
EARTH = 9.81
BANDWIDTH = 1.0
"""Bandwidth of the observer [Hz]; the weight moves with the arm, so its inertia is an external force too."""


def weights(quick: bool) -> dict[str, Any]:
    """A table: mass added to the lightest body, by a scale and by force over g."""
    rows, errors = [], []
    for arm in ("l100",) if quick else ("l100", "l150"):
        fit = identify([_run(BODIES[0], arm, name) for name in TRAIN])
        for body in BODIES:
            run = _run(body, arm, RUN)
            estimates = observed(fit, run, "", BANDWIDTH)
            robot = fit.model.robot
            data, known = robot.kinematics.createData(), np.isfinite(estimates.torque[:, 0])
            lever = np.array([flange_jacobian(robot, data, q)[2, 0] for q in estimates.position[known]])
            # The vertical force that explains the torque best, by least squares over the run
            force = float(np.sum(lever * estimates.torque[known, 0]) / np.sum(lever**2))
            added = 1e-3 * (body - BODIES[0])
            rows.append([f"{arm} m{body}", added, -force / EARTH, -force / EARTH - added])
            errors.append(-force / EARTH - added)
    header = ["arm and body", "added [kg]", "force / g [kg]", "error [kg]"]
    show("kscale_sts3215: a weight as an external force, fit with 0.535 kg", header, rows)
    return {"error_rms": float(np.sqrt(np.mean(np.square(errors))))}


def _run(body: int, arm: str, name: str) -> Any:
    folder = FOLDER / "kscale_sts3215"
    model = read_model(folder / f"robot_m{BODIES[0]}_{arm}.toml")
    robot = replace(model.robot, drive_gain=np.array([GAIN]), drive_gain_tolerance=np.array([TOLERANCE]))
    model = replace(model, robot=robot, effects=(*model.effects, LoadDependentFriction()))
    return import_source(folder / f"m{body}_{arm}_{name}.csv.gz", model)[0]
