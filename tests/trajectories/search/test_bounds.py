"""Bounds: margins that are positive exactly inside, and slopes that are those of differences."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.robot import Limits
from exidyn.identification.effects import LoadDependentFriction, Payload, Prior, known_parameters
from exidyn.trajectories.clearances.region import Region, box
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.limits.brake import stoppable
from exidyn.trajectories.search import torque_bound
from exidyn.trajectories.search.problem import SCALE, ClearanceBound, RateBound, StopBound, kinematic_bounds
from exidyn.trajectories.search.torque_bound import TorqueBound
from exidyn.trajectories.search.torque_spread import spread_of
from exidyn.trajectories.trajectory import UNITS, States

from ...parts.plans.excitation import smooth_model
from ...parts.small import two_joints

STEP = 1e-6
LIMITS = Limits(
    *np.array([[-1.0, -0.5], [1.5, 2.0], [2.0, 1.0], [6.0, 4.0], [50.0, 30.0], [60.0, np.inf]]),
    np.array([-1.0, -1.5]),
    np.array([-3.0, -5.0]),
)
"""Of two joints, directional, one torque without limit."""
BODY = known_parameters(3.0, (0.1, 0.0, 0.05), (0.02, 0.0, 0.0, 0.03, 0.0, 0.02))
LOADED = smooth_model(LoadDependentFriction(reversal=0.08), Payload("L", BODY))


def heavy():
    """With nominal friction, so that all effects make torque."""
    stated = {"Fv1": 3.0, "Fc1": 4.0, "Fc2": 2.0, "mu1": 0.05, "mu2": 0.1, "Off1": 1.0}
    return replace(LOADED, stated={name: Prior(value) for name, value in stated.items()})


def unsure():
    """Parameters that are correlated, and torque beyond them."""
    of, random = heavy(), np.random.default_rng(0)
    root = 0.1 * random.normal(size=(len(of.names),) * 2)
    columns = of.regressor(of.loaded(two_joints.motion(50)))
    return spread_of(root @ root.T, 0.95, np.array([0.5, 0.1]), columns)


BOUNDS = {
    "velocity": RateBound(1, LIMITS.velocity_lower, LIMITS.velocity, np.arange(2)),
    "acceleration": RateBound(2, LIMITS.acceleration_lower, LIMITS.acceleration, np.arange(2)),
    "jerk": RateBound(3, -LIMITS.jerk, LIMITS.jerk, np.arange(2)),
    "stop": StopBound(LIMITS),
    "torque": TorqueBound(heavy(), LIMITS.torque),
    "torque of a pair": TorqueBound(heavy(), np.array([60.0, 20.0]), ("", "L")),
    "torque of unsure arms": TorqueBound(heavy(), np.array([60.0, 20.0]), ("", "L"), unsure()),
    "region": ClearanceBound(Region.of(two_joints.arm(), "flange", box([-0.5, -1, -0.3], [0.6, 1, 0.4]))),
}


def states(seed=0, samples=60):
    """Inside and outside; the derivatives unrelated."""
    random = np.random.default_rng(seed)
    values = random.normal(size=(4, samples, 2)) * np.array([1.0, 1.0, 4.0, 40.0])[:, None, None]
    return States(np.arange(samples) * 0.1, *values)


@pytest.mark.parametrize("bound", BOUNDS.values(), ids=BOUNDS.keys())
def test_slopes_are_those_of_differences(bound, monkeypatch):
    """But for a sample that lies on a kink of the stop."""
    monkeypatch.setattr(torque_bound, "NEAR", np.inf)
    at = states()
    found = bound.margins(at)
    for order, by in zip(UNITS, found.slopes(), strict=True):
        for joint in range(2):
            shift = np.zeros(2)
            shift[joint] = STEP
            sides = [bound.margins(at._replace(**{order: getattr(at, order) + s * shift})) for s in (1, -1)]
            expected = (sides[0].value - sides[1].value) / (2 * STEP)
            slope = np.zeros_like(expected) if by is None else by[:, :, joint]
            wrong = np.abs(slope - expected) > 1e-5 * (1 + np.abs(expected))
            assert np.count_nonzero(wrong) <= (1 if isinstance(bound, StopBound) else 0), (order, joint)


def within(value, lower, upper):
    return (value <= upper) & (value >= lower)


def test_torque_is_inside_where_its_margin_is_positive_in_every_run():
    at, bound = states(), BOUNDS["torque of a pair"]
    expected = []
    for payload in ("", "L"):
        motion = bound.model.loaded(at.motion(payload))
        torque = bound.model.regressor(motion) @ bound.model.nominal_values
        torque = torque + bound.model.known_torque(motion)
        np.testing.assert_allclose(bound.of(payload)(at), torque)
        expected.append(within(torque, -bound.limit, bound.limit))
    np.testing.assert_array_equal(bound.margins(at).value >= 0, np.concatenate(expected, axis=1))
    assert not np.array_equal(*expected)


def test_a_drive_without_torque_limit_has_no_rows():
    value, slopes = BOUNDS["torque"].margins(states())
    assert value.shape == (60, 1)
    torque = BOUNDS["torque"].torque(states(), "")[:, :1] / 60.0
    np.testing.assert_allclose(value, 1 - np.abs(torque))
    assert slopes()[3] is None


def test_a_clearance_is_inside_where_its_margin_is_positive():
    at, bound = states(), BOUNDS["region"]
    expected = bound.clearance.margins(at.position)
    np.testing.assert_allclose(bound.margins(at).value * SCALE, expected, atol=1e-12)
    assert 0 < np.mean(expected >= 0) < 1


def test_kinematic_bounds_are_those_of_every_limit():
    at = states(samples=300)
    lower, upper = LIMITS.position_lower, LIMITS.position_upper
    at = at._replace(position=0.3 * at.position + 0.5, velocity=0.4 * at.velocity)
    at = at._replace(acceleration=0.4 * at.acceleration, jerk=0.4 * at.jerk)
    values = np.concatenate([bound.margins(at).value for bound in kinematic_bounds(LIMITS)], axis=1)
    expected = [
        np.tile(stoppable(at, LIMITS), 2),
        within(at.velocity, LIMITS.velocity_lower, LIMITS.velocity),
        within(at.acceleration, LIMITS.acceleration_lower, LIMITS.acceleration),
        within(at.jerk, -LIMITS.jerk, LIMITS.jerk),
        within(at.position, lower, upper),
    ]
    assert 0.05 < np.mean(np.all(values >= 0, axis=1)) < 0.95
    np.testing.assert_array_equal(
        np.all(values >= 0, axis=1), np.all(np.concatenate(expected, axis=1), axis=1)
    )


def test_a_limit_that_the_one_before_it_keeps_is_not_asked_for():
    """Of series within the velocity limits whose highest harmonic is slow enough, none breaks the others."""
    random, time = np.random.default_rng(3), np.linspace(0.0, 8.0, 2000)
    highest = 2 * np.pi * 3 / 8.0
    limits = replace(
        LIMITS,
        acceleration=highest * np.maximum(LIMITS.velocity, -LIMITS.velocity_lower) * 1.001,
        acceleration_lower=-highest * np.maximum(LIMITS.velocity, -LIMITS.velocity_lower) * 1.001,
    )
    asked = [bound.order for bound in kinematic_bounds(limits, highest) if isinstance(bound, RateBound)]
    assert 2 not in asked
    for _ in range(50):
        series = Fourier(8.0, np.zeros(2), *random.normal(size=(2, 2, 3)))
        largest = np.abs(series.at(time).velocity).max(axis=0)
        series = Fourier(
            8.0,
            np.zeros(2),
            *(c * (LIMITS.velocity / largest)[:, None] for c in (series.sine, series.cosine)),
        )
        assert np.all(np.abs(series.at(time).acceleration) <= limits.acceleration)


def test_margins_of_torque_leave_room_for_what_is_unsure():
    at, spread = states(), unsure()
    alone, unsure_too = BOUNDS["torque of a pair"], BOUNDS["torque of unsure arms"]
    for place, payload in enumerate(("", "L")):
        columns = heavy().regressor(heavy().loaded(at.motion(payload)))
        expected = spread.band(columns) / unsure_too.limit
        less = (alone.margins(at).value - unsure_too.margins(at).value)[:, 2 * place : 2 * place + 2]
        np.testing.assert_allclose(less, expected)
        farthest, nominal = unsure_too.of(payload)(at), alone.of(payload)(at)
        np.testing.assert_allclose(np.abs(farthest), np.abs(nominal) + spread.band(columns))


def test_far_from_the_limit_a_band_has_no_slopes():
    at, bound = states(), BOUNDS["torque of unsure arms"]
    nominal = BOUNDS["torque of a pair"].margins(at).slopes()[0]
    margin = bound.margins(at)
    far = margin.value[:, :2] >= torque_bound.NEAR
    same = np.all(margin.slopes()[0] == nominal, axis=2)[:, :2]
    np.testing.assert_array_equal(same, far)
    assert np.any(far)
    assert not np.all(far)
