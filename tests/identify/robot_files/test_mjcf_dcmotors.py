"""DC motors of an MJCF: their mechanics as effects, compared with the forces that MuJoCo computes."""

import warnings

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.errors import RobotError, RobotWarning
from exidyn.identification.robot_files.robot_file import model_text, parse_model, read_model

from ...parts.mujoco_models import inverse, random_motion, smooth_torque

mujoco = pytest.importorskip("mujoco")
if not hasattr(mujoco.MjModel, "actuator_ctrlspec"):
    pytest.skip(f"MuJoCo {mujoco.__version__} has no dcmotor with inputs", allow_module_level=True)

BODIES = """<worldbody><body>
  <inertial pos="0 0 .2" mass="2" diaginertia=".03 .03 .01"/>
  <joint name="shoulder" axis="0 1 0" damping=".3" armature=".02" frictionloss=".1" ref="10"/>
  <body pos="0 0 .4"><inertial pos=".1 0 .1" mass="1" diaginertia=".01 .01 .01"/>
    <joint name="elbow" axis="1 0 0"/></body></body></worldbody>"""

GEARED = """<dcmotor name="m" joint="shoulder" motorconst=".05" resistance="2" gear="-20" armature="1e-4"
  damping="1e-3" lugre="1e4 {bristle} .01 .025 3" cogging=".003 6 .4" {more}/>"""


def arm(*motors, head=""):
    return f"<mujoco>{head}{BODIES}<actuator>{' '.join(motors)}</actuator></mujoco>"


def geared(bristle="0", more=""):
    return GEARED.format(bristle=bristle, more=more)


def model_of(text, tmp_path, robot=""):
    (tmp_path / "arm.xml").write_text(text)
    (tmp_path / "robot.toml").write_text(f'mjcf = "arm.xml"\n{robot}')
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RobotWarning)
        return read_model(tmp_path / ("robot.toml" if robot else "arm.xml"))


def values(model):
    return {name: prior.value for name, prior in model.stated.items() if prior.value}


def mechanics(text, motion, currentless):
    """Torque of the actuators (t, n) without current, with LuGre friction of steady sliding [N m]."""
    model = mujoco.MjModel.from_xml_string(text)
    data, torque = mujoco.MjData(model), np.empty_like(motion.position)
    [dynamics, bias] = model.actuator_dynprm[0], model.actuator_biasprm[0]
    for row in range(len(motion)):
        data.qpos[:], data.qvel[:] = motion.position[row], motion.velocity[row]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        speed = data.actuator_velocity[0]
        if dynamics[5]:
            fade = np.exp(-((speed / bias[5]) ** 2))
            data.act[0] = np.sign(speed) * (bias[3] + (bias[4] - bias[3]) * fade) / dynamics[5]
        if currentless:
            data.ctrl[0] = model.actuator_gainprm[0][1] * speed
        mujoco.mj_fwdActuation(model, data)
        torque[row] = data.qfrc_actuator
    return torque


def sliding(samples=40):
    """Motion that is nowhere so slow that friction reverses."""
    motion = random_motion(2, samples)
    slow = np.sign(motion.velocity) * np.geomspace(0.03, 2.0, samples)[:, None]
    return Motion.of(motion.time, motion.position, slow, motion.acceleration)


def require_torque_of_mujoco(text, tmp_path, currentless=True, robot=""):
    model, motion = model_of(text, tmp_path, robot), sliding()
    plain = mujoco.MjModel.from_xml_string(text)
    plain.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    expected = inverse(plain, motion, model.robot.joints) - mechanics(text, motion, currentless)
    dry = plain.dof_frictionloss * np.sign(motion.velocity)
    np.testing.assert_allclose(model.torque(motion, model.nominal_values), expected + dry, atol=1e-9)
    return model


def test_torque_and_braking_are_those_of_mujoco(tmp_path):
    model = require_torque_of_mujoco(arm(geared()), tmp_path)
    assert values(model) == pytest.approx(
        {"Ia1": 0.02 + 0.04, "Fv1": 0.3 + 0.4, "Fc1": 0.1 + 0.2, "Fs1": 0.3,
         "Rcos6_1": 0.06 * np.sin(0.4), "Rsin6_1": 0.06 * np.cos(0.4)}
    )  # fmt: skip
    [stribeck] = [effect for effect in model.effects if hasattr(effect, "fade")]
    assert stribeck.fade == pytest.approx(3 / 20)
    np.testing.assert_array_equal(model.robot.gear_ratio, [-20, 1])
    motor = '<dcmotor joint="elbow" motorconst=".05" resistance="2" gear="30" input="none"/>'
    model = require_torque_of_mujoco(arm(motor), tmp_path, currentless=False)
    assert values(model)["Fv2"] == pytest.approx(900 * 0.05**2 / 2)
    text = arm(geared(more='group="2"'), head='<option actuatorgroupdisable="2"/>')
    assert values(model_of(text, tmp_path)) == pytest.approx({"Ia1": 0.06, "Fv1": 0.7, "Fc1": 0.1})


@pytest.mark.parametrize("ratio", [1.0, 40.0, -20.0])
def test_waves_of_cogging_are_counted_per_turn_of_the_stated_motor(ratio, tmp_path):
    model = require_torque_of_mujoco(arm(geared()), tmp_path, robot=f"[drive]\ngear_ratio = [{ratio}, 1]")
    [ripple] = [effect for effect in model.effects if hasattr(effect, "harmonic")]
    assert ripple.harmonic == pytest.approx(120 / abs(ratio))


def test_a_robot_toml_keeps_the_motors(tmp_path):
    model, motion = model_of(arm(geared()), tmp_path), sliding()
    again = parse_model(model_text(model))
    torque = [made.torque(motion, made.nominal_values) for made in (model, again)]
    np.testing.assert_allclose(*torque, rtol=1e-12)


def test_a_log_of_simulated_currents_has_the_torque_of_the_model(tmp_path):
    """LuGre bristles, an inductance and a warm winding change the current, not the torque that it exerts."""
    motor = geared("1e-3", 'inductance="0 2e-3" thermal="2 10 0 .004 25 25"')
    text = arm(motor, head='<option timestep="2e-4"><flag contact="disable"/></option>')
    compiled, torque, rows = mujoco.MjModel.from_xml_string(text), [], []
    data = mujoco.MjData(compiled)
    for step in range(20000):
        data.ctrl[0] = 24.0 * np.sin(4.0 * data.time)
        data.qfrc_applied[1] = -5.0 * data.qpos[1] - data.qvel[1]
        mujoco.mj_forward(compiled, data)
        if step % 20 == 0:
            rows.append([data.qpos.copy(), data.qvel.copy(), data.qacc.copy()])
            bare = torque_of_current(compiled, data)
            torque.append([-20 * bare, data.qfrc_applied[1]])
        mujoco.mj_step(compiled, data)
    motion, torque = Motion.of(np.arange(len(rows)) * 4e-3, *np.swapaxes(rows, 0, 1)), np.array(torque)
    model = model_of(text, tmp_path)
    slides = np.abs(motion.velocity[:, 0]) > 0.1
    residual = (model.torque(motion, model.nominal_values) - torque)[slides, 0]
    assert np.ptp(torque[:, 0]) > 5.0
    assert np.sqrt(np.mean(residual**2)) < 0.003 * np.ptp(torque[:, 0])  # reversals within a few samples


def torque_of_current(compiled, data):
    """Torque K i of the motor's current in the next step, before the gear [N m]."""
    current, now = data.act[-1], data.act_dot[-1]
    te = compiled.actuator_dynprm[0][0]
    return 0.05 * (current + now * te * (1 - np.exp(-compiled.opt.timestep / te)))


def test_torque_limits_are_those_of_current_voltage_and_joint(tmp_path):
    motors = (
        geared(more='saturation=".5 0 0"'),
        '<dcmotor joint="elbow" motorconst=".1" resistance="2" input="pos vel ff" gear="3" '
        'controller="5 0 1 0 0 24"/>',
        '<motor joint="elbow" ctrlrange="-2 2" gear="2"/>',
        '<dcmotor joint="elbow" motorconst=".1" resistance="2" input="none"/>',
    )
    np.testing.assert_allclose(model_of(arm(*motors), tmp_path).robot.limits.torque, [10, 3.6 + 4])
    volts = arm(geared(more='ctrlrange="-12 12"'), '<motor joint="elbow" ctrlrange="-2 2"/>')
    np.testing.assert_allclose(model_of(volts, tmp_path).robot.limits.torque, [20 * 0.05 / 2 * 12, 2])


@pytest.mark.parametrize(
    ("head", "joint", "limit"),
    [
        ("", 'actuatorfrcrange="-3 4"', 3),
        ("", 'actuatorfrclimited="false" actuatorfrcrange="-3 4"', np.inf),
        ('<compiler autolimits="false"/>', 'actuatorfrclimited="true" actuatorfrcrange="-3 4"', 3),
        ('<default><joint actuatorfrcrange="-2 2"/></default>', "", 2),
        ('<default><joint actuatorfrcrange="-2 2"/></default>', 'actuatorfrclimited="false"', np.inf),
    ],
)
def test_force_ranges_of_joints_are_torque_limits_where_mujoco_applies_them(head, joint, limit, tmp_path):
    text = arm(head=head).replace('ref="10"', joint)
    assert model_of(text, tmp_path).robot.limits.torque[0] == limit


def test_what_the_model_leaves_out_is_said(tmp_path):
    motor = geared("1e-3", 'inductance="0 2e-3" thermal="2 10 0 .004 25 25"')
    (tmp_path / "arm.xml").write_text(arm(motor))
    with pytest.warns(RobotWarning) as caught:
        read_model(tmp_path / "arm.xml")
    [warning] = [str(entry.message) for entry in caught]
    assert warning.endswith(
        "arm.xml: dcmotor 'm': the model has the torque of the motor's current, 1 N m/A at the joint, "
        "without back-EMF (in a log of voltage or duty cycle, viscous friction of 0.5 N m s/rad); the rise "
        "of the resistance with temperature (0.4 % per kelvin); the delay of the current by its inductance "
        "(2 ms); the bristles of LuGre friction (it reverses at once, not over 1.3e-07 rad)"
    )


@pytest.mark.parametrize(
    ("motors", "message"),
    [
        ((geared(), geared().replace('name="m"', "")), "second dcmotor with lugre at joint 'shoulder'"),
        ((geared(more="").replace('"1e-3"', '"1e-3 1"'),), "'m' has damping that is a polynomial"),
        (
            ('<pid joint="elbow" kp="3" input="pos vel"/>', '<motor joint="shoulder"/>'),
            "'actuator1' has its own physics",
        ),
    ],
)
def test_what_no_model_can_represent_is_refused(motors, message, tmp_path):
    with pytest.raises(RobotError, match=message):
        model_of(arm(*motors), tmp_path)


def test_armature_and_damping_of_several_actuators_add_up(tmp_path):
    text = arm('<motor joint="elbow" gear="3" armature=".01"/>', '<motor joint="elbow" armature=".1"/>',
               '<motor jointinparent="elbow" damping=".2" gear="2"/>')  # fmt: skip
    model, motion = model_of(text, tmp_path), random_motion(2)
    assert values(model) == pytest.approx({"Ia1": 0.02, "Ia2": 0.19, "Fv1": 0.3, "Fv2": 0.8, "Fc1": 0.1})
    plain = mujoco.MjModel.from_xml_string(text)
    plain.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    expected = inverse(plain, motion, model.robot.joints)
    np.testing.assert_allclose(smooth_torque(model, motion), expected, atol=1e-9)
