"""Servos in the text of an MJCF, against the forces that MuJoCo computes from them.

They have another law than those of the file, or replace its motors while it is simulated.
"""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.robot import ServoLaw
from exidyn.identification.errors import RobotError
from exidyn.identification.export.mjcf_servos import with_controller, with_motors, with_servo_law
from exidyn.identification.robot_files.mjcf_drives import servo_law
from tests.parts.servo_arms import ARM

mujoco = pytest.importorskip("mujoco", minversion="4.0")

JOINTS = ("shoulder", "elbow")
ALL = ("stiffness", "damping", "limit", "delay")
LAW = ServoLaw.of(*np.array([(600.0, 400.0), (60.0, 20.0), (50.0, np.inf), (0.0105, 0.0)]))


def written(text, law=LAW, changed=ALL):
    return with_servo_law(text.encode(), ".", "arm.xml", JOINTS, law, changed).decode()


def test_only_the_servo_that_differs_is_written_and_compiles():
    text = written(ARM)
    assert text.replace("\n", "") != ARM.replace("\n", "")
    changed = [line for line, old in zip(text.splitlines(), ARM.splitlines(), strict=True) if line != old]
    assert len(changed) == 1
    assert 'name="a"' in changed[0]
    law = servo_law(mujoco.MjModel.from_xml_string(written(ARM)), JOINTS)
    for name in ALL:
        np.testing.assert_allclose(getattr(law, name), getattr(LAW, name), rtol=1e-7)


def test_a_step_of_the_command_acts_after_the_delay():
    model = mujoco.MjModel.from_xml_string(written(ARM))
    data, forces = mujoco.MjData(model), []
    data.ctrl[0] = 0.05
    for _ in range(20):
        mujoco.mj_step(model, data)
        forces.append(data.actuator_force[0])
    acting = np.flatnonzero(np.abs(forces) > 15.0)
    assert acting[0] * model.opt.timestep == pytest.approx(0.0105, abs=0.001)


def test_gears_and_general_actuators_and_damping_ratios():
    geared = ARM.replace('kp="800" kv="40"', 'kp="8" dampratio="1" gear="10"')
    model = mujoco.MjModel.from_xml_string(written(geared))
    assert model.actuator_gainprm[0, 0] == pytest.approx(6.0)
    assert model.actuator_biasprm[0, 2] == pytest.approx(-0.6)
    assert model.actuator_forcerange[0, 1] == pytest.approx(5.0)
    general = ARM.replace('<position name="a" joint="shoulder" kp="800" kv="40"/>',
                          '<general name="a" joint="shoulder" gainprm="800" biastype="affine" '
                          'biasprm="0 -800 -40"/>')  # fmt: skip
    law = servo_law(mujoco.MjModel.from_xml_string(written(general)), JOINTS)
    np.testing.assert_allclose(law.stiffness, LAW.stiffness)


def test_a_file_without_servos_is_refused():
    motors = ARM.replace(
        '<position name="a" joint="shoulder" kp="800" kv="40"/>', '<motor joint="shoulder"/>'
    )
    with pytest.raises(RobotError, match="no position servo for every joint"):
        written(motors, replace(LAW))


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
