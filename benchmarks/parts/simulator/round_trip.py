"""Torque of models read from MJCF beside MuJoCo's own `mj_inverse`."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from common import Kept, show

from exidyn.identification.arm.motion import Motion

from .concealed import read_hinges

SAMPLES = 200


def figures(folder: Path, quick: bool, kept: Kept) -> dict[str, Any]:
    """The largest difference of every model's torque."""
    files = sorted(folder.glob("mjcf/*.xml"))
    errors = {path.stem: round_trip(path, SAMPLES // 10 if quick else SAMPLES) for path in files}
    show("Torque beside mj_inverse", ["model", "largest difference"], [*errors.items()])
    return {"models": len(errors), "round_trip": max(errors.values()), "by_model": errors}


def round_trip(path: Path, samples: int) -> float:
    """Largest difference of torque over the largest one [-]; joints that slide are held, as fingers are."""
    compiled, model = read_hinges(path)
    joints = model.robot.joints
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
