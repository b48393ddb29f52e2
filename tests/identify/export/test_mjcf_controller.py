"""Servos that replace the motors of a file while it is simulated."""

import numpy as np
import pytest

from exidyn.identification.errors import RobotError
from exidyn.identification.export.mjcf_servos import with_controller, with_motors

mujoco = pytest.importorskip("mujoco")

LEG = b"""<mujoco>
  <default><default class="strong"><motor ctrlrange="-40 40"/></default></default>
  <worldbody>
    <body>
      <joint name="hip" axis="0 1 0"/><geom size="0.1" mass="1"/>
      <body pos="0 0 -0.3"><joint name="knee" axis="0 1 0"/><geom size="0.1" mass="1"/></body>
    </body>
  </worldbody>
  <actuator>
    <motor name="hip" joint="hip" gear="2"  class="strong"/>
    <motor joint='knee' ctrlrange="-10 10"></motor>
  </actuator>
</mujoco>
"""
KP, KD = GAINS = np.array([20.0, 30.0]), np.array([1.5, 0.5])


def test_a_servo_exerts_the_torque_of_the_controller():
    text = with_controller(LEG, "/tmp", "leg.xml", ["hip", "knee"], *GAINS)
    model = mujoco.MjModel.from_xml_string(text.decode())
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = (0.1, 0.2), (0.3, -0.4)
    for command in (0.3, 40.0):
        data.ctrl[:] = command * model.actuator_gear[:, 0]
        mujoco.mj_forward(model, data)
        torque = KP * (command - data.qpos) - KD * data.qvel
        np.testing.assert_allclose(data.qfrc_actuator, np.clip(torque, [-80, -10], [80, 10]))


def test_motors_are_restored_and_other_changes_stay():
    text = with_controller(LEG, "/tmp", "leg.xml", ["hip", "knee"], *GAINS)
    changed = text.replace(b'name="knee"', b'name="knee" damping="2"')
    assert with_motors(text, LEG, "leg.xml") == LEG
    assert with_motors(changed, LEG, "leg.xml") == LEG.replace(b'name="knee"', b'name="knee" damping="2"')


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"motor joint='knee' ctrlrange=\"-10 10\"></motor>", b'position joint="knee"/>', "'actuator2'. Pos"),
        (b"<motor joint='knee' ctrlrange=\"-10 10\"></motor>", b"", "at joint 'knee'; the file has no act"),
    ],
)
def test_a_joint_without_a_plain_motor_is_refused(old, new, message):
    assert old in LEG
    with pytest.raises(RobotError, match=message):
        with_controller(LEG.replace(old, new), "/tmp", "leg.xml", ["hip", "knee"], *GAINS)
