"""Torque of arms from MJCF beside MuJoCo's own inverse dynamics, on models as users have them.

`EXIDYN_DATA` names the folder of data, with models in `mjcf`. The figure is the largest difference of a
joint's torque over the largest torque, in random motion, without dry friction, a constraint in MuJoCo.
"""

import argparse
import json
import os
import warnings
from pathlib import Path

import mujoco
import numpy as np

from exidyn.identify.arm.motion import Motion
from exidyn.identify.errors import RobotWarning
from exidyn.identify.robot_files.description import movable_joints
from exidyn.identify.robot_files.robot_file import read_model

SAMPLES = 200


def round_trip(path: Path, samples: int) -> float:
    """Largest difference of torque over the largest one [-]; joints that slide are held, as fingers are."""
    compiled = mujoco.MjModel.from_xml_path(str(path))
    free, _ = movable_joints(path)
    joints = [name for name in free if compiled.joint(name).type[0] == mujoco.mjtJoint.mjJNT_HINGE]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RobotWarning)  # of gravcomp
        model = read_model(path, joints)
    draw = np.random.default_rng(0).uniform(-2.0, 2.0, (3, samples, len(joints)))
    values = model.nominal_values
    values[[name.startswith("Fc") for name in model.names]] = 0.0
    ours = model.torque(Motion.of(np.arange(samples) * 0.01, *draw), values)
    compiled.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data, theirs = mujoco.MjData(compiled), np.empty_like(ours)
    dofs = [int(compiled.joint(name).dofadr[0]) for name in joints]
    for row, (position, velocity, acceleration) in enumerate(zip(*draw, strict=True)):
        data.qpos[:] = compiled.qpos0
        data.qpos[dofs], data.qvel[dofs], data.qacc[dofs] = position, velocity, acceleration
        mujoco.mj_inverse(compiled, data)
        theirs[row] = data.qfrc_inverse[dofs]
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer samples")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    given = parser.parse_args()
    files = sorted((Path(os.environ.get("EXIDYN_DATA", "")) / "mjcf").glob("*.xml"))
    if not files:
        parser.error("no models: EXIDYN_DATA names no folder with mjcf/*.xml")
    errors = {path.stem: round_trip(path, SAMPLES // 10 if given.quick else SAMPLES) for path in files}
    for name, error in errors.items():
        print(f"{name:16} {error:.1e}")
    if given.json:
        table = {"models": len(errors), "round_trip": max(errors.values()), "by_model": errors}
        given.json.write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
    main()
