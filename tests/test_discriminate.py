"""Separation of models, its gradient, the probability it stands for, and what is said of hopeless pairs."""

from dataclasses import replace

import numpy as np
import pytest
from exidyn.identify.effects import (
    CoulombFriction,
    CurrentOffset,
    JointSpring,
    LoadDependentFriction,
    NonlinearViscousFriction,
    Payload,
    RigidBody,
    SpringBalancer,
    StribeckFriction,
    ViscousFriction,
    known_parameters,
)
from exidyn.identify.model import Model
from exidyn.identify.motion import Motion
from exidyn.trajectories.basis import Basis
from exidyn.trajectories.discriminate import FLOOR, Discriminate, Separate
from exidyn.trajectories.distinction import SURE, distinguish, most_telling, sentences, states_within
from exidyn.trajectories.errors import NotComparable
from exidyn.trajectories.hypothesis import (
    Hypothesis,
    Observation,
    explain,
    probability,
    separation,
    separation_for,
)
from exidyn.trajectories.problem import Problem
from exidyn.trajectories.remedies import known_payload, link_encoders, tilted
from exidyn.trajectories.solve import solve
from exidyn.trajectories.unknowns import DriveGains
from scipy.stats import norm

from .two_joints import arm

NOISE = np.array([0.5, 0.3])
OBSERVATION = Observation(NOISE, rows=200.0)
BODY = known_parameters(2.0, (0.1, 0.0, 0.05), (0.01, 0.0, 0.0, 0.02, 0.0, 0.02))
COMMON = (RigidBody(), ViscousFriction(), CoulombFriction(reversal=0.05), CurrentOffset())
FRICTION = {"Fv1": 3.0, "Fv2": 1.5, "Fc1": 4.0, "Fc2": 2.0}


def model(*more):
    return Model(arm(), (*COMMON, *more))


def hypothesis(name, *more, values=None, deviations=None):
    return Hypothesis.believed(name, model(*more), FRICTION | (values or {}), deviations)


def motion(seed=0, samples=60, size=1.0):
    """Unrelated to any optimum."""
    random = np.random.default_rng(seed)
    basis = Basis(5.0, 3, samples)
    return basis.motion(size * random.normal(size=(basis.rows, 2)) / 3)


def balancer():
    return hypothesis(
        "balancer", SpringBalancer("shoulder", 0.3, 0.2, 0.4), values={"Kr": 100.0, "K0": 10.0}, deviations={}
    )


def spring():
    return hypothesis("spring", JointSpring(("shoulder",)), values={"Ks1": 5.0})


def stribeck():
    return hypothesis("stribeck", StribeckFriction(("elbow",), reversal=0.05), values={"Fs2": 2.0})


def grease():
    return hypothesis("grease", NonlinearViscousFriction(("elbow",), 2.0), values={"Fn2": 1.0})


def gain():
    of = model()
    held = {"gain1": 0.0, "gain2": 0.1}
    return Hypothesis.believed("gain", of + DriveGains(of), FRICTION | {"gain2": 0.05}, held)


def load_friction():
    return hypothesis("load friction", LoadDependentFriction(), values={"mu1": 0.05, "mu2": 0.04})


def as_told_by(true, rival, at):
    """The rival as it would be if it were true: with the values that explain the other best."""
    return replace(rival, values=separation(true, rival, at, OBSERVATION).hypothesis.values)


def carrying(one):
    return one.changed(lambda m: m + Payload("L", BODY))


PAIRS = {
    "springs": (balancer, spring),
    "frictions": (stribeck, grease),
    "gain": (gain, spring),
    "through the load": (load_friction, stribeck),
}


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS.keys())
@pytest.mark.parametrize("power", [2.0, np.inf])
def test_gradient_of_the_objective(pair, power):
    payloads = ("", "L")
    hypotheses = tuple(carrying(one()) for one in pair)
    goal = Discriminate(hypotheses, Observation(NOISE, 100.0, payloads), np.array([[0.0, 0.3], [0.1, 0.0]]))
    objective, at = Separate(goal, power), motion()
    random, step = np.random.default_rng(5), 1e-6
    shift = {name: random.normal(size=at.position.shape) for name in ("position", "velocity", "acceleration")}

    def value(by):
        return objective.value(replace(at, **{n: getattr(at, n) + by * s for n, s in shift.items()}))

    found, gradient = objective(at)
    assert found == pytest.approx(value(0.0), rel=1e-12)
    expected = (value(step) - value(-step)) / (2 * step)
    along = sum(np.sum(getattr(gradient, name) * s) for name, s in shift.items())
    assert along == pytest.approx(expected, rel=2e-5, abs=1e-7)


def test_gradient_of_three_hypotheses_by_coefficients():
    goal = Discriminate((balancer(), spring(), stribeck()), OBSERVATION)
    basis, random = Basis(5.0, 3, 60), np.random.default_rng(2)
    coefficients, direction = random.normal(size=(2, basis.rows, 2)) / 3
    objective = Separate(goal, 4.0)
    gradient = basis.pull(objective(basis.motion(coefficients))[1])
    sides = [objective.value(basis.motion(coefficients + s * direction)) for s in (1e-6, -1e-6)]
    assert np.sum(gradient * direction) == pytest.approx((sides[0] - sides[1]) / 2e-6, rel=1e-5)


def stacked(one, at):
    """Rows of a hypothesis in units of noise, written out: columns (r, p) and torque (r,)."""
    columns = (one.model.regressor(at) / NOISE[:, None]).reshape(-1, len(one.values))
    return columns, columns @ one.values + (one.model.known_torque(at) / NOISE).ravel()


def refitted(one, columns, torque, own):
    """Chi-squared and values of a fit with the beliefs as further rows, by singular values."""
    free = one.free
    held = np.diag(np.sqrt(np.diag(one.precision)[free]))
    rows = np.concatenate([columns[:, free], held])
    right = np.concatenate(
        [torque - own[:, None] if torque.ndim > 1 else torque - own, np.zeros((len(held), *torque.shape[1:]))]
    )
    move = np.linalg.lstsq(rows, right, rcond=1e-9)[0]
    return np.sum((right - rows @ move) ** 2, axis=0), move


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
    wider = hypothesis(
        "wider", SpringBalancer("shoulder", 0.3, 0.2, 0.4), JointSpring(("shoulder",)), deviations=free
    )
    wider = replace(wider, values=np.append(balancer().values, [0.0, 0.0]))
    assert separation(balancer(), balancer(), motion(), OBSERVATION).separation == pytest.approx(
        0.0, abs=1e-12
    )
    assert separation(balancer(), wider, motion(), OBSERVATION).separation == pytest.approx(0.0, abs=1e-12)
    assert separation(wider, balancer(), motion(), OBSERVATION).separation == pytest.approx(0.0, abs=1e-12)


def test_beliefs_hold_the_rival():
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


def share_of_right_choices(true, rival, at, draws=4000):
    """Truth and noise are drawn, both models are fitted, the smaller chi-squared is taken."""
    random = np.random.default_rng(0)
    columns, torque = stacked(true, at)
    held = np.diag(true.precision)
    spread = np.where((held > 0) & np.isfinite(held), held, np.inf) ** -0.5
    truths = spread[:, None] * random.normal(size=(len(held), draws))
    torque = torque[:, None] + columns @ truths + random.normal(size=(2 * len(at), draws))
    misfits = []
    for one in (true, rival):
        columns, own = stacked(one, at)
        misfits.append(refitted(one, columns, torque, own)[0])
    return float(np.mean(misfits[0] < misfits[1]))


@pytest.mark.parametrize("wanted", [1.0, 6.0])
def test_probability_of_models_that_are_nearly_alike(wanted):
    at, rival = motion(size=0.3), hypothesis("spring", JointSpring(("shoulder",)))
    sampled, effect = replace(OBSERVATION, rows=len(at)), SpringBalancer("shoulder", 0.3, 0.2, 0.4)
    held = {"K0": 0.0}  # since Ts and the offset are one, the spring has one parameter of its own too
    soft = hypothesis("balancer", effect, values={"Kr": 100.0}, deviations=held)
    growth = np.sqrt(wanted / separation(soft, rival, at, sampled).separation)
    true = hypothesis("balancer", effect, values={"Kr": 100.0 * growth}, deviations=held)
    found = separation(true, rival, at, sampled)
    assert found.separation == pytest.approx(wanted, rel=1e-6)
    right = share_of_right_choices(true, rival, at)
    assert right == pytest.approx(probability(found.separation), abs=0.03)  # 0.016 is two deviations


@pytest.mark.parametrize("size", [0.4, 1.2])
def test_probability_of_models_that_are_unlike(size):
    """One column each, its nuisance the same: the law in the docstring, and where the short one is safe."""
    true = hypothesis("stribeck", StribeckFriction(("elbow",), reversal=0.05), values={"Fs2": size})
    rival, at = hypothesis("grease", NonlinearViscousFriction(("elbow",))), motion()
    found = separation(true, rival, at, replace(OBSERVATION, rows=len(at)))
    angle, short = angle_of(true, rival, at), probability(found.separation)
    b = 0.5 * np.sqrt(found.separation) / np.sin(angle / 2)
    a = b * np.tan(angle / 2)
    exact = norm.cdf(a) * norm.cdf(b) + norm.cdf(-a) * norm.cdf(-b)
    right = share_of_right_choices(true, rival, at)
    assert right == pytest.approx(exact, abs=0.02)
    assert short < right if found.separation > 3.1 else 0.0 < short - right < 0.065


def angle_of(one, other, at):
    """Between the last columns of two hypotheses, what they have in common projected off."""
    columns = [stacked(h, at)[0] for h in (one, other)]
    common, free = columns[0][:, :-1], one.free[:-1]
    held = np.diag(np.sqrt(np.diag(one.precision)[:-1][free]))
    rows = np.concatenate([common[:, free], held])
    left = []
    for own in columns:
        column = np.append(own[:, -1], np.zeros(len(held)))
        column = column - rows @ np.linalg.lstsq(rows, column, rcond=1e-9)[0]
        left.append(column / np.linalg.norm(column))
    return float(np.arccos(abs(left[0] @ left[1])))


def test_probability_and_its_inverse():
    assert probability(0.0) == 0.5
    assert probability(separation_for(0.95)) == pytest.approx(0.95)
    assert separation_for(0.95) == pytest.approx(10.82, abs=0.01)


def test_identical_hypotheses_have_a_finite_objective():
    twin = replace(balancer(), name="twin")
    value, gradient = Separate(Discriminate((balancer(), twin), OBSERVATION))(motion())
    assert value == pytest.approx(-np.log(FLOOR), abs=1e-3)
    assert all(np.all(np.isfinite(getattr(gradient, n))) for n in ("position", "velocity", "acceleration"))


def test_the_optimiser_takes_the_goal():
    goal = Discriminate((stribeck(), grease()), OBSERVATION)
    limits, basis = arm().limits, Basis(5.0, 3, 60)
    problem = Problem(basis, goal.objectives(limits, 5.0 / 60), [], 2, np.ones(2))
    start = 0.2 * np.random.default_rng(0).normal(size=basis.rows * 2)
    last = problem.objectives[-1]
    begun = last.value(basis.motion(problem.coefficients(start)))
    bounded = replace(problem, bounds=_kinematic(limits))
    found = solve(bounded, start, seconds=20.0)
    assert found.value < begun - np.log(2.0)  # twice as separate
    assert goal.words(found.value).startswith("probability of choosing right")
    assert float(goal.words(np.inf * -1 if found.value is None else found.value).split()[-2]) > 50.0


def _kinematic(limits):
    from exidyn.trajectories.bounds import kinematic_bounds

    return kinematic_bounds(limits)


def zero_length_balancer():
    """A spring that is as long as its ends are apart: its torque is that of a weight."""
    return hypothesis(
        "balancer",
        SpringBalancer("shoulder", 0.3, 0.2, 0.4),
        values={"Kr": 60.0},
        deviations={"K0": 0.0, "MX1": 1e-3, "MZ1": 1e-3},
    )


def heavier():
    """The shoulder stands on a fixed axis, so that its first moment shows in its weight alone."""
    return hypothesis("centre of mass", deviations={"MX1": np.inf, "MZ1": np.inf})


def test_no_motion_tells_a_balancer_from_a_weight_and_a_tilted_base_does():
    true = zero_length_balancer()
    goal = Discriminate((true, as_told_by(true, heavier(), motion())), OBSERVATION)
    (found,) = distinguish(goal, motion(), arm().limits, 5.0)
    assert not found.possible
    assert found.runs is None
    assert found.probability_hour < SURE
    offers = {offer.name: offer.probability for offer in found.remedies}
    assert offers["the base tilted by 15 degrees about y"] > SURE
    assert offers["link-side encoders"] < SURE
    (text,) = sentences([found])
    assert "No motion tells them apart" in text
    assert "would, with the base tilted" in text


def test_link_side_encoders_tell_what_is_before_the_gear_from_what_is_behind():
    held = {"Ks1": 0.0, "Off1": 0.0}
    hose = hypothesis("hose", JointSpring(("shoulder",)), values={"Ts1": 20.0}, deviations=held)
    offset = hypothesis("offset", deviations={"Off1": np.inf})
    goal = Discriminate((hose, as_told_by(hose, offset, motion())), OBSERVATION)
    (found,) = distinguish(goal, motion(), arm().limits, 5.0)
    assert not found.possible
    assert found.remedies[0].name == "link-side encoders"
    assert found.remedies[0].probability > SURE
    assert all(offer.probability < 0.6 for offer in found.remedies[1:])


def test_what_a_run_tells_apart_needs_no_remedy():
    true = hypothesis("stribeck", StribeckFriction(("elbow",), reversal=0.05), values={"Fs2": 20.0})
    (found,) = distinguish(Discriminate((true, grease()), OBSERVATION), motion(), arm().limits, 5.0)
    assert found.possible
    assert found.runs == 1
    assert found.remedies == ()
    assert "No motion" not in sentences([found])[0]


def test_weak_pairs_are_told_how_many_runs():
    true = hypothesis("stribeck", StribeckFriction(("elbow",), reversal=0.05), values={"Fs2": 0.5})
    rival = as_told_by(true, hypothesis("grease", NonlinearViscousFriction(("elbow",))), motion())
    goal = Discriminate((true, rival), replace(OBSERVATION, rows=50.0))
    (found,) = distinguish(goal, motion(), arm().limits, 5.0, remedies=())
    assert found.runs > 1
    share = found.runs * 50.0 / 60
    seen = [goal.observation.seen(one, motion()) for one in goal.hypotheses]
    enough = [
        explain(goal.hypotheses[r], seen[r], seen[t].torque, share).separation for t, r in ((0, 1), (1, 0))
    ]
    assert found.possible == (found.probability_hour >= SURE)
    assert probability(min(enough)) >= SURE
    assert f"About {found.runs} such runs" in sentences([found])[0]


def test_bounds_of_the_most_telling_states_hold_a_motion():
    true, rival, limits = stribeck(), grease(), arm().limits
    low, high = most_telling(true, rival, OBSERVATION, limits, 200.0)
    random = explain_states(true, rival, states_within(limits, 300, seed=4), 200.0)
    assert random < low <= high
    assert high < 2.0 * low


def explain_states(true, rival, at, rows):
    return separation(true, rival, at, replace(OBSERVATION, rows=rows)).separation


def test_remedies_change_what_they_say():
    hypotheses, at = (balancer(), gain()), motion()
    case = known_payload(hypotheses, at, OBSERVATION)
    weight = OBSERVATION.seen(hypotheses[1], at).torque, case.observation.seen(case.hypotheses[1], at).torque
    assert case.name == "a known payload of 0.96 kg"
    assert np.max(np.abs(weight[1] - weight[0])) > 1.0
    turned = tilted(1)(hypotheses, at, OBSERVATION).hypotheses[1].model
    inner = turned.effects[-1].model
    for robot in (turned.robot, inner.robot):
        assert np.linalg.norm(robot.gravity) == pytest.approx(9.81)
        assert robot.gravity[2] == pytest.approx(-9.81 * np.cos(np.deg2rad(15)))
    assert hypotheses[1].model.robot.gravity[2] == pytest.approx(-9.81)


def test_friction_is_not_seen_behind_the_gear():
    at = motion()
    case = link_encoders((stribeck(), grease()), at, OBSERVATION)
    seen = case.observation.seen(case.hypotheses[0], at)
    names = case.hypotheses[0].model.names
    assert np.all(seen.columns[:, :, names.index("Fs2")] == 0.0)
    compliance = seen.columns[:, 1, names.index("compliance2")]
    assert compliance == pytest.approx(seen.torque[:, 1])


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Discriminate((balancer(),), OBSERVATION), "two or more"),
        (lambda: Discriminate((balancer(), balancer()), OBSERVATION), "a name of its own"),
        (lambda: Discriminate((balancer(), spring()), Observation(np.zeros(2), 1.0)), "above 0"),
        (lambda: Discriminate((balancer(), spring()), Observation(np.ones(3), 1.0)), "a joint"),
        (lambda: Discriminate((balancer(), spring()), OBSERVATION, np.zeros((3, 3))), "earlier"),
        (lambda: Hypothesis.believed("x", model(), {"Kr": 1.0}), "no parameter 'Kr'. Valid: XX1"),
        (lambda: Hypothesis("x", model(), np.zeros(3), np.eye(3)), "parameters of its model"),
        (lambda: replace(balancer(), values=np.full(len(balancer().values), np.nan)), "NaN"),
    ],
)
def test_bad_input(make, said):
    with pytest.raises(NotComparable, match=said):
        make()
