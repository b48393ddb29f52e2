"""Real arms of plain MuJoCo: an arm without items is its file, and edits, forces and delays act as stated."""

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")

from parts.simulator.arms import TABLE  # noqa: E402
from parts.simulator.concealed import described  # noqa: E402
from parts.simulator.draws import DRAWS  # noqa: E402
from parts.simulator.judge import tool_error  # noqa: E402
from parts.simulator.motions import commands  # noqa: E402
from parts.simulator.physics import EDITS, FORCES, Item  # noqa: E402
from parts.simulator.real_arm import RealArm  # noqa: E402
from parts.simulator.score import NAMES  # noqa: E402

FILE = """<mujoco model="two">
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <inertial mass="4" pos="0.15 0 0.02" diaginertia="0.03 0.06 0.06"/>
      <joint name="shoulder" axis="0 1 0" range="-2 2" damping="1" armature="0.1"/>
      <body name="lower" pos="0.4 0 0">
        <inertial mass="2" pos="0.1 0 0.01" diaginertia="0.01 0.02 0.02"/>
        <joint name="elbow" axis="0 1 0" range="-2 2" damping="0.5" armature="0.05"/>
        <site name="flange" pos="0.3 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="b" joint="elbow" kp="400" dampratio="1"/>
    <position name="a" joint="shoulder" kp="800" kv="40"/>
  </actuator>
</mujoco>
"""


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "two.xml"
    file.write_text(FILE)
    return file


def moved(path, *items, seconds=8.0):
    """A real arm, and the motion that it makes."""
    nominal = described(path)
    arm = RealArm(path, nominal.robot.joints, items)
    return nominal, arm, arm.follow(*commands(nominal.robot.limits, seconds, 0.004, seed=0))


def test_an_arm_with_nothing_concealed_is_the_simulation_of_its_file(path):
    nominal, arm, motion = moved(path)
    assert tool_error(FILE, nominal.robot, motion) < 1e-4
    assert tool_error(arm.text(), nominal.robot, motion) < 1e-4


@pytest.mark.parametrize(
    "item",
    [
        Item("kp", (0,), {"factor": 0.6}),
        Item("kv", (1,), {"factor": 1.5}),
        Item("forcerange", (1,), {"limit": 2.0}),
        Item("coulomb", (1,), {"frictionloss": 1.0}),
        Item("viscous", (0,), {"damping": 5.0}),
        Item("armature", (1,), {"armature": 0.2}),
        Item("mass", (1,), {"factor": 1.5}),
        Item("tilt", (), {"angle": 0.1, "direction": 0.3}),
        Item("gravcomp", (), {"share": 0.5}),
        Item("spring", (0,), {"stiffness": 20.0, "reference": 0.4}),
        Item("delay", (0, 1), {"seconds": 0.0173}),
    ],
    ids=lambda item: item.kind,
)
def test_the_file_of_the_truth_closes_what_mjcf_can_state(path, item):
    nominal, arm, motion = moved(path, item)
    assert tool_error(FILE, nominal.robot, motion) > 0.2
    assert tool_error(arm.text(), nominal.robot, motion) < 1e-2


@pytest.mark.parametrize(
    "item",
    [
        Item("stribeck", (1,), {"torque": 2.0, "velocity": 0.1}),
        Item("load", (1,), {"mu": 0.2}),
        Item("thermal", (0,), {"damping": 10.0, "beta": 0.05, "rise": 20.0, "tau": 2.0}),
        Item("cable", (1,), {"stiffness": 5.0, "reference": 0.2, "ripple": 2.0, "waves": 8.0}),
    ],
    ids=lambda item: item.kind,
)
def test_forces_are_more_than_a_file_can_state(path, item):
    nominal, arm, motion = moved(path, item)
    error = tool_error(FILE, nominal.robot, motion)
    assert error > 0.2
    assert tool_error(arm.text(), nominal.robot, motion) == pytest.approx(error, rel=1e-3)


def test_the_torque_of_a_log_is_what_moves_the_arm(path):
    """Torque and motion satisfy MuJoCo's inverse dynamics, with the damping of an implicit integrator."""
    _, arm, motion = moved(path, Item("forcerange", (0,), {"limit": 45.0}))
    dofs, data = [place.dof for place in arm.places], mujoco.MjData(arm.model)
    acceleration = np.gradient(motion.velocity, motion.time, axis=0)
    for row in range(200, 900, 100):
        data.qpos[dofs], data.qvel[dofs] = motion.position[row], motion.velocity[row]
        data.qacc[dofs] = acceleration[row]
        mujoco.mj_inverse(arm.model, data)
        assert data.qfrc_inverse[dofs] == pytest.approx(motion.torque[row], abs=0.3)


def test_the_table_has_what_the_benchmark_promises():
    kinds = {words.split()[0] for row in TABLE for words in row.items}
    assert len(TABLE) == 24
    assert sum(not row.items for row in TABLE) == 3
    assert sum(row.log == "torque" for row in TABLE) == 12
    assert {"delay", "kp", "kv", "forcerange", "thermal", "cable"} <= kinds
    assert kinds <= set(DRAWS) == set(NAMES) == {*EDITS, *FORCES, "delay"}


def test_servos_of_a_law_replace_motors_and_keep_their_limits():
    from parts.simulator.recorded_arms import with_servos

    motor = '<motor name="{0}" joint="{1}" ctrlrange="-5 5"/>'
    position = FILE[FILE.index("<position") : FILE.index("  </actuator>")]
    text = FILE.replace(position, motor.format("a", "shoulder") + motor.format("b", "elbow"))
    model = mujoco.MjModel.from_xml_string(with_servos(text, 20.0, 1.5))
    data = mujoco.MjData(model)
    data.qvel[:], data.ctrl[:] = (0.2, 0.0), (0.1, 9.0)
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator == pytest.approx([20.0 * 0.1 - 1.5 * 0.2, 5.0])
