"""Configurations of Isaac Lab and mjlab, run against stand-ins of their classes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.arm.robot import PositionServo
from exidyn.identification.arm.servo_law import ServoLaw
from exidyn.identification.effects import StribeckFriction
from exidyn.identification.export import FORMATS

from ...parts.config_stand_ins import (
    BuiltinPositionActuatorCfg,
    DelayedPDActuatorCfg,
    IdealPdActuatorCfg,
    ImplicitActuatorCfg,
    run,
)
from ...parts.runs.robots import six_axis
from .test_sdf import portable

LAW = ServoLaw(
    stiffness=np.arange(20.0, 26.0),
    damping=np.arange(1.0, 7.0),
    limit=np.array([5.0, 6.0, 7.0, 8.0, np.inf, np.inf]),
    delay=np.array([0.02, 0.0, 0.02, 0.0, 0.0, 0.0]),
    feed_forward=np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0]),
    integral=np.array([0.0, 0.0, 0.0, 4.0, 0.0, 0.0]),
)
ARM_XML = """<mujoco model="arm"><worldbody>
  <body><joint name="a" axis="0 1 0" frictionloss=".1"/><geom size=".1" mass="1"/>
    <body pos="0 0 .3"><joint name="b" axis="0 1 0" damping=".2"/><geom size=".1" mass="1"/></body></body>
</worldbody><actuator>
  <position joint="a" kp="20" kv="2" forcerange="-3 3"/><position joint="b" kp="5" kv=".5" gear="2"/>
</actuator></mujoco>"""


def by_joint(value, joints):
    return np.array([value[joint] for joint in joints] if isinstance(value, dict) else [value] * len(joints))


def matched(configurations, attribute, joints):
    """Each joint's configuration; its name is matched by exactly one expression."""
    return {
        joint: [c for c in configurations if any(re.fullmatch(e, joint) for e in getattr(c, attribute))]
        for joint in joints
    }


def test_isaac_lab_gets_limits_armature_friction_and_servos(monkeypatch):
    servo = PositionServo(np.full(6, 2.0), np.full(6, np.inf))
    arm = portable(six_axis(), StribeckFriction(), servo=servo, drive_gain=np.arange(10.0, 16.0))
    actuator, joints = run(FORMATS["isaaclab"].text(arm), monkeypatch)["ACTUATORS"]["arm"], arm.robot.joints
    assert isinstance(actuator, ImplicitActuatorCfg)
    assert actuator.joint_names_expr == list(joints)
    stribeck = np.maximum([values for _, values in arm.others][0], 0.0)
    expected = {
        "joint_effort_limit": arm.robot.limits.torque, "joint_velocity_limit": arm.robot.limits.velocity,
        "stiffness": 2.0 * np.arange(10.0, 16.0), "damping": np.zeros(6), "armature": arm.joints.armature,
        "friction": arm.joints.dry + stribeck, "dynamic_friction": arm.joints.dry,
        "viscous_friction": arm.joints.damping,
    }  # fmt: skip
    for name, values in expected.items():
        np.testing.assert_allclose(by_joint(getattr(actuator, name), joints), values, rtol=1e-5, err_msg=name)
    assert np.any(stribeck)
    assert actuator.actuator_effort_limit is None
    left = FORMATS["isaaclab"].leaves_out(arm)
    assert any(line.startswith("kinematics and bodies; mass behind each joint: joint1 ") for line in left)
    assert "the velocity over which stribeck_friction fades: 0.1 rad/s" in left
    assert not any("servos" in line or line.startswith("stribeck_friction") for line in left)


def test_isaac_lab_delays_the_joints_whose_servos_are_delayed(monkeypatch):
    arm = replace(portable(six_axis()), servos=LAW)
    names = run(FORMATS["isaaclab"].text(arm), monkeypatch)
    assert names["PHYSICS_STEP"] == 0.005
    delayed, rest = names["ACTUATORS"].values()
    assert (type(delayed), type(rest)) == (DelayedPDActuatorCfg, ImplicitActuatorCfg)
    assert (delayed.min_delay, delayed.max_delay) == (4, 4)
    assert delayed.joint_names_expr == ["joint1", "joint3"]
    np.testing.assert_allclose(by_joint(delayed.stiffness, ("joint1", "joint3")), [20.0, 22.0])
    np.testing.assert_allclose(by_joint(delayed.damping, ("joint1", "joint3")), [1.0, 3.0])
    np.testing.assert_allclose(by_joint(delayed.actuator_effort_limit, ("joint1", "joint3")), [5.0, 7.0])
    assert delayed.joint_effort_limit is None
    expected = np.minimum(arm.robot.limits.torque, LAW.limit)[[1, 3, 4, 5]]
    joints = ("joint2", "joint4", "joint5", "joint6")
    np.testing.assert_allclose(by_joint(rest.joint_effort_limit, joints), expected)


def test_mjlab_gets_an_actuator_per_joint(monkeypatch):
    arm = replace(portable(six_axis()), servos=LAW)
    names = run(FORMATS["mjlab"].text(arm), monkeypatch)
    of_joint = matched(names["ACTUATORS"], "target_names_expr", arm.robot.joints)
    for place, (joint, actuators) in enumerate(of_joint.items()):
        [actuator] = actuators
        assert isinstance(actuator, BuiltinPositionActuatorCfg), joint
        assert actuator.stiffness == LAW.stiffness[place]
        assert actuator.damping == LAW.damping[place]
        assert actuator.effort_limit == min(LAW.limit[place], arm.robot.limits.torque[place])
        assert actuator.delay_min_lag == actuator.delay_max_lag == round(LAW.delay[place] / 0.002)
        numbers = (actuator.armature, actuator.frictionloss, actuator.viscous_damping)
        terms = arm.joints.armature[place], arm.joints.dry[place], arm.joints.damping[place]
        np.testing.assert_allclose(numbers, terms, rtol=1e-5)


def test_mjlab_of_an_arm_without_servos_takes_efforts(monkeypatch):
    arm = portable(six_axis(), StribeckFriction(), limited=False)
    actuators = run(FORMATS["mjlab"].text(arm), monkeypatch)["ACTUATORS"]
    assert {type(actuator) for actuator in actuators} == {IdealPdActuatorCfg}
    assert {(actuator.stiffness, actuator.damping) for actuator in actuators} == {(0.0, 0.0)}
    assert actuators[0].effort_limit == np.inf
    left = FORMATS["mjlab"].leaves_out(arm)
    assert any(line.startswith("stribeck_friction: up to") and "fade 0.1 rad/s" in line for line in left)


@pytest.mark.parametrize("name", ["isaaclab", "mjlab", "urdf", "sdf", "mjcf", "toml"])
def test_what_a_format_lacks_of_the_servos_is_listed(name):
    left = "\n".join(FORMATS[name].leaves_out(replace(portable(six_axis()), servos=LAW)))
    assert "feed-forward of the servos, torque over commanded velocity: joint3 0.3 N m s/rad" in left
    assert "integral part of the servos: joint4 4 N m/(rad s)" in left
    lacks_law = name not in ("isaaclab", "mjlab")
    assert ("delay of the servos: joint1 0.02, joint3 0.02 s" in left) == lacks_law
    assert ("saturation at joint1 5, joint2 6, joint3 7, joint4 8 N m" in left) == lacks_law


def test_an_mjcf_is_exported_with_its_servos(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(ARM_XML)
    assert main(["export", "arm.xml", "--to", "isaaclab", "-o", "actuators.py"]) == 0
    actuator = run((tmp_path / "actuators.py").read_text(), monkeypatch)["ACTUATORS"]["arm"]
    assert actuator.stiffness == {"a": 20.0, "b": 20.0}.get("a")
    assert actuator.damping == 2.0
    assert actuator.joint_effort_limit == {"a": 3.0}
    np.testing.assert_allclose(by_joint(actuator.friction, ("a", "b")), [0.1, 0.0])
