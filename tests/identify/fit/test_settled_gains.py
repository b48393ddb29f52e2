"""What the runs do not determine: open gains, and values that are zero as far as the runs show."""

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from scipy import stats

from exidyn.identification.arm.robot import Limits, Robot
from exidyn.identification.effects import CoulombFriction, Payload, RigidBody, RotorInertia, ViscousFriction
from exidyn.identification.export import Portable
from exidyn.identification.export.texts import toml
from exidyn.identification.fit.agreement import agreement
from exidyn.identification.fit.equations import decimated_regressor
from exidyn.identification.fit.estimators import ESTIMATORS, Estimate, maximum_likelihood
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.fit.settled_gains import open_gains, settled, unsupported
from exidyn.identification.fit.verdict import verdict
from exidyn.identification.model import Model
from exidyn.identification.pages.fit_document import report_html
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import parse_model
from exidyn.identification.simulation.simulate import simulate
from exidyn.trajectories.random_motion import random_fourier

from ...parts.small.small_fit import summary

pytestmark = pytest.mark.numerical

GAIN = np.array([-40.0, 25.0])
WRONG = 1.1
"""Nominal over true gain; its tolerance is a tenth."""
TRUE = {"Ia1": 0.4, "Ia2": 0.6, "Fv1": 3.0, "Fv2": 1.5, "Fc1": 4.0, "Fc2": 2.0}
ON_AXIS, OFF_AXIS = 0.0, 0.25


def arm(gain) -> Robot:
    """A shoulder, and a forearm that rolls about its own length, along which the flange lies."""
    kinematics = pin.Model()
    for name, kind, x in (("shoulder", pin.JointModelRY, 0.0), ("roll", pin.JointModelRX, 0.4)):
        place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        joint = kinematics.addJoint(len(kinematics.names) - 1, kind(), place, name)
        body = pin.Inertia(4.0, np.array([0.2, 0.0, 0.0]), np.diag([0.01, 0.05, 0.05]))
        kinematics.appendBodyToJoint(joint, body, pin.SE3.Identity())
    limits = Limits(*np.outer([-2.5, 2.5, 3.0, 12.0, 200.0, 200.0], np.ones(2)))
    flange = pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.0]))
    return Robot("rolling", kinematics, limits=limits, drive_gain=gain, flange=flange)


def model(gain) -> Model:
    return Model(arm(gain), (RigidBody(), RotorInertia(), ViscousFriction(), CoulombFriction()))


def run(name: str, seed: int, aside: float | None = None) -> Recording:
    """A simulated run, with 3 kg so far off the axis of the last joint [m] if that is given."""
    known = () if aside is None else (("M", 3.0), ("MX", 0.0), ("MY", 0.0), ("MZ", 3.0 * aside))
    body = None if aside is None else KnownPayload("L", known)
    plant = model(GAIN) + Payload("L", known) if body else model(GAIN)
    values = np.array([TRUE.get(n, v) for n, v in zip(plant.names, plant.nominal_values, strict=True)])
    motion = random_fourier(arm(GAIN).limits, 20.0, period=5.0, seed=seed).at(np.arange(0.0, 20.0, 0.004))
    return simulate(plant, values, GAIN, motion, model(WRONG * GAIN), payload=body, name=name, seed=seed)


@cache
def fit(aside: float) -> Fit:
    return identify([run("empty", 0), run("loaded", 1, aside)], [run("other", 2)])


@cache
def nominal_fit(estimator: str) -> Fit:
    return identify([run("empty", 0)], estimator=ESTIMATORS[estimator])


def test_a_payload_on_the_axis_leaves_the_gain_open_and_one_off_it_does_not():
    assert open_gains(fit(ON_AXIS).estimate, fit(ON_AXIS).model.robot).tolist() == [False, True]
    assert not np.any(open_gains(fit(OFF_AXIS).estimate, fit(OFF_AXIS).model.robot))
    np.testing.assert_allclose(fit(OFF_AXIS).estimate.gain, GAIN, rtol=0.01)


def test_maximum_likelihood_follows_the_runs_though_a_gain_is_open():
    kept = identify([run("empty", 0), run("loaded", 1, ON_AXIS)], drop=False)
    for one in kept.agreement:
        assert np.all(one.over_noise < 1.3)
    ratio = kept.value("Fc2") / kept.estimate.gain[1]
    assert ratio == pytest.approx(TRUE["Fc2"] / GAIN[1], rel=0.02)


@pytest.mark.parametrize("factor", [0.2, 5.0])
def test_a_common_factor_of_the_stated_gains_changes_nothing(factor):
    """A payload's mass sets the scale, of the gain too that its torque does not show."""

    def scaled(equations):
        return maximum_likelihood(replace(equations, gain=factor * equations.gain))

    runs = [run("empty", 0), run("loaded", 1, ON_AXIS)]
    plain = identify(runs, estimator=maximum_likelihood, drop=False).estimate
    other = identify(runs, estimator=scaled, drop=False).estimate
    np.testing.assert_allclose(other.gain, plain.gain, rtol=1e-4)
    np.testing.assert_allclose(other.gain_std, plain.gain_std, rtol=1e-4)
    np.testing.assert_allclose(other.values, plain.values, rtol=1e-4)


def test_the_first_lines_name_the_open_gain_and_the_cure_that_is_true():
    found = fit(ON_AXIS)
    first = verdict(found)[0]
    assert first.startswith("The drive gain of roll was not identified, nor were ")
    assert "Fc2" in first
    assert first.endswith("What would settle it: a run with a known payload that hangs off the axis of roll.")
    head = " ".join(summary(found).split("Drive gains\n")[0].split())
    assert "The drive gain of roll was not identified" in head
    page = report_html(found)
    assert page.index("The drive gain of roll was not identified") < page.index("is at the noise floor")
    hints = {one.name: one.hint for one in found.unclear}
    assert hints["Fc2"] == "a run with a known payload that hangs off the axis of roll"
    assert not any("not identified" in line for line in verdict(fit(OFF_AXIS)))


def test_an_exported_model_needs_the_currents_that_were_recorded():
    found = fit(ON_AXIS)
    model, other = identified(found), prepare(run("other", 2), found.filtering)
    assert abs(model.robot.drive_gain[1] / GAIN[1] - WRONG) < 0.02  # nothing else is known of it
    base = found.structure or found.base
    estimate = replace(found.estimate, values=base.regrouping @ model.nominal_values)
    estimate = replace(estimate, gain=model.robot.drive_gain)
    agreed = agreement(other, estimate, *decimated_regressor(model, base, other, other.motion))
    np.testing.assert_allclose(agreed.relative, found.validation[0].relative, rtol=0.01)


def test_exported_deviations_contain_what_is_not_known_of_the_gain():
    model = identified(fit(ON_AXIS))
    back = parse_model(toml(Portable.of(model)))
    tolerance = back.robot.drive_gain_tolerance
    assert tolerance[0] < 0.01
    assert tolerance[1] == pytest.approx(0.1, rel=0.1)
    share = model.stated["Fc2"].std / model.stated["Fc2"].value
    assert share == pytest.approx(tolerance[1], rel=0.2)
    assert model.stated["Fc1"].std < 0.01 * model.stated["Fc1"].value


@pytest.mark.parametrize("estimator", ["consistent", "weighted"])
def test_deviations_under_nominal_gains_contain_their_tolerance(estimator):
    model = identified(nominal_fit(estimator))
    for name in ("Fv1", "Fc1", "Fc2"):
        stated = model.stated[name]
        # of its own gain; other joints' gains take a thousandth of that
        assert stated.std >= 0.099 * abs(stated.value)
        assert abs(stated.value - TRUE[name]) < 2 * stated.std  # the gains are a tenth too large


def test_gains_that_were_identified_stay_as_they_are():
    found = fit(OFF_AXIS)
    np.testing.assert_array_equal(settled(found).gain, found.estimate.gain)
    np.testing.assert_array_equal(settled(found).values, found.estimate.values)


def estimate(values, covariance):
    values = np.asarray(values, float)
    full = np.pad(np.asarray(covariance, float), (0, 2))
    return Estimate("test", values, np.ones(2), full, np.ones(2))


def test_values_go_together_from_the_weakest():
    found = unsupported(estimate([5.0, 1.4, -1.6, 0.1], np.eye(4)))
    assert found == [3, 1, 2]  # 0.01 + 1.96 + 2.56 is below 7.8, the 95 % quantile with three
    found = unsupported(estimate([1.5] * 10 + [100.0], np.eye(11)))
    squares, limits = 1.5**2 * np.arange(1, 12), stats.chi2.ppf(0.95, np.arange(1, 12))
    assert len(found) == np.flatnonzero(squares > limits)[0] == 4


@pytest.mark.parametrize(("value", "dropped"), [(1.9, [0]), (2.0, [])])
def test_one_value_goes_below_two_deviations(value, dropped):
    assert stats.norm.ppf(0.975) == pytest.approx(1.96, abs=0.01)
    assert unsupported(estimate([3 * value, 50.0], np.diag([9.0, 1.0]))) == dropped


def test_two_that_cannot_be_distinguished_go_only_if_they_cancel():
    # Their sum is known well: once one is zero, the other is all of it.
    apart, together = np.array([1.0, -1.0]), np.array([1.0, 1.0])
    covariance = 100.0 * np.outer(apart, apart) + 0.01 * np.outer(together, together)
    found = unsupported(estimate([2.0, 3.0], covariance))
    assert found == [0]
    # Their sum is known well, and nearly zero: once one is zero, so is the other.
    covariance = np.diag([0.0, 0.0, 1.0])
    covariance[:2, :2] = 100.0 * np.array([[1, -1], [-1, 1]]) + 0.01
    assert unsupported(estimate([2.0, -2.1, 50.0], covariance)) == [0, 1]


def test_dropping_is_least_squares_without_the_columns():
    """The statistic is that of the restricted fit: residual squares grow by it."""
    random = np.random.default_rng(0)
    rows = random.normal(size=(60, 6)) @ random.normal(size=(6, 6))
    values = np.array([4.0, 0.02, 3.0, -0.01, 0.015, 5.0])
    right = rows @ values + 0.1 * random.normal(size=60)
    full = np.linalg.lstsq(rows, right, rcond=None)[0]
    covariance = 0.01 * np.linalg.inv(rows.T @ rows)
    dropped = unsupported(estimate(full, covariance))
    assert dropped
    for count in (len(dropped), len(dropped) + 1):
        left = [k for k in range(6) if k not in dropped[:count]]
        if count > len(dropped):  # the next weakest would be too much
            part = np.linalg.lstsq(rows[:, left], right, rcond=None)[0]
            ratio = np.abs(part) / np.sqrt(0.01 * np.diag(np.linalg.inv(rows[:, left].T @ rows[:, left])))
            left.pop(int(np.argmin(ratio)))
        part = np.linalg.lstsq(rows[:, left], right, rcond=None)[0]
        growth = np.sum((right - rows[:, left] @ part) ** 2) - np.sum((right - rows @ full) ** 2)
        assert (growth / 0.01 < stats.chi2.ppf(0.95, count)) == (count == len(dropped))
