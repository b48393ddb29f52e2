"""Shrinking: inside every limit between samples too, and nothing changed that was inside."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import Payload, known_parameters
from exidyn.trajectories.clearances.region import Region, box
from exidyn.trajectories.errors import Infeasible
from exidyn.trajectories.families.fourier import Fourier
from exidyn.trajectories.search import delivery
from exidyn.trajectories.search.delivery import inside_kinematics, shrink_inside, violations_of

from ...parts.plans.excitation import TICK, goal, kinematic_share, limits, nothing_violated, smooth_model
from ...parts.runs.robots import kinematics
from ...parts.small import two_joints

pytestmark = pytest.mark.slow

BODY = known_parameters(3.0, (0.1, 0.0, 0.05))
DIRECTIONAL = replace(
    limits(),
    position_lower=np.array([-0.5, -2.0]),
    velocity_lower=np.array([-1.0, -2.5]),
    acceleration_lower=np.array([-4.0, -11.0]),
)


def series(size, seed=0, harmonics=3, dof=2, period=4.0):
    sine, cosine = (
        size * np.random.default_rng(seed).normal(size=(2, dof, harmonics)) / np.arange(1, harmonics + 1)
    )
    return Fourier(period, np.full(dof, 0.1), sine, cosine, periods=2)


def region(lower=(-0.3, -1.0, -0.4), upper=(0.75, 1.0, 0.4)):
    return Region.of(two_joints.arm(), "flange", box(list(lower), list(upper)))


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("kept", [limits(), DIRECTIONAL], ids=["both ways alike", "directional"])
def test_kinematic_share_is_that_of_the_tightest_limit(kept, seed):
    """One limit of every joint is reached exactly, whether the series was smaller or larger."""
    for size in (1e-3, 3.0):
        found = inside_kinematics(series(size, seed), kept, 0.9)
        np.testing.assert_allclose(kinematic_share(found, kept), 0.9, rtol=1e-9)


@pytest.mark.parametrize("seed", range(2))
def test_nothing_is_violated_between_samples(seed):
    of = goal()
    found = shrink_inside(series(1.0, seed), of, DIRECTIONAL, (), TICK)
    nothing_violated(found, of, DIRECTIONAL)
    assert found.periods == 2
    np.testing.assert_array_equal(found.centre, [0.1, 0.1])


def test_it_shrinks_no_more_than_the_kinematics_ask():
    """Velocity and its like scale in proportion: one step to the limit."""
    kept = replace(limits(), torque=np.full(2, np.inf))
    largest = kinematic_share(shrink_inside(series(1.0), goal(), kept, (), TICK), kept)
    assert np.all((0.6 < largest) & (largest <= 1.0))
    assert np.max(largest) > 1 - 1e-6


def test_what_is_inside_is_not_changed():
    of, inside = goal(), series(0.02)
    assert shrink_inside(inside, of, limits(), (region(),), TICK) is inside


def test_it_stays_in_the_region():
    of, clearances = goal(), (region(),)
    wide = series(0.7)
    assert not clearances[0].worst(wide).allowed
    found = shrink_inside(wide, of, limits(), clearances, TICK)
    nothing_violated(found, of, limits(), clearances)
    assert np.abs(found.sine).max() > 0.05


def test_what_is_far_outside_is_brought_in_by_few_checks_and_no_smaller_than_it_must(monkeypatch):
    """The torque of the loaded run counts; a check of all limits takes a third of a second for six joints."""
    of, checks = goal(smooth_model(Payload("L", BODY))), []
    kept = replace(limits(), torque=np.array([66.0, 40.0]))
    alone = shrink_inside(series(0.25), of, kept, (), TICK)
    nothing_violated(alone, of, kept)
    of = replace(of, experiment=replace(of.experiment, payloads=("", "L")))

    def counted(*arguments):
        checks.append(arguments)
        return violations_of(*arguments)

    monkeypatch.setattr(delivery, "violations_of", counted)
    found = shrink_inside(series(0.25), of, kept, (), TICK)
    nothing_violated(found, of, kept)
    assert np.all(np.abs(found.sine) < 0.97 * np.abs(alone.sine))
    assert 5 < len(checks) <= 25
    assert violations_of(found.scaled(np.full(2, 1.0 / delivery.STEP**1.5)), of, kept, TICK)


@pytest.mark.parametrize(
    ("changed", "clearances", "words"),
    [
        ({"torque": [10.0, 100.0]}, [], r"shoulder: torque at .* limit -?10 N m, and smaller motions"),
        ({"position_lower": [0.2, -2.0]}, [], "shoulder: (position|a stop).* limit 0.2 rad"),
        ({}, [region(upper=(0.3, 1.0, 0.4))], r"flange .* mm of room at .* Try a start pose away from it"),
    ],
)
def test_a_centre_outside_what_is_allowed_is_reported(changed, clearances, words):
    kept = replace(limits(), **{name: np.array(value) for name, value in changed.items()})
    with pytest.raises(Infeasible, match=words):
        shrink_inside(series(0.1), goal(), kept, clearances, TICK)


def test_joints_that_slide_are_scaled_like_those_that_turn():
    robot = replace(two_joints.arm(), kinematics=kinematics("pr"), flange=two_joints.arm().flange)
    of = goal(replace(smooth_model(), robot=robot))
    kept = replace(limits(), torque=np.array([300.0, 300.0]))
    nothing_violated(shrink_inside(series(0.6), of, kept, (), TICK), of, kept)
