"""A joint without a motor: values of zero solve its rows, which must not draw the fit there."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.diagnosis.candidates.contact_event import FlangeTorque, _pushed
from exidyn.identification.diagnosis.diagnose import diagnose
from exidyn.identification.diagnosis.runs.usable import usable
from exidyn.identification.diagnosis.search.problem import Problem
from exidyn.identification.recordings.recording import Recording, Signal

from ...parts.small.small_search import nominal
from ..fit.test_passive_joint import arm, swinging


@pytest.fixture(scope="module")
def run():
    time, position, torque = swinging(arm())
    torque[:, 0] += 0.3 * np.sin(11.0 * time) ** 3  # what no model has
    position += 3e-4 * np.random.default_rng(3).normal(size=position.shape)
    model = arm((1.7, 0.6), passive=("pendulum",), inertias_stated=False)
    return Recording("swing", model, {"position": Signal(time, position), "torque": Signal(time, torque)})


@pytest.fixture(scope="module")
def prediction(run):
    model = nominal(run.model)
    return Problem.of(model, usable(model, [("identify", run)])[0]).without_findings


@pytest.mark.slow
def test_its_noise_is_no_floor_above_which_something_is_left(run):
    found = diagnose(run.model, [("identify", run)], as_recorded=True)
    assert found.evidence.noise[1] >= found.evidence.noise[0] > 0.0
    assert 1 not in {remainder.joint for remainder in found.remainders}


def test_rows_of_a_passive_joint_draw_no_fit(prediction):
    motor, passive = prediction.weighting.variance
    assert passive >= motor
    share = prediction.weighting.independent
    smaller = prediction.errors * [1.0, 1e-6]
    gain = prediction.log_probability(smaller, share) - prediction.log_probability(prediction.errors, share)
    assert np.abs(gain[:, 1].sum()) < 1.0
    values = dict(zip(prediction.rows.names, prediction.values, strict=True))
    true, given = (dict(zip(m.names, m.nominal_values, strict=True)) for m in (arm(), arm((1.7, 0.6))))
    assert given["MX2"] + values["MX2"] == pytest.approx(true["MX2"], rel=0.1)
    every = replace(prediction.rows, passive=())
    np.testing.assert_array_equal(every.row_variance(np.array([4.0, 1.0])), [4.0, 1.0])
    np.testing.assert_array_equal(prediction.rows.row_variance(np.array([4.0, 1.0])), [4.0, 4.0])


def test_a_force_that_the_arm_does_not_feel_is_none_however_certain_its_rows():
    time = np.arange(200) / 50.0
    torque = np.zeros((200, 2, 3))
    torque[:, 0, 0] = 1.0 + time
    left = torque @ np.array([3.0, 0.0, 0.0])
    weight = np.full(left.shape, 1e20)
    [(_, force, _)] = _pushed(FlangeTorque(time, torque), left, weight, 1e-4, np.array([1.0]), 0.6)
    np.testing.assert_allclose(force[1:], 0.0, atol=1e-9)
    assert force[0] > 1.0
