"""Effects added to recordings: their torque, whether it can be seen, and the scores."""

import numpy as np
import pytest
from injected import SETS, names, score, with_torque
from parts.diagnose_real.sets import CASES
from parts.injected.background import Background
from parts.injected.effects import EFFECTS

from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.effects import JointSpring

from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import record


@pytest.fixture(scope="module")
def ground():
    return Background(nominal_model(), record(roles=("identify", "identify", "validate")))


def test_what_the_nominal_model_explains_is_not_visible(ground):
    viscous = [0.7 * motion.velocity for motion in ground.motions]
    waves = [0.7 * np.sin(8.0 * motion.position) for motion in ground.motions]
    assert ground.visible(viscous) < 1e-3
    assert ground.visible(waves) > 1.0
    assert ground.visible([3.0 * one for one in waves]) == pytest.approx(3.0 * ground.visible(waves))


def test_the_load_is_the_torque_without_friction(ground):
    left = np.concatenate(ground.torques) - np.concatenate(ground.loads)
    speed = np.concatenate([motion.velocity for motion in ground.motions])
    assert np.all([np.corrcoef(np.sign(v), own)[0, 1] > 0.8 for v, own in zip(speed.T, left.T, strict=True)])


def test_every_effect_has_finite_torque_on_its_joints_or_none(ground):
    for name, effect in EFFECTS.items():
        added = effect(ground, 1, np.random.default_rng(0))
        if added is None:
            assert name == "contact_event"  # two joints alone would not feel it as an arm does
            continue
        torque = np.concatenate(added.torques)
        assert np.all(np.isfinite(torque))
        assert np.any(torque != 0.0)
        acting = added.joints or (0, 1)
        assert not np.any(np.delete(torque, acting, axis=1))


def test_an_effect_that_is_added_is_what_the_diagnosis_sees(ground):
    assert names(diagnose(ground.model, ground.runs)) == {}
    spring = JointSpring(("elbow",))
    torques = [spring.regressor(ground.model.robot, motion)[:, :, 0] * 6.0 for motion in ground.motions]
    found = names(diagnose(ground.model, with_torque(ground, torques)))
    assert list(found) == [("joint_spring", (1,))]


def line(named, probability, false=(), open_=()):
    return {
        "effect": "joint_spring", "joints": [1], "named": named, "probability": probability,
        "false": list(false), "lost": [], "open": list(open_),
    }  # fmt: skip


def test_the_score_compares_stated_probabilities_with_how_many_are_right():
    lines = [
        line(True, 0.97),
        line(True, 0.96, false=[["payload", [], 0.98]]),
        line(False, 0.6, open_=[["joint_spring", [1], 0.6], ["torque_ripple", [1], 0.4]]),
    ]
    figures = score(lines)
    assert figures["named_percent"] == pytest.approx(200 / 3)
    assert (figures["false_names"], figures["cases_with_false_name"]) == (1, 1)
    by_class = {tuple(one[:2]): one[2:] for one in figures["calibration"]}
    count, stated, right = by_class[0.95, 0.99]
    assert (count, stated, right) == (3, pytest.approx(0.97), pytest.approx(2 / 3))
    assert by_class[0.5, 0.8][2] == 1.0
    assert by_class[0.0, 0.5][2] == 0.0


def test_every_set_is_one_of_the_diagnosis():
    assert set(SETS) <= set(CASES)
