"""Identification of real arms with default settings, held out against other runs of the same arm."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.robot_files.robot_file import read_model

DATA = Path(os.environ.get("EXIDYN_DATA", Path(__file__).parents[3] / "../shared/data"))

pytestmark = pytest.mark.skipif(
    not (DATA / "ur10e_mamedov").is_dir(), reason=f"no real recordings in {DATA}; set EXIDYN_DATA"
)


def with_robot(model, **changes):
    return replace(model, robot=replace(model.robot, **changes))


def test_ur10e_from_currents():
    folder = DATA / "ur10e_mamedov"
    gain = np.array([14.87, 13.26, 11.13, 10.62, 11.03, 11.47])  # published by De Luca
    model = with_robot(read_model(folder / "ur10e.urdf"), drive_gain=gain)
    names = ("20_02_12-40sec_12harm", "20_02_19_15harm50sec", "20_02_12-50sec_12harm")
    *used, other = (import_source(folder / f"id_ur-{name}.csv.gz", model)[0] for name in names)
    agreement = identify(used, [other]).validation[0]
    # the folder's README gets 0.035 to 0.053 from five files; two are a little less
    assert np.all(agreement.relative < 0.06)


def test_kr300_from_motor_side_torque():
    folder = DATA / "kuka_kr300_weigand"
    ratio = np.array([256.857, 267.429, 252.333, 221, 239.619, 154.323])
    model = with_robot(read_model(folder / "kr300.urdf"), gear_ratio=ratio)
    *used, other = (
        import_source(folder / f"2020-10-21_{run}.csv.gz", model, motor_side=["torque"])[0] for run in "ACB"
    )
    # at 48 Hz, where 10 s of this arm still hold motion; its counterbalance is not in the model
    assert np.all(identify(used, [other]).validation[0].relative < 0.3)


def test_panda_from_joint_torque_with_jittering_stamps():
    folder = DATA / "panda_gaz"
    run = import_source(folder / "traj1.csv.gz", read_model(folder / "panda.urdf"))[0]
    fit = identify([run])
    # 5 to 15 Hz: above, the jitter of its stamps is stronger than the motion
    assert fit.filtering.position_cutoff < 20.0
    assert np.all(fit.agreement[0].relative < 0.2)
