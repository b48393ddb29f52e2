"""Separation of models, its gradient, and the trajectory that it is the goal of."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.effects import JointSpring, SpringBalancer
from exidyn.trajectories.discrimination.discriminate import FLOOR, Discriminate, Separate
from exidyn.trajectories.discrimination.separation import Hypothesis, Observation, probability
from exidyn.trajectories.errors import NotComparable
from exidyn.trajectories.search.delivery import Setting
from exidyn.trajectories.search.excite import excite, random_start
from exidyn.trajectories.search.problem import Basis

from ...parts.plans.excitation import shifted
from ...parts.plans.hypotheses import (
    NOISE,
    OBSERVATION,
    as_told_by,
    balancer,
    carrying,
    gain,
    grease,
    hypothesis,
    load_friction,
    model,
    motion,
    refitted,
    separation,
    spring,
    stacked,
    stribeck,
)
from ...parts.small.two_joints import arm

pytestmark = pytest.mark.slow

PAIRS = {
    "springs": (balancer, spring),
    "frictions": (stribeck, grease),
    "gain": (gain, spring),
    "through the load": (load_friction, stribeck),
}


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS.keys())
@pytest.mark.parametrize("power", [2.0, np.inf])
def test_gradient_of_the_objective(pair, power):
    observation = Observation(NOISE, 100.0, ("", "L"))
    hypotheses = tuple(carrying(one()) for one in pair)
    gradient_is_right(Discriminate(hypotheses, observation, np.array([[0.0, 0.3], [0.1, 0.0]])), power)


def gradient_is_right(goal, power):
    objective, at = Separate(goal, power), motion()
    found, gradient = objective(at)
    assert found == pytest.approx(objective.value(at), rel=1e-12)
    shift, expected = shifted(objective.value, at, np.random.default_rng(5))
    along = sum(np.sum(getattr(gradient(), name) * by) for name, by in shift.items())
    assert along == pytest.approx(expected, rel=2e-5, abs=1e-7)


def test_coupled_drives_are_seen_one_by_one():
    """Rows are the drives' torques, each with its own noise, as those of identification are."""
    coupling = np.array([[1.0, 0.0], [0.8, 1.0]])
    true, rival = (
        one().changed(lambda of: replace(of, robot=replace(of.robot, coupling=coupling)))
        for one in (stribeck, spring)
    )
    at = true.model.loaded(motion())
    on_drives = true.model.torque(at, true.values) @ np.linalg.inv(coupling)
    np.testing.assert_allclose(OBSERVATION.seen(true, at).torque, on_drives / NOISE, rtol=1e-9, atol=1e-9)
    gradient_is_right(Discriminate((true, rival), OBSERVATION), 4.0)
    gradient_is_right(Discriminate((balancer(), spring(), stribeck()), OBSERVATION), 4.0)


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS.keys())
def test_separation_is_the_chi_squared_of_a_fit(pair):
    true, rival = (one() for one in pair)
    at = true.model.loaded(motion())
    found = separation(true, rival, at, replace(OBSERVATION, rows=len(at)))
    columns, own = stacked(rival, rival.model.loaded(at))
    misfit, move = refitted(rival, columns, stacked(true, at)[1], own)
    assert found.separation == pytest.approx(float(misfit), rel=1e-6)
    assert found.hypothesis.values[~rival.free] == pytest.approx(rival.values[~rival.free])


def test_separations_of_two_runs_add_up():
    true, rival = balancer(), spring()
    first, second = motion(0), motion(1)
    one = separation(true, rival, first, OBSERVATION)
    two = separation(true, one.hypothesis, second, OBSERVATION)
    arrays = {
        n: np.concatenate([getattr(m, n) for m in (first, second)])
        for n in ("position", "velocity", "acceleration")
    }
    both = Motion.of(np.arange(120) * 1.0, *arrays.values())
    together = separation(true, rival, both, replace(OBSERVATION, rows=400.0))
    assert one.separation + two.separation == pytest.approx(together.separation, rel=1e-8)


def test_no_separation_from_itself_or_from_what_is_contained():
    free = dict.fromkeys(("Ks1", "Ts1"), np.inf)
    effects = SpringBalancer("shoulder", 0.3, 0.2, 0.4), JointSpring(("shoulder",))
    wider = hypothesis("wider", *effects, deviations=free)
    wider = replace(wider, values=np.append(balancer().values, [0.0, 0.0]))
    for true, rival in ((balancer(), balancer()), (balancer(), wider), (wider, balancer())):
        assert separation(true, rival, motion(), OBSERVATION).separation == pytest.approx(0.0, abs=1e-12)


def test_priors_hold_the_rival():
    true = hypothesis("stiff", JointSpring(("shoulder",)), values={"Ks1": 20.0})
    free = hypothesis("free", JointSpring(("shoulder",)))
    fixed = hypothesis("fixed", JointSpring(("shoulder",)), deviations={"Ks1": 0.0, "Ts1": 0.0})
    tight = hypothesis("tight", JointSpring(("shoulder",)), deviations={"Ks1": 1e-7, "Ts1": 1e-7})
    found = {
        one.name: separation(true, one, motion(), OBSERVATION).separation for one in (free, fixed, tight)
    }
    assert found["free"] == pytest.approx(0.0, abs=1e-9)
    assert found["fixed"] > 1.0
    assert found["tight"] == pytest.approx(found["fixed"], rel=1e-4)


def test_identical_hypotheses_have_a_finite_objective():
    twin = replace(balancer(), name="twin")
    value, gradient = Separate(Discriminate((balancer(), twin), OBSERVATION))(motion())
    assert value == pytest.approx(-np.log(FLOOR), abs=1e-3)
    assert all(np.all(np.isfinite(getattr(gradient(), n))) for n in ("position", "velocity", "acceleration"))


def test_excite_takes_the_goal():
    goal = Discriminate((stribeck(), as_told_by(stribeck(), grease(), motion())), OBSERVATION)
    setting = Setting(arm().limits, harmonics=3, periods=(5.0,))
    basis, last = Basis(5.0, 3, 500), goal.objectives(setting.limits, 0.0)[-1]
    begun = last.value(basis.motion(random_start(goal, setting, basis, 0)))
    found = excite(goal, setting, starts=1, seconds=20.0)
    assert np.exp(-found.value) > 1.5 * np.exp(-begun)  # separation; every limit costs some
    assert (
        goal.words(found.value)
        == f"probability of choosing right {100 * probability(np.exp(-found.value)):.3g} %"
    )


def test_fixed_hypotheses_have_nothing_to_move():
    fixed = hypothesis("fixed", deviations=dict.fromkeys(model().names, 0.0))
    true = hypothesis("more friction", values={"Fv1": 4.0})
    found = separation(true, fixed, motion(), OBSERVATION)
    drag = motion().velocity[:, 0] / NOISE[0]
    assert found.separation == pytest.approx(200.0 * np.mean(drag**2))
    assert np.all(found.hypothesis.values == fixed.values)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Discriminate((balancer(),), OBSERVATION), "two or more"),
        (lambda: Discriminate((balancer(), balancer()), OBSERVATION), "unique names"),
        (lambda: Discriminate((balancer(), spring()), Observation(np.zeros(2), 1.0)), "above 0"),
        (lambda: Discriminate((balancer(), spring()), Observation(np.ones(3), 1.0)), "per drive"),
        (lambda: Discriminate((balancer(), spring()), OBSERVATION, np.zeros((3, 3))), "earlier"),
        (lambda: Hypothesis("x", model(), np.zeros(3), np.eye(3)), "parameters of its model"),
        (lambda: replace(balancer(), values=np.full(len(balancer().values), np.nan)), "NaN"),
    ],
)
def test_bad_input(make, message):
    with pytest.raises(NotComparable, match=message):
        make()
