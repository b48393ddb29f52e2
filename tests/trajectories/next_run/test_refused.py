"""Findings that the data contradict, or beside which more is left than they explain."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identify.effects import JointSpring
from exidyn.trajectories.next_run import refused as under_test
from exidyn.trajectories.next_run.belief import belief_of, suspects_of
from exidyn.trajectories.next_run.refused import refused, unnamed_odds

from ...parts.small import small_diagnosis, small_search, two_joints


def found(share, std=0.1, mean=1.0):
    """A search with one finding, of one coefficient."""
    answer = SimpleNamespace(
        values=np.array([share]), columns=SimpleNamespace(mean=np.array([mean]), std=np.array([std]))
    )
    prediction = SimpleNamespace(values=np.array([7.0, share]), rows=SimpleNamespace(names=["Fv1", "share"]))
    return SimpleNamespace(selected=[SimpleNamespace(answer=answer)], prediction=prediction)


@pytest.mark.parametrize(("share", "out"), [(1.0, False), (1.35, False), (1.826, True), (0.141, True)])
def test_a_coefficient_beyond_what_physics_allows_beside_all_refuses_the_finding(share, out):
    assert refused(found(share), 0) is out


def test_a_coefficient_of_which_physics_says_nothing_refuses_nothing():
    assert not refused(found(1e3, mean=0.0), 0)


@cache
def searched(nameless):
    """After two runs of an arm with a spring, and so much torque of no known kind on the same joint [N m]."""

    def change(_role, motion, current):
        wave = np.sin(2.0 * np.pi * motion.time * (1.0 + 0.05 * motion.time)) * np.sign(motion.velocity[:, 0])
        return current + np.outer(nameless * wave, [0.0, 1.0]) / two_joints.GAIN

    spring, values = (JointSpring(("elbow",)),), {"Ks2": small_diagnosis.STIFFNESS}
    runs = small_search.record(spring, values, ("identify", "identify"), change=change)
    return small_search.searched(runs)


@pytest.fixture
def quiet(monkeypatch):
    """Drives whose noise was measured at rest."""
    monkeypatch.setattr(under_test, "noise_floor", lambda runs: (np.full(2, 0.1), True))


def test_what_is_left_may_be_what_a_finding_is_part_of(quiet):
    alone, beside = (
        min(unnamed_odds(searched(left), place) for place in range(len(searched(left).selected)))
        for left in (0.0, 4.0)
    )
    assert alone < 0.01
    assert beside > 0.05


def test_a_finding_beside_which_much_is_left_is_open(quiet):
    probability = []
    for left in (0.0, 4.0):
        belief = belief_of(searched(left), suspects_of(searched(left)), [])
        nothing = [one for q in belief.questions if q.seen for one in q.answers if not one.effect]
        probability.append(min(one.probability for one in nothing))
    assert probability[1] > max(probability[0], 0.04)


def test_without_measured_noise_nothing_is_known_to_be_left(monkeypatch):
    monkeypatch.setattr(under_test, "noise_floor", lambda runs: (np.full(2, 0.1), False))
    assert unnamed_odds(searched(4.0), 0) == 0.0
