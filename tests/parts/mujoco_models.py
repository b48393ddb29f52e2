"""Torque of an MJCF by MuJoCo's own inverse dynamics, random motion to compare it in, and patches of it."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.errors import RobotWarning
from exidyn.identification.export import Portable
from exidyn.identification.export.mjcf_patch import patch
from exidyn.identification.fit.identified import Standard
from exidyn.identification.robot_files.robot_file import read_model

mujoco = pytest.importorskip("mujoco")

ONE_BODY = '<geom type="capsule" size=".04" fromto="0 0 0 .3 0 .1" density="700"/>'


def compiled(text_or_path):
    """A model that constraints are left out of: `mj_inverse` counts what they would do too."""
    if isinstance(text_or_path, Path):
        model = mujoco.MjModel.from_xml_path(str(text_or_path))
    else:
        model = mujoco.MjModel.from_xml_string(text_or_path)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return model


def random_motion(dof: int, samples: int = 20, seed: int = 0) -> Motion:
    draw = np.random.default_rng(seed).uniform(-2.0, 2.0, (3, samples, dof))
    return Motion.of(np.arange(samples) * 0.01, *draw)


def inverse(
    model, motion: Motion, joints: tuple[str, ...], held: dict[str, float] | None = None
) -> np.ndarray:
    """`mj_inverse` of the named joints, shape (t, n) [N m]; the others stand at their reference or `held`."""
    data = mujoco.MjData(model)
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) for name in joints]
    places, dofs = model.jnt_qposadr[ids], model.jnt_dofadr[ids]
    torque = np.empty_like(motion.position)
    for row in range(len(motion)):
        data.qpos[:], data.qvel[:], data.qacc[:] = model.qpos0, 0.0, 0.0
        for name, at in (held or {}).items():
            data.qpos[model.jnt_qposadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)]] = at
        data.qpos[places] = motion.position[row]
        data.qvel[dofs], data.qacc[dofs] = motion.velocity[row], motion.acceleration[row]
        mujoco.mj_inverse(model, data)
        torque[row] = data.qfrc_inverse[dofs]
    return torque


def smooth_torque(model, motion: Motion) -> np.ndarray:
    """Nominal torque of one of our models, shape (t, n) [N m], as far as `mj_inverse` has it.

    Dry friction is a constraint in MuJoCo, and an offset would be an actuator's.
    """
    values = model.nominal_values.copy()
    values[[name.startswith(("Fc", "Off")) for name in model.names]] = 0.0
    return model.torque(motion, values)


def require_same(model, text, held=None, share=1e-6):
    """Require that MuJoCo computes the torque of the model from a text, up to a share of the largest."""
    motion = random_motion(model.robot.dof)
    expected = inverse(compiled(text), motion, model.robot.joints, held)
    np.testing.assert_allclose(
        smooth_torque(model, motion), expected, rtol=0, atol=share * np.abs(expected).max()
    )


def read_text(text, folder):
    """The model of an MJCF text, written to a folder; without warnings."""
    (folder / "arm.xml").write_bytes(text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RobotWarning)
        return read_model(folder / "arm.xml")


def patched(model, text, folder):
    """Patch of an MJCF text by a model, whose priors give the intervals."""
    standard = Standard(model.nominal_values, np.diag([prior.std**2 for prior in model.priors]))
    return patch(Portable.of(model), standard, text, str(folder), "arm.xml")
