"""BAM: files in its layout, and its formulas, written down again, have the friction of the effects."""

import json
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.servo_law import ServoLaw
from exidyn.identification.effects import CoulombFriction, LoadDependentFriction, StribeckFriction
from exidyn.identification.errors import RobotError, RobotWarning
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.robot_files.robot_file import read_model

from ...parts.config_stand_ins import run
from ...parts.runs.robots import six_axis
from .test_sdf import portable

LAW = ServoLaw.of(
    np.arange(20.0, 26.0), np.array([0.0, *np.arange(1.0, 6.0)]), np.arange(2.0, 8.0), np.full(6, 0.01)
)
XL330 = {
    "kt": 0.37, "R": 2.8, "armature": 0.0018, "q_offset": 0.027, "friction_base": 0.0048,
    "friction_stribeck": 0.0047, "dtheta_stribeck": 2.9, "alpha": 1.4, "friction_viscous": 0.0054,
    "load_friction_base": 0.12, "load_friction_stribeck": 0.0, "model": "m4", "actuator": "xl330",
}  # fmt: skip
FRICTION = {name: value for name, value in XL330.items() if name not in ("kt", "R", "q_offset")}
"""The part that effects have."""
ROBOT = """
name = "arm"
urdf = "arm.urdf"
[[effect]]
bam = "xl330.json"
"""


def bam_friction(table, motor, external, velocity):
    """`frictionloss + damping * |velocity|` of bam/model.py, `Model.compute_frictions` (M1 to M5)."""
    stribeck, load = table["model"] in ("m2", "m4", "m5"), table["model"] in ("m3", "m4", "m5")
    fading = np.exp(-(np.abs(velocity / table["dtheta_stribeck"]) ** table["alpha"])) if stribeck else 0.0
    if table["model"] == "m5":
        gear = np.abs(external * table["load_friction_external"] - motor * table["load_friction_motor"])
    else:
        gear = np.abs(external - motor) * table.get("load_friction_base", 0.0)
    loss = table["friction_base"] + load * gear
    loss = loss + (fading * table["friction_stribeck"] if stribeck else 0.0)
    return loss + table["friction_viscous"] * np.abs(velocity)


def bam_torque(group, error, velocity):
    """Torque of `VoltageControlledActuator` (bam/actuator.py) with kp = 1 and vin = 1."""
    table = group["model"]
    volts = np.clip(error * group["error_gain"], -group["max_pwm"], group["max_pwm"])
    return table["kt"] * volts / table["R"] - table["kt"] ** 2 * velocity / table["R"]


def arm_with(*effects):
    return replace(portable(six_axis(), *effects), servos=LAW)


def effect_friction(arm, velocity, load, kinds):
    """Torque of friction effects at one velocity of all joints, shape (n,)."""
    motion = Motion.of(np.arange(3) * 0.01, *np.zeros((3, 3, 6)))
    motion = replace(motion, velocity=np.full((3, 6), velocity), load=np.tile(load, (3, 1)))
    shares = arm.model.shares(arm.model.nominal_values)
    return sum(
        (effect.regressor(arm.robot, motion) @ np.maximum(values, 0.0))[0]
        for effect, values in shares
        if isinstance(effect, kinds)
    )


@pytest.mark.parametrize("velocity", [0.05, 0.1, 1.5])
def test_friction_is_that_of_the_effects(velocity):
    kinds = (CoulombFriction, StribeckFriction, LoadDependentFriction)
    arm = arm_with(StribeckFriction(), LoadDependentFriction())
    table, load = json.loads(FORMATS["bam"].text(arm)), np.linspace(-3.0, 3.0, 6)
    expected = effect_friction(arm, velocity, load, kinds)
    for place, joint in enumerate(arm.robot.joints):
        friction = bam_friction(table[joint]["model"], load[place], -load[place], velocity)
        passive = arm.joints.damping[place]
        emf = table[joint]["model"]["kt"] ** 2 / table[joint]["model"]["R"] if place == 0 else 0.0
        assert friction + emf * velocity == pytest.approx(expected[place] + passive * velocity, rel=1e-9)


def test_torque_of_a_slow_servo_is_that_of_its_law():
    table = json.loads(FORMATS["bam"].text(arm_with()))
    for place, group in enumerate(table.values()):
        for error in (-1.0, -0.03, 0.0, 0.02, 2.0):
            expected = np.clip(LAW.stiffness[place] * error, -LAW.limit[place], LAW.limit[place])
            assert bam_torque(group, error, 0.0) == pytest.approx(expected)
    damping = [bam_torque(group, 0.0, -0.01) / 0.01 for group in table.values()]
    np.testing.assert_allclose(damping[1:], LAW.damping[1:])


@pytest.mark.parametrize(
    ("effects", "model"),
    [
        ((), "m1"),
        ((StribeckFriction(),), "m2"),
        ((LoadDependentFriction(),), "m3"),
        ((StribeckFriction(), LoadDependentFriction(preload=0.2)), "m4"),
    ],
)
def test_the_model_is_the_simplest_with_the_effects(effects, model):
    arm = arm_with(*effects)
    table = json.loads(FORMATS["bam"].text(arm))
    assert {group["model"]["model"] for group in table.values()} == {model}
    assert [group["dofs"] for group in table.values()] == [[joint] for joint in arm.robot.joints]
    left = "\n".join(FORMATS["bam"].leaves_out(arm))
    assert "delay of the servos: 0.01 s" in left
    assert "stribeck_friction" not in left
    assert ("away from balance" in left) == (model in ("m3", "m4"))
    assert ("preload 0.2 N m" in left) == (model == "m4")


def test_isaac_lab_has_the_same_servo(monkeypatch):
    arm = arm_with(StribeckFriction(), LoadDependentFriction())
    table = json.loads(FORMATS["bam"].text(arm))
    made = run(FORMATS["isaaclab-bam"].text(arm), monkeypatch)["ACTUATORS"]
    for joint, actuator in made.items():
        motor, file = actuator.motor, table[joint]
        assert motor.model == "m5"
        assert (actuator.kp_fw, actuator.vin, motor.max_pwm, motor.max_current) == (1.0, 1.0, 1.0, 0.0)
        assert (actuator.min_delay, actuator.max_delay) == (2, 2)
        assert motor.error_gain == pytest.approx(file["error_gain"], rel=1e-5)
        assert motor.resistance == pytest.approx(file["model"]["R"], rel=1e-5)
        m5 = vars(motor)
        values = [bam_friction(parameters, 0.7, -0.9, 0.1) for parameters in (m5, file["model"])]
        assert values[0] == pytest.approx(values[1], rel=1e-5)
    assert not any("delay" in line for line in FORMATS["isaaclab-bam"].leaves_out(arm))


def test_arms_without_servos_or_limits_are_refused():
    with pytest.raises(RobotError, match="position servos"):
        FORMATS["bam"].text(portable(six_axis()))
    unlimited = replace(LAW, limit=np.full(6, np.inf))
    with pytest.raises(RobotError, match="torque limit of joint joint1"):
        FORMATS["bam"].text(replace(portable(six_axis(), limited=False), servos=unlimited))


def robot_with(tmp_path, **changes):
    (tmp_path / "arm.urdf").write_text(FORMATS["urdf"].text(portable(six_axis())))
    (tmp_path / "xl330.json").write_text(json.dumps(FRICTION | changes))
    (tmp_path / "robot.toml").write_text(ROBOT)
    return read_model(tmp_path / "robot.toml")


def test_a_file_is_read_as_effects_and_written_again(tmp_path):
    arm = Portable.of(robot_with(tmp_path), servos=LAW)
    for group in json.loads(FORMATS["bam"].text(arm)).values():
        for name in (
            "armature",
            "friction_base",
            "friction_stribeck",
            "dtheta_stribeck",
            "load_friction_base",
        ):
            assert group["model"][name] == pytest.approx(XL330[name]), name
        assert group["model"]["model"] == "m4"


def test_what_effects_lack_is_a_warning(tmp_path):
    parts = ("load_friction_stribeck 0.05", "q_offset 0.027", "kt and R")
    with pytest.warns(RobotWarning, match=".*".join(parts)):
        robot_with(tmp_path, **XL330 | {"load_friction_stribeck": 0.05})


def test_directional_load_friction_is_that_in_balance(tmp_path):
    changes = {"model": "m5", "load_friction_motor": 0.2, "load_friction_external": 0.05}
    with pytest.warns(RobotWarning, match="balanced joint"):
        model = robot_with(tmp_path, **changes, load_friction_base=0.0)
    shares = model.shares(model.nominal_values)
    [mu] = [values[0] for effect, values in shares if isinstance(effect, LoadDependentFriction)]
    friction = bam_friction(XL330 | changes, 1.3, -1.3, 50.0)
    without_load = bam_friction(XL330 | changes, 0.0, 0.0, 50.0)
    assert mu * 1.3 == pytest.approx(friction - without_load)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not JSON"),
        ('{"model": "m7"}', "m1, m2"),
        ('{"model": "m1", "friction_base": "x"}', "friction_base"),
    ],
)
def test_other_files_are_refused(text, message, tmp_path):
    (tmp_path / "arm.urdf").write_text(FORMATS["urdf"].text(portable(six_axis())))
    (tmp_path / "xl330.json").write_text(text)
    (tmp_path / "robot.toml").write_text(ROBOT)
    with pytest.raises(RobotError, match=message):
        read_model(tmp_path / "robot.toml")
