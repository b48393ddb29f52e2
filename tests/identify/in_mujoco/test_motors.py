"""DC motors of a file in a simulation: friction acts once, and currents only where the file drives."""

import warnings

import numpy as np
import pytest

from exidyn.identification.errors import RobotWarning
from exidyn.identification.in_mujoco.attached import Attached
from exidyn.identification.in_mujoco.switched_off import silence
from exidyn.identification.robot_files.robot_file import read_model

mujoco = pytest.importorskip("mujoco")
if not hasattr(mujoco.MjModel, "actuator_ctrlspec"):
    pytest.skip(f"MuJoCo {mujoco.__version__} has no dcmotor with inputs", allow_module_level=True)

ARM = """<mujoco><option timestep="5e-4" integrator="implicitfast"/><worldbody><body>
  <inertial pos="0 0 -.2" mass="2" diaginertia=".03 .03 .01"/>
  <joint name="pivot" axis="0 1 0" armature=".02"/>
  </body></worldbody><actuator>{}</actuator></mujoco>"""
ROUGH = """<dcmotor joint="pivot" motorconst=".05" resistance="2" gear="20" armature="1e-4" {}
  lugre="1e3 1e-2 .02 .05 3" cogging=".01 6 .4"/>"""


def compiled(motor):
    model = mujoco.MjModel.from_xml_string(ARM.format(motor))
    return model, mujoco.MjData(model)


def swung(model, data, steps=3000):
    """Positions (t,) of an arm that falls from 1.2 rad under a slow torque [rad]."""
    mujoco.mj_resetData(model, data)
    data.qpos[0], positions = 1.2, np.empty(steps)
    for step in range(steps):
        data.qfrc_applied[0] = 2.0 * np.sin(3.0 * data.time)
        mujoco.mj_step(model, data)
        positions[step] = data.qpos[0]
    return positions


def test_attached_effects_replace_the_friction_of_motors(tmp_path):
    model, data = compiled(ROUGH.format('input="none"'))
    (tmp_path / "arm.xml").write_text(ARM.format(ROUGH.format('input="none"')))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RobotWarning)
        arm = read_model(tmp_path / "arm.xml")
    before, numbers = swung(model, data), (model.actuator_biasprm.copy(), model.actuator_dynprm.copy())
    with Attached(model, data, arm) as attached:
        assert set(attached.effects) == {"coulomb_friction", "stribeck_friction", "torque_ripple"}
        during = swung(model, data)
    np.testing.assert_allclose(during, before, atol=0.01)
    for after, old in zip((model.actuator_biasprm, model.actuator_dynprm), numbers, strict=True):
        np.testing.assert_array_equal(after, old)
    assert np.ptp(before) > 1.0


@pytest.mark.parametrize(
    "drive",
    [
        'input="voltage"',
        'inductance="0 2e-3"',
        'input="pos vel" controller="5 2 1 0 1 24" thermal="2 9 0 4e-3"',
    ],
)
def test_a_motor_without_current_keeps_its_friction(drive):
    model, data = compiled(ROUGH.format(drive))
    silence(model, [0])
    open_circuit = swung(model, data)
    assert np.all(np.isfinite(open_circuit))
    assert np.all(np.abs(data.qfrc_actuator) < 20 * (0.05 + 0.01) + 0.1)
    # The same friction without an electrical branch: a constant that is nearly zero.
    weak, weak_data = compiled(ROUGH.format('input="none"').replace('motorconst=".05"', 'motorconst="1e-9"'))
    np.testing.assert_allclose(open_circuit, swung(weak, weak_data), atol=1e-6)


def test_a_shorted_motor_brakes_without_drive():
    motor = '<dcmotor joint="pivot" motorconst=".5" resistance="2" gear="5" input="none"/>'
    model, data = compiled(motor)
    before = swung(model, data)
    silence(model, [0])
    np.testing.assert_array_equal(swung(model, data), before)
