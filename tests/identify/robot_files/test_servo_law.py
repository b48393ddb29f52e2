"""The law of an MJCF's position servos gives the torque that MuJoCo itself applies to the joints."""

from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.robot_files import mjcf_drives
from exidyn.identification.robot_files.mjcf_drives import servo_law

mujoco = pytest.importorskip("mujoco")

JOINTS = ("a", "b", "c")
GEAR = np.array([1.0, -3.0, 0.5])
ARM = """<mujoco>
  <compiler autolimits="true"/>
  <worldbody>
    <body><joint name="a" axis="0 1 0"/><geom size=".1"/>
      <body pos="0 0 .3"><joint name="b" axis="0 1 0"/><geom size=".1"/>
        <body pos="0 0 .3"><joint name="c" axis="1 0 0" actuatorfrcrange="-2 2"/><geom size=".1"/></body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="c" kp="40" kv="3" gear=".5" forcerange="-90 90"/>
    <position joint="a" kp="20" kv=".7"/>
    <motor joint="a"/>
    <position joint="b" kp="9" kv=".2" gear="-3" forcerange="-1.5 1.5" {delay}/>
  </actuator>
</mujoco>"""


def compiled(delay=""):
    return mujoco.MjModel.from_xml_string(ARM.format(delay=delay))


def mujoco_torque(model, command, position, velocity):
    """Torque of the servos on the joints, shape (n,) [N m], for commands in joint positions."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = position, velocity
    data.ctrl[[1, 3, 0]] = GEAR * command
    mujoco.mj_forward(model, data)
    return data.qfrc_actuator


@pytest.mark.parametrize("size", [0.01, 0.2, 5.0])
def test_torque_is_that_of_mujoco(size):
    model = compiled()
    law = servo_law(model, JOINTS)
    np.testing.assert_allclose(law.limit, [np.inf, 4.5, 2.0])
    for command, position, velocity in size * np.random.default_rng(0).normal(size=(20, 3, 3)):
        torque = law.stiffness * (command - position) - law.damping * velocity
        expected = np.clip(torque, -law.limit, law.limit)
        np.testing.assert_allclose(mujoco_torque(model, command, position, velocity), expected, atol=1e-12)


def test_laws_are_read_where_mujoco_has_them():
    if not hasattr(compiled(), "actuator_delay"):
        pytest.skip("MuJoCo has actuator delays since 4.0")
    law = servo_law(compiled('delay="0.02" nsample="10"'), JOINTS)
    np.testing.assert_allclose(law.delay, [0.0, 0.02, 0.0])
    text = ARM.format(delay="").replace('<position joint="a" kp="20" kv=".7"/>', "")
    motors = mujoco.MjModel.from_xml_string(text)
    assert servo_law(motors, JOINTS) is None
    assert servo_law(motors, ("b", "c")) is not None
    filtered = mujoco.MjModel.from_xml_string(ARM.format(delay='timeconst=".1"'))
    assert servo_law(filtered, JOINTS) is None


def test_older_mujoco_has_no_delay(monkeypatch):
    model = compiled()
    kept = [
        name for name in dir(model) if name.startswith(("actuator_", "jnt_")) and name != "actuator_delay"
    ]
    old = SimpleNamespace(nu=model.nu, njnt=model.njnt, **{name: getattr(model, name) for name in kept})
    monkeypatch.setattr(mjcf_drives, "joint_name", lambda _, joint: JOINTS[joint])
    np.testing.assert_array_equal(servo_law(old, JOINTS).delay, np.zeros(3))
