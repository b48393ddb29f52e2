"""Torques of exported models beside those of the fit that they come from."""

import mujoco
import numpy as np
import pinocchio as pin
from common import show

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import SpringBalancer
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.robot_files.robot_file import parse_model, read_model
from exidyn.identification.simulation.simulate import simulate

from .runs import motion_of

SLIDING = 10.0
"""Velocities over that of the reversal, above which dry friction has turned wholly."""


def a_fit(seconds: float) -> Fit:
    """What is identified of a simulated recording with noise."""
    model = read_model("kr270")
    motion = motion_of(model, seconds, seed=1)
    recording = simulate(model, model.nominal_values, model.robot.drive_gain, motion, model)
    return identify([recording])


def round_trips(seconds: float) -> dict[str, float]:
    """Torque of the fit, its identified model, and each export, on a motion that the fit has not seen."""
    fit = a_fit(seconds)
    motion = motion_of(fit.model, 20.0)[::5]
    model, portable = identified(fit), Portable.of(identified(fit))
    base = fit.model.regressor(motion)[:, :, fit.base.kept] @ fit.estimate.values
    whole = model.torque(motion, model.nominal_values)
    ways: dict[str, tuple[np.ndarray, np.ndarray]] = {
        "fit, identified": (base, whole),
        "identified, toml": (whole, _of_toml(portable, motion)),
        "identified, mjcf in MuJoCo": (whole, _of_mjcf(portable, motion)),
        "same part of it, urdf in Pinocchio": (_urdf_part(portable, motion), _of_urdf(portable, motion)),
    }
    slide = np.abs(motion.velocity) > SLIDING * np.max(portable.joints.reversal)
    rows = [
        [name, float(_relative(one, other, slide).max()), float(_relative(one, other, slide | True).max())]
        for name, (one, other) in ways.items()
    ]
    show("Torque on a motion held out, worst joint", ["from, to", "sliding", "with reversals"], rows)
    return {
        "consistency_error": rows[0][1],
        "torque_round_trip_error": max(row[1] for row in rows[1:]),
        "torque_round_trip_error_with_reversals": max(row[2] for row in rows[1:]),
    }


def _of_toml(portable: Portable, motion: Motion) -> np.ndarray:
    back = parse_model(FORMATS["toml"].text(portable))
    return back.torque(motion, back.nominal_values)


def _of_mjcf(portable: Portable, motion: Motion) -> np.ndarray:
    arm = mujoco.MjModel.from_xml_string(FORMATS["mjcf"].text(portable))
    data, torque = mujoco.MjData(arm), np.empty_like(motion.position)
    for row in range(len(motion)):
        data.qpos[:], data.qvel[:] = motion.position[row], motion.velocity[row]
        data.qacc[:] = motion.acceleration[row]
        mujoco.mj_inverse(arm, data)
        torque[row] = data.qfrc_inverse - arm.actuator_biasprm[:, 0]
    return torque


def _of_urdf(portable: Portable, motion: Motion) -> np.ndarray:
    arm = pin.buildModelFromXML(FORMATS["urdf"].text(portable))
    data = arm.createData()
    rows = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    bodies = np.array([pin.rnea(arm, data, *row) for row in rows])
    return bodies + arm.damping * motion.velocity + arm.upperDryFrictionLimit * np.sign(motion.velocity)


def _urdf_part(portable: Portable, motion: Motion) -> np.ndarray:
    """Torque of the model without what URDF cannot represent."""
    model, joints = portable.model, portable.joints
    whole = model.torque(motion, model.nominal_values)
    whole = whole - joints.armature * motion.acceleration - joints.constant
    for spring in portable.balancers:
        effect = SpringBalancer(spring.joint, d21=spring.d21, d22=spring.d22, phi=spring.phi)
        whole -= effect.regressor(model.robot, motion) @ [spring.stiffness, spring.preload]
    return whole


def _relative(one: np.ndarray, other: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rms of a difference over the rms, among some samples, shape (n,)."""
    return np.sqrt(np.sum((one - other) ** 2 * rows, axis=0) / np.sum(one**2 * rows, axis=0))
