"""Wrong columns, units, signs and robots are named before anything is fitted."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identify.arm.motion import Motion
from exidyn.identify.arm.rigid_regressor import rigid_regressor
from exidyn.identify.effects.spring_balancer import SpringBalancer
from exidyn.identify.errors import WrongInput
from exidyn.identify.fit.identification import identify
from exidyn.identify.plausible.coupled import Coupled
from exidyn.identify.plausible.drives import Gain, as_stated
from exidyn.identify.plausible.gate import _sampled, require_plausible, suspect
from exidyn.identify.plausible.hypotheses import under_gravity
from exidyn.identify.plausible.suspicion import Suspicion
from exidyn.identify.recordings.recording import Recording, Signal
from exidyn.identify.robot_files.robot_file import read_model

from ...parts.runs.logs import cobot_log, kr270_log

pytestmark = pytest.mark.numerical

LOG = cobot_log()
ARM = LOG.model.robot


def recording(position=LOG.position, current=LOG.current, model=LOG.model):
    signals = {"position": Signal(LOG.time, position), "current": Signal(LOG.time, current)}
    return Recording("log", model, signals)


def exchanged(values, a, b):
    columns = np.arange(values.shape[1])
    columns[[a, b]] = b, a
    return values[:, columns]


def scaled(values, joint, factor):
    return values * np.where(np.arange(values.shape[1]) == joint, factor, 1.0)


def test_right_recording_passes():
    assert suspect([recording()], LOG.model) is None
    assert require_plausible([recording(), recording()], LOG.model) == []


MISTAKES = {
    "positions of joint1 and joint2 are exchanged": (exchanged(LOG.position, 0, 1), LOG.current),
    "all columns of joint2 and joint3": (exchanged(LOG.position, 1, 2), exchanged(LOG.current, 1, 2)),
    "reverse order": (LOG.position[:, ::-1], LOG.current[:, ::-1]),
    "effort of joint2 counts against": (LOG.position, scaled(LOG.current, 1, -1.0)),
    "all efforts count against": (LOG.position, -LOG.current),
    "position of joint3 counts the other way": (scaled(LOG.position, 2, -1.0), LOG.current),
    "position of joint3 is in degrees": (scaled(LOG.position, 2, 180 / np.pi), LOG.current),
    "efforts are in thousandths": (LOG.position, 1000.0 * LOG.current),
}


@pytest.mark.parametrize("words", MISTAKES)
def test_mistake_is_named(words):
    suspicion = suspect([recording(*MISTAKES[words])], LOG.model)
    assert suspicion is not None
    assert words in suspicion.what
    assert suspicion.probability > 0.9


def test_an_arm_described_upside_down_is_no_arm_of_wrong_signs():
    suspicion = suspect([recording()], under_gravity(LOG.model, (0.0, 0.0, 1.0)))
    assert suspicion is not None
    assert suspicion.what.startswith("gravity points along 0.00, 0.00, -1.00 of the base, opposite")
    assert suspicion.physical


@pytest.mark.parametrize("stated", [True, False])
def test_a_balancer_does_not_turn_gravity_round(stated):
    """Joint 2 has a torque against its weight: described right, it was called upside down."""
    log = kr270_log()
    model = log.model if stated else without_balancer(log.model)
    current = {"current": Signal(log.time, 1.1 * log.current), "position": Signal(log.time, log.position)}
    run = Recording("log", model, current)
    assert suspect([run], model) is None
    suspicion = suspect([run], under_gravity(model, (0.0, 0.0, 1.0)))
    assert suspicion is not None
    assert suspicion.what.startswith("gravity points along 0.00, 0.00, -1.00 of the base, opposite")


def without_balancer(model):
    kept = tuple(effect for effect in model.effects if not isinstance(effect, SpringBalancer))
    names = set(replace(model, effects=kept, stated={}).names)
    return replace(model, effects=kept, stated={k: v for k, v in model.stated.items() if k in names})


def test_joints_that_hold_their_place_are_not_accused():
    rng = np.random.default_rng(7)
    held = LOG.position.mean(axis=0) + 1e-5 * rng.normal(size=LOG.position.shape)
    position = np.where(np.arange(ARM.dof) == 1, LOG.position, held)
    velocity = np.where(np.arange(ARM.dof) == 1, LOG.velocity, 0.0)
    motion = LOG.model.loaded(Motion.of(LOG.time, position, velocity, 0.0 * velocity))
    torque = LOG.model.torque(motion, LOG.model.nominal_values)
    torque += 0.02 * LOG.torque.std(axis=0) * rng.normal(size=torque.shape)
    assert suspect([recording(position, torque / ARM.drive_gain)], LOG.model) is None


def test_another_robot_is_named():
    other = read_model("kr270")
    suspicion = suspect([recording(model=other)], other)
    assert suspicion is not None
    assert suspicion.what.startswith("another arm than ") or "unit that is not stated" in suspicion.what


def test_identify_refuses_certain_mistakes_unless_told():
    wrong = recording(exchanged(LOG.position, 0, 1))
    with pytest.raises(WrongInput, match="joint1 and joint2 are exchanged.*--as-recorded"):
        identify([wrong])
    assert identify([wrong], as_recorded=True).runs == ("log",)


def test_what_is_likely_of_one_run_is_said_though_not_of_all(monkeypatch):
    module = sys.modules[require_plausible.__module__]
    likely = Suspicion("the efforts are in kgf cm", "state it", 0.8)
    monkeypatch.setattr(module, "suspect", lambda runs, model: likely if runs[0].name == "odd" else None)
    odd = replace(recording(), name="odd")
    assert require_plausible([recording(), odd], LOG.model) == [f"odd: {likely}"]


def test_noise_alone_is_no_mistake():
    noise = np.random.default_rng(5).normal(size=LOG.current.shape)
    suspicion = suspect([recording(current=noise)], LOG.model)
    assert suspicion is None or not suspicion.certain


def test_right_bodies_explain_the_shoulder_and_the_elbow_to_twice_their_noise():
    """By a ridge that is too large they are held back, and less is explained than by wrong ones."""
    log = _sampled(recording())
    efforts = log._replace(effort=log.effort * ARM.drive_gain)
    left = Coupled.of(rigid_regressor(ARM.kinematics, log.motion), efforts).left(np.ones(ARM.dof))
    assert np.all(left[1:3] < 2 * 0.02**2)


def test_columns_that_nothing_tells_apart_change_nothing():
    log = _sampled(recording())
    efforts, ones = log._replace(effort=log.effort * ARM.drive_gain), np.ones(ARM.dof)
    rigid = rigid_regressor(ARM.kinematics, log.motion)
    once, twice = (Coupled.of(np.concatenate([rigid] * times, axis=2), efforts) for times in (1, 2))
    np.testing.assert_allclose(twice.left(ones), once.left(ones), rtol=0.2)


def test_a_description_that_tells_fewer_gains_is_not_the_likelier_for_it():
    """Upside down, a KR270 told nothing of its gains, so none was off: 99 % for a false direction."""
    log = _sampled(recording())
    efforts = log._replace(effort=log.effort * ARM.drive_gain)
    coupled = Coupled.of(rigid_regressor(ARM.kinematics, log.motion), efforts)
    sure = [Gain(20.0 * gain, 0.1, float(gain > 0)) for gain in ARM.drive_gain]
    none = [Gain(positive=float(gain > 0)) for gain in ARM.drive_gain]
    assert as_stated(ARM.drive_gain, sure, coupled) == as_stated(ARM.drive_gain, none, coupled)
