"""The law of servos in the text of an MJCF, against the forces that MuJoCo computes from it."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.servo_law import ServoLaw
from exidyn.identification.errors import RobotError
from exidyn.identification.export.mjcf_servos import with_servo_law
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
