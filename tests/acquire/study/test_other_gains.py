"""Gains that a known body contradicts."""

from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.acquire.study.other_gains import gain_sentences, other_gains, with_gains
from exidyn.identification.diagnosis.blocks.prediction import LINEAR

from ...parts.small import small_diagnosis


def fitted(shares, std=0.005, estimated=True):
    """A fit with gains that are more than stated by so much."""
    model = small_diagnosis.nominal_model()
    gain = model.robot.drive_gain * (1.0 + np.array(shares))
    flags = np.full(2, estimated)
    estimate = SimpleNamespace(gain=gain, gain_std=std * np.abs(gain), gain_estimated=flags)
    return SimpleNamespace(estimate=estimate), model


def test_a_gain_that_its_tolerance_excludes_is_named_and_taken():
    fit, model = fitted((0.0, 0.4))
    [found] = other_gains(fit, model)
    assert (found.joint, found.share) == (1, pytest.approx(0.4))
    after = with_gains(model, [found]).robot
    assert after.drive_gain[1] == pytest.approx(1.4 * model.robot.drive_gain[1])
    assert after.drive_gain_tolerance[1] == LINEAR
    assert after.drive_gain[0] == model.robot.drive_gain[0]
    assert "gives 40 " in gain_sentences([found], model)[0]


@pytest.mark.parametrize("more", [{"estimated": False}, {"std": 0.5}])
def test_a_gain_that_no_body_shows_is_none(more):
    assert other_gains(*fitted((0.4, 0.4), **more)) == []


def test_a_gain_within_its_tolerance_is_none():
    fit, model = fitted((0.01, -0.01))
    assert other_gains(fit, model) == []
    assert other_gains(None, model) == []
    assert gain_sentences([], model) == []
