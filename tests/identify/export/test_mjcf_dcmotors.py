"""A user's MJCF with DC motors: identified numbers are written once, where they belong."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import Prior, StribeckFriction, TorqueRipple
from exidyn.identification.errors import RobotError

from ...parts import mujoco_models
from ...parts.mujoco_models import random_motion, read_text

mujoco = pytest.importorskip("mujoco")
if not hasattr(mujoco.MjModel, "actuator_ctrlspec"):
    pytest.skip(f"MuJoCo {mujoco.__version__} has no dcmotor with inputs", allow_module_level=True)

ARM = """<mujoco>
  <!-- two DC motors -->
  <default><default class="rough">
    <dcmotor motorconst=".05" resistance="2" gear="-20" lugre="1e4 1e-3 .01 .025 3"/>
  </default></default>
  <worldbody><body>
    <inertial pos="0 0 .2" mass="2" diaginertia=".03 .03 .01"/>
    <joint name="shoulder" axis="0 1 0"/>
    <body pos="0 0 .4"><inertial pos=".1 0 .1" mass="1" diaginertia=".01 .01 .01"/>
      <joint name="elbow" axis="1 0 0" damping=".2" armature=".1" frictionloss=".3"/></body>
  </body></worldbody>
  <actuator>
    <dcmotor name="m" class="rough" joint="shoulder" armature="1e-4" damping="1e-3" cogging=".003 6 .4"/>
    <dcmotor joint="elbow" nominal="24 1 500" gear="30" armature="1e-5"/>
  </actuator>
</mujoco>
"""
# At the shoulder: armature 0.04, damping 0.4, Coulomb 0.2, Stribeck 0.3 over 0.15 rad/s.


def nominal_of(text, tmp_path):
    return read_text(text.encode(), tmp_path)


def patched(model, text, tmp_path, **values):
    stated = dict(model.stated) | {name: Prior(value, 0.01) for name, value in values.items()}
    model = replace(model, stated=stated)
    made = mujoco_models.patched(model, text.encode(), tmp_path)
    return made.text.decode(), {(c.where, c.attribute): c for c in made.changes}, made.left_out, model


def require_same_torque(model, text, tmp_path):
    """Require that the file reads back as the model."""
    motion, again = random_motion(2), nominal_of(text, tmp_path)
    torque = [made.torque(motion, made.nominal_values) for made in (again, model)]
    np.testing.assert_allclose(*torque, atol=1e-6)


def lines(text):
    return [line.strip() for line in text.splitlines()]


def test_a_file_with_the_numbers_of_the_model_stays_as_it_is(tmp_path):
    text, changes, _, _ = patched(nominal_of(ARM, tmp_path), ARM, tmp_path)
    assert text == ARM
    assert not changes


def test_numbers_of_a_motor_are_written_at_the_motor(tmp_path):
    found = {"Ia1": 0.02, "Fv1": 0.5, "Fc1": 0.3, "Fs1": 0.1, "Rcos6_1": 0.0, "Rsin6_1": 0.04}
    text, changes, left, model = patched(nominal_of(ARM, tmp_path), ARM, tmp_path, **found)
    require_same_torque(model, text, tmp_path)
    changed = [line for line in lines(text) if line not in lines(ARM)]
    assert changed == [
        '<dcmotor name="m" class="rough" joint="shoulder" armature="5e-05" damping="0.00125" '
        'cogging="0.002 6 0" lugre="10000 0.001 0.015 0.02 3"/>'
    ]
    assert {where for where, _ in changes} == {"actuator 'm'"}
    numbers = {attribute: (c.old, c.new) for (_, attribute), c in changes.items()}
    assert numbers == {
        "armature": (1e-4, pytest.approx(5e-5)),
        "damping": (1e-3, pytest.approx(1.25e-3)),
        "lugre coulomb": (0.01, pytest.approx(0.015)),
        "lugre static": (0.025, pytest.approx(0.02)),
        "cogging amplitude": (0.003, pytest.approx(0.002)),
        "cogging phase": (0.4, pytest.approx(0.0)),
    }
    halves = {attribute: c.half for (_, attribute), c in changes.items()}
    assert halves["lugre static"] == pytest.approx(1.96 * 0.01 * np.sqrt(2) / 20, rel=1e-3)
    assert halves["cogging amplitude"] == pytest.approx(1.96 * 0.01 / 20, rel=1e-3)
    assert halves["cogging phase"] == pytest.approx(1.96 * 0.01 / 0.04, rel=1e-3)
    assert not any("stribeck" in sentence or "ripple" in sentence for sentence in left)


def test_numbers_that_the_joint_has_too_are_written_at_the_joint(tmp_path):
    found = {"Ia2": 0.2, "Fv2": 0.1, "Fc2": 0.5}
    text, changes, _, model = patched(nominal_of(ARM, tmp_path), ARM, tmp_path, **found)
    require_same_torque(model, text, tmp_path)
    assert 'damping="0.1" armature="0.191" frictionloss="0.5"' in text
    assert {where for where, _ in changes} == {"joint 'elbow'"}


def test_damping_of_a_motor_does_not_change_its_motor_constant(tmp_path):
    start = ARM.replace(' armature="1e-5"', ' damping="1e-4"').replace(' damping=".2"', "")
    text, _, _, model = patched(nominal_of(start, tmp_path), start, tmp_path, Fv2=0.3)
    require_same_torque(model, text, tmp_path)
    before, after = (mujoco.MjModel.from_xml_string(t).actuator_gainprm[1] for t in (start, text))
    np.testing.assert_allclose(after, before, rtol=1e-7)


def test_ripple_and_friction_that_were_found_are_written_where_a_motor_can_have_them(tmp_path):
    start = ARM.replace(' cogging=".003 6 .4"', "").replace(".01 .025 3", ".01 .01 3")
    model = nominal_of(start, tmp_path)
    ripple, fading = TorqueRipple(harmonic=4, count=2), StribeckFriction(fade=0.2)
    found = {"Rcos4_1": 0.01, "Rsin8_1": -0.05, "Rsin8_2": -0.3, "Fs1": 0.1, "Fs2": 0.7}
    text, changes, left, model = patched(model + ripple + fading, start, tmp_path, **found)
    assert 'cogging="0.0025 8 3.1415927"' in text
    assert 'lugre="10000 0.001 0.01 0.015 4"' in text
    assert 'cogging="0.01 8 0"' in text
    assert changes["actuator 'm'", "cogging amplitude"].new == pytest.approx(0.05 / 20)
    ripples = [sentence for sentence in left if sentence.startswith("torque_ripple")]
    assert len(ripples) == 1
    assert "Rcos4_1 0.01 N m" in ripples[0]
    assert "Rsin8_1 0 N m" in ripples[0]
    [fading] = [sentence for sentence in left if sentence.startswith("stribeck_friction")]
    assert "Fs2 0.7" in fading
    assert "Fs1" not in fading


def test_more_frictionloss_than_was_found_is_refused(tmp_path):
    start = ARM.replace('axis="0 1 0"', 'axis="0 1 0" frictionloss=".3"')
    with pytest.raises(
        RobotError, match=r"'shoulder' has more frictionloss than the identified 0.2 of joint"
    ):
        patched(nominal_of(start, tmp_path), start, tmp_path, Fc1=0.2)


def test_cogging_that_the_model_does_not_have_stays_and_is_said(tmp_path):
    model = nominal_of(ARM, tmp_path)
    effects = tuple(effect for effect in model.effects if not isinstance(effect, TorqueRipple))
    stated = {name: prior for name, prior in model.stated.items() if not name.startswith("R")}
    text, _, left, _ = patched(replace(model, effects=effects, stated=stated), ARM, tmp_path)
    assert text == ARM
    assert any("cogging of dcmotor 'm' stays in the file" in sentence for sentence in left)


def test_servos_keep_their_damping_beside_motors_with_several_inputs_or_none(tmp_path):
    start = ARM.replace(
        "<actuator>", '<actuator><dcmotor joint="elbow" motorconst="1" resistance="1" input="pos vel"/>'
    ).replace(
        "</actuator>",
        '<position joint="elbow" kp="30" dampratio="1"/><general joint="elbow" biastype="affine" '
        'gainprm="20" biasprm="0 -20 .5"/></actuator>',
    )
    text, changes, _, _ = patched(nominal_of(start, tmp_path), start, tmp_path, Ia2=0.4)
    before, after = (mujoco.MjModel.from_xml_string(t).actuator_biasprm[3:, 2] for t in (start, text))
    np.testing.assert_allclose(after, before, rtol=1e-6)
    assert np.all(before < 0.0)
    assert [attribute for _, attribute in changes].count("kv") == 2
