"""Sentences about pairs that a run leaves open, and about those that no motion distinguishes."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import (
    JointSpring,
    NonlinearViscousFriction,
    SpringBalancer,
    StribeckFriction,
)
from exidyn.trajectories.discrimination.discriminate import Discriminate
from exidyn.trajectories.discrimination.distinction import (
    SURE,
    distinguish,
    most_informative,
    paragraph,
    states_within,
)
from exidyn.trajectories.discrimination.remedies import known_payload, tilted
from exidyn.trajectories.discrimination.separation import explain, probability

from ...parts.plans.hypotheses import (
    OBSERVATION,
    as_told_by,
    balancer,
    gain,
    grease,
    hypothesis,
    motion,
    separation,
    stribeck,
)
from ...parts.small.two_joints import arm

pytestmark = pytest.mark.numerical


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


def test_no_motion_distinguishes_a_balancer_from_a_weight_and_a_tilted_base_does():
    true = zero_length_balancer()
    goal = Discriminate((true, as_told_by(true, heavier(), motion())), OBSERVATION)
    (found,) = distinguish(goal, motion(), arm().limits, 5.0)
    assert not found.possible
    assert found.runs is None
    assert found.probability_hour < SURE
    assert found.remedies["the base tilted by 15 degrees about y"] > SURE
    assert found.remedies["link-side encoders"] < SURE
    text = paragraph(found)
    assert "No motion distinguishes them" in text
    assert "To distinguish them, repeat the run with the base tilted" in text


def test_link_side_encoders_distinguish_what_is_before_the_gear_from_what_is_behind():
    held = {"Ks1": 0.0, "Off1": 0.0}
    hose = hypothesis("hose", JointSpring(("shoulder",)), values={"Ts1": 20.0}, deviations=held)
    offset = hypothesis("offset", deviations={"Off1": np.inf})
    goal = Discriminate((hose, as_told_by(hose, offset, motion())), OBSERVATION)
    (found,) = distinguish(goal, motion(), arm().limits, 5.0)
    assert not found.possible
    (name, chance), *others = found.remedies.items()
    assert name == "link-side encoders"
    assert chance > SURE
    assert all(other < 0.6 for _, other in others)


def test_what_a_run_distinguishes_needs_no_remedy():
    true = hypothesis("stribeck", StribeckFriction(("elbow",), reversal=0.05), values={"Fs2": 20.0})
    (found,) = distinguish(Discriminate((true, grease()), OBSERVATION), motion(), arm().limits, 5.0)
    assert (found.possible, found.runs, found.remedies) == (True, 1, {})
    assert "No motion" not in paragraph(found)


def test_weak_pairs_are_given_how_many_runs():
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
    assert f"About {found.runs} such runs" in paragraph(found)


def test_bounds_of_the_most_informative_states_hold_a_motion():
    true, rival, limits = stribeck(), grease(), arm().limits
    low, high = most_informative(true, rival, OBSERVATION, limits, 200.0)
    at = states_within(limits, 300, seed=4)
    random = separation(true, rival, at, replace(OBSERVATION, rows=200.0)).separation
    assert random < low <= high
    assert high < 2.0 * low


def test_remedies_change_what_they_state():
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
