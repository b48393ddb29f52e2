"""A cart on a rail: kilograms, newtons and metres in text, page, files and exports."""

import json
from functools import cache

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import (
    CoulombFriction,
    JointSpring,
    RigidBody,
    RotorInertia,
    ViscousFriction,
)
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import fit_text
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.model import Model
from exidyn.identification.pages.fit_document import report_html
from exidyn.identification.simulation.simulate import simulate
from exidyn.trajectories.random_motion import random_fourier

from ...parts.small.small_fit import summary

OF_TURNING = ("N m", "N·m", "rad", "kg m^2", "kg m²")


@cache
def fit() -> Fit:
    kinematics = pin.Model()
    joint = kinematics.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), "cart")
    kinematics.appendBodyToJoint(joint, pin.Inertia(5.0, np.zeros(3), 0.01 * np.eye(3)), pin.SE3.Identity())
    limits = Limits(*np.outer([-1.0, 1.0, 1.5, 8.0, 100.0, 200.0], np.ones(1)))
    robot = Robot("rail", kinematics, limits=limits, drive_gain=np.array([30.0]))
    model = Model(
        robot, (RigidBody(), RotorInertia(), ViscousFriction(), CoulombFriction(), JointSpring(("cart",)))
    )
    values = dict(zip(model.names, model.nominal_values, strict=True))
    values |= {"Ia1": 2.0, "Fv1": 12.0, "Fc1": 9.0, "Ks1": 40.0, "Ts1": 5.0}
    given = np.array([values[name] for name in model.names])
    time = np.arange(0.0, 12.0, 0.004)
    motions = [random_fourier(limits, 12.0, period=4.0, seed=seed).at(time) for seed in (0, 1)]
    runs = [
        simulate(model, given, robot.drive_gain, motion, model, name=f"run{seed}", seed=seed)
        for seed, motion in enumerate(motions)
    ]
    return identify(runs[:1], runs[1:])


def words_of(text: str) -> str:
    """Without what is no unit: styles and names of colours."""
    return text.partition("</style>")[2] or text


@pytest.mark.parametrize("text", [summary, report_html, fit_text], ids=["text", "page", "file"])
def test_no_unit_of_a_joint_that_turns(text):
    words = words_of(text(fit()))
    found = [unit for unit in OF_TURNING if f" {unit}" in words or f"[{unit}" in words or f'"{unit}' in words]
    assert not found
    for unit in ("N s/m", "kg"):
        assert unit in words


def test_exports_have_the_units_of_a_joint_that_slides():
    portable = Portable.of(identified(fit()))
    table = json.loads(FORMATS["json"].text(portable))
    units = {one["name"]: one["unit"] for row in table["effects"] for one in row.get("parameters", [])}
    assert units == {"Ia1": "kg", "Fv1": "N s/m", "Fc1": "N", "Ks1": "N/m", "Ts1": "N"}
    missing = " ".join(FORMATS["urdf"].leaves_out(portable))
    assert "N/A" in missing
    assert not any(unit in missing for unit in OF_TURNING)
