"""Joints that a recording does not contain are held, or follow, in model and simulation alike."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.errors import RobotError
from exidyn.identification.in_mujoco.replay import TORQUE, Run, Simulator
from exidyn.identification.in_mujoco.switched_off import hold_others
from exidyn.identification.robot_files.mjcf import compile_mjcf
from exidyn.identification.robot_files.robot_file import model_text, parse_model, read_model
from exidyn.mujoco import attach

mujoco = pytest.importorskip("mujoco")

FINGERS = """<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody>
    <body name="upper">
      <inertial mass="2" pos="0.15 0 0.02" diaginertia="0.01 0.02 0.02"/>
      <joint name="shoulder" axis="0 1 0" damping="1" armature="0.1"/>
      <body name="hand" pos="0.4 0 0">
        <inertial mass="1" pos="0.05 0 0.01" diaginertia="0.003 0.004 0.004"/>
        <joint name="wrist" axis="0 0 1" damping="0.5" armature="0.05"/>
        <body name="left" pos="0.1 0.02 0">
          <inertial mass="0.3" pos="0.02 0 0" diaginertia="0.0002 0.0003 0.0003"/>
          <joint name="left" type="slide" axis="0 1 0" range="0 0.1"/>
        </body>
        <body name="right" pos="0.1 -0.02 0">
          <inertial mass="0.3" pos="0.02 0 0" diaginertia="0.0002 0.0003 0.0003"/>
          <joint name="right" type="slide" axis="0 1 0" range="-0.1 0"/>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="right" joint2="left" polycoef="0 -1 0 0 0"/></equality>
  <actuator><position joint="left" kp="100"/></actuator>
</mujoco>
"""
HUNG = """<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="implicitfast"/>
  <worldbody>
    <body name="trunk" pos="0 0 0.5">
      <freejoint name="float"/>
      <inertial mass="6" pos="0.02 0 0" diaginertia="0.1 0.1 0.03"/>
      {legs}
    </body>
  </worldbody>
</mujoco>
"""
LEG = """<body name="{side}_hip" pos="0.2 {y} 0">
        <inertial mass="0.7" pos="0 0.02 0.01" diaginertia="0.001 0.001 0.001"/>
        <joint name="{side}_hip" axis="1 0 0" damping="0.6" armature="0.01"/>
        <body name="{side}_calf" pos="0 0 -0.2">
          <inertial mass="0.4" pos="0.01 0 -0.1" diaginertia="0.002 0.002 0.0003"/>
          <joint name="{side}_calf" axis="0 1 0" damping="0.6" armature="0.01"/>
        </body>
      </body>"""
HUNG = HUNG.format(legs=LEG.format(side="left", y=0.1) + LEG.format(side="right", y=-0.1))
SIDEWAYS = (0.0, 0.0, 1.0, np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)
"""The trunk 1 m above the floor, rolled by 90 degrees."""
ARMS = {
    "fingers": (FINGERS, ["shoulder", "wrist"], {"left": 0.05}),
    "some joints": (FINGERS, ["wrist"], {"shoulder": 0.4}),
    "free joint": (HUNG, ["left_hip", "left_calf", "right_hip", "right_calf"], {}),
    "free joint, sideways": (HUNG, ["left_hip", "left_calf", "right_hip", "right_calf"], {"float": SIDEWAYS}),
    "one leg": (HUNG, ["left_hip", "left_calf"], {"float": SIDEWAYS, "right_hip": 0.3}),
}


@pytest.fixture(params=ARMS)
def arm(request, tmp_path):
    """The text of an MJCF and the model of the joints of it that move."""
    text, joints, held = ARMS[request.param]
    (tmp_path / "arm.xml").write_text(text)
    return text, read_model(tmp_path / "arm.xml", joints, held)


def random_run(model, seconds=0.5):
    """A run in which random constant torques accelerate the joints from random positions."""
    rng, n = np.random.default_rng(3), model.robot.dof
    time = np.arange(0.0, seconds, 0.005)
    start, torque = rng.uniform(-0.4, 0.4, n), rng.uniform(-1.0, 1.0, n)
    position, velocity = np.tile(start, (len(time), 1)), np.zeros((len(time), n))
    effort = np.tile(torque, (len(time), 1))
    return Run("random", time, position, velocity, effort, False, None, np.zeros(n))


def integrated(model, run):
    """Positions of the model under the torque of the run, by semi-implicit steps of 0.2 ms, shape (t, n)."""
    robot, step = model.robot, 2e-4
    kinematics, data = robot.kinematics, robot.kinematics.createData()
    armature, damping = (
        model.nominal_values[[k for k, name in enumerate(model.names) if name.startswith(start)]]
        for start in ("Ia", "Fv")
    )
    position, velocity, positions = run.position[0].copy(), np.zeros(robot.dof), []
    for row in range(int(round(run.time[-1] / step)) + 1):
        if row % round((run.time[1] - run.time[0]) / step) == 0:
            positions.append(position.copy())
        mass = pin.crba(kinematics, data, position)
        mass = np.triu(mass) + np.triu(mass, 1).T + np.diag(armature + step * damping)
        bias = pin.nonLinearEffects(kinematics, data, position, velocity)
        velocity = velocity + step * np.linalg.solve(mass, run.effort[0] - bias - damping * velocity)
        position = position + step * velocity
    return np.array(positions)


def test_a_simulation_with_held_joints_moves_like_the_model(arm):
    text, model = arm
    run = random_run(model)
    with Simulator(text, "/tmp", model, TORQUE, attach=False) as simulator:
        [simulated] = simulator.roll([(run, 0, len(run.time) - 1)])
    expected = integrated(model, run)
    assert np.abs(expected[-1] - expected[0]).max() > 0.05
    np.testing.assert_allclose(simulated, expected[1:], atol=2e-3)


def test_a_recording_and_effects_keep_the_held_joints(arm):
    _, model = arm
    read = parse_model(model_text(model))
    assert dict(read.robot.held) == dict(model.robot.held)
    assert list(read.robot.kinematics.jointPlacements) == list(model.robot.kinematics.jointPlacements)
    text, model = arm
    compiled = compile_mjcf(text, "/tmp")
    with attach(compiled, mujoco.MjData(compiled), model) as effects:
        assert effects.effects == ()


def test_fingers_follow_the_held_or_recorded_finger(tmp_path):
    (tmp_path / "arm.xml").write_text(FINGERS)
    model = read_model(tmp_path / "arm.xml", ["shoulder", "wrist", "left"])
    compiled = compile_mjcf(FINGERS, str(tmp_path))
    others, data = hold_others(compiled, model.robot, "arm.xml"), mujoco.MjData(compiled)
    assert not others.held
    data.qpos[:3] = 0.1, 0.2, 0.03
    others.place(compiled, data)
    assert data.qpos[3] == pytest.approx(-0.03)
    (tmp_path / "arm.xml").write_text(FINGERS)
    closed, open_ = (
        read_model(tmp_path / "arm.xml", ["shoulder", "wrist"], held) for held in ({}, {"left": 0.1})
    )
    center = [model.robot.kinematics.inertias[2].lever for model in (closed, open_)]
    np.testing.assert_allclose(*center, atol=1e-12)  # both fingers move apart
    spread = [model.robot.kinematics.inertias[2].inertia[2, 2] for model in (closed, open_)]
    assert spread[1] > spread[0] + 0.005


@pytest.mark.parametrize(
    ("held", "message"),
    [
        ({"float": 0.3}, "joint 'float' has 1 numbers, expected its position"),
        ({"left_hip": (0.1, 0.2)}, "joint 'left_hip' has 2 numbers, expected one number"),
        ({"float": (0.0,) * 7}, "joint 'float' has a quaternion of length 0"),
    ],
)
def test_positions_of_held_joints_have_the_numbers_of_their_kind(held, message, tmp_path):
    (tmp_path / "arm.xml").write_text(HUNG)
    joints = [name for name in ("left_hip", "right_hip") if name not in held]
    with pytest.raises(RobotError, match=message):
        read_model(tmp_path / "arm.xml", joints, held)


def test_a_stated_mounting_applies_to_the_simulation(tmp_path):
    """Gravity in a rolled base acts as in a base that is held rolled."""
    (tmp_path / "arm.xml").write_text(HUNG)
    joints = ["left_hip", "left_calf"]
    rolled = read_model(tmp_path / "arm.xml", joints, {"float": SIDEWAYS})
    level = read_model(tmp_path / "arm.xml", joints)
    kinematics = level.robot.kinematics.copy()
    kinematics.gravity = pin.Motion(np.array([0.0, -9.81, 0.0]), np.zeros(3))
    tilted = replace(level, robot=replace(level.robot, kinematics=kinematics))
    run = random_run(rolled)
    ends = []
    for model in (rolled, tilted):
        with Simulator(HUNG, "/tmp", model, TORQUE, attach=False) as simulator:
            ends.append(simulator.roll([(run, 0, len(run.time) - 1)])[0][-1])
    np.testing.assert_allclose(*ends, atol=1e-9)
