"""Motions that are too poor or repeated are named, with the motion that would help."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import Prior
from exidyn.identification.errors import NotExcited
from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.fit.estimators import Estimate, weighted
from exidyn.identification.fit.fit_warnings import SMALLEST, WORST, excitation_warnings, repeated_motions
from exidyn.identification.fit.identification import priors_away_from_zero, solvable
from exidyn.identification.fit.settled_gains import unsupported
from exidyn.identification.preparation.filters import Decimation
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.preparation.spectra import quantization
from exidyn.identification.recordings.recording import Recording, Signal

from ...parts.small import two_joints
from ...parts.small.small_fit import other_run
from ...parts.small.two_joints import model, motion, true_values

pytestmark = pytest.mark.numerical


def moved(ranges):
    """A prepared run in which the joints cover the given ranges [rad]."""
    run = other_run()
    position = np.outer(np.linspace(0, 1, len(run.motion.position)), ranges)
    return replace(run, motion=replace(run.motion, position=position))


def test_a_joint_that_hardly_moves_in_any_run_is_named():
    names = ("shoulder", "elbow")
    [warning] = excitation_warnings(names, [moved([1.0, 0.02]), moved([0.0, 0.04])], 100.0)
    assert warning.startswith("elbow moves by only 0.04 rad or m in all runs used (limit 0.05)")
    assert excitation_warnings(names, [moved([1.0, 0.0]), moved([0.0, 1.01 * SMALLEST])], 100.0) == ()


@pytest.mark.parametrize("condition", [1.01 * WORST, np.inf, np.nan])
def test_a_poor_condition_number_gives_a_warning(condition):
    [warning] = excitation_warnings(("a", "b"), [moved([1.0, 1.0])], condition)
    assert warning.startswith("the motion is poor: condition number")
    assert excitation_warnings(("a", "b"), [moved([1.0, 1.0])], 0.99 * WORST) == ()


def singular(equations):
    raise np.linalg.LinAlgError("SVD did not converge")


def not_a_number(equations):
    return replace(weighted(equations), values=np.full(len(equations.names), np.nan))


@pytest.mark.parametrize("estimator", [singular, not_a_number])
def test_arithmetic_that_breaks_down_is_an_error_of_ours(estimator):
    equations, _ = two_joints.equations(rows=200)
    with pytest.raises(NotExcited, match="the motion is too poor for this estimator"):
        solvable(estimator)(equations)


def test_what_is_far_from_zero_by_its_prior_is_not_dropped():
    estimate = Estimate("test", np.array([0.5, 1.0, 50.0]), np.ones(1), np.diag([1.0, 1, 1, 0]), np.ones(1))
    assert unsupported(estimate) == [0, 1]
    assert unsupported(estimate, held=[0]) == [1]
    assert unsupported(estimate, held=[0, 1, 2]) == []
    stated = {"Fv1": Prior(2.1, 1.0), "Fv2": Prior(1.9, 1.0), "Fc1": Prior(-2.1, 1.0), "Fc2": Prior(9.0)}
    model = replace(two_joints.model(), stated=stated)
    base = base_parameters(model)
    far = {base.names[k] for k in priors_away_from_zero(base, model)}
    assert far & set(stated) == {"Fv1", "Fc1"}


def test_the_resolution_of_a_current_is_a_floor_of_its_noise():
    decimation = Decimation.at(500.0, 10.0)
    random = np.random.default_rng(0)
    exact = 20.0 * np.sin(np.arange(20000)[:, None] * [0.003, 0.002]) + random.normal(size=(20000, 2))
    rounded = np.round(exact / 0.5) * 0.5
    made = decimation.apply(rounded - exact).std(axis=0)
    np.testing.assert_allclose(quantization(rounded, decimation), made, rtol=0.1)
    assert np.all(quantization(np.ones((100, 2)), decimation) == 0.0)


RATE = 200.0


def sixteen_seconds(name, seed=0, start=0.0, payload=""):
    """Sixteen seconds of a motion, recorded from some time on, with its own noise."""
    noise = np.random.default_rng(len(name))
    whole = motion(int(20 * RATE), seed, rate=RATE)
    rows = slice(int(start * RATE), int((start + 16) * RATE))
    torque = model().torque(whole, true_values(model()))[rows]
    at = whole.position[rows] + 1e-4 * noise.normal(size=(rows.stop - rows.start, 2))
    time = np.arange(len(at)) / RATE
    signals = {"position": Signal(time, at), "torque": Signal(time, torque)}
    prepared = prepare(Recording(name=name, model=model(), signals=signals))
    return replace(prepared, motion=replace(prepared.motion, payload=payload))


@pytest.mark.parametrize("start", [0.0, 1.337])
def test_the_same_motion_again_proves_little(start):
    [warning] = repeated_motions([sixteen_seconds("first")], [sixteen_seconds("again", start=start)])
    assert warning.startswith("again repeats the motion of first")


def test_another_motion_and_the_same_with_a_payload_are_new():
    others = [sixteen_seconds("other", seed=1), sixteen_seconds("loaded", payload="L")]
    assert repeated_motions([sixteen_seconds("first")], others) == []
