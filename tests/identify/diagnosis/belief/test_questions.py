"""Findings that the data contradict, or beside which more is left than they explain."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.belief.questions import (
    belief_of,
    excluded_by_physics,
    nameless_odds,
    nameless_torque,
)
from exidyn.identification.diagnosis.belief.suspects import suspects_of
from exidyn.identification.diagnosis.findings.residuals import UNCERTAIN, Remainder
from exidyn.identification.effects import JointSpring

from ....parts.small import small_diagnosis, small_search, two_joints


def found(share, std=0.1, mean=1.0):
    """A search with one finding, of one coefficient."""
    answer = SimpleNamespace(
        values=np.array([share]), columns=SimpleNamespace(mean=np.array([mean]), std=np.array([std]))
    )
    prediction = SimpleNamespace(values=np.array([7.0, share]), rows=SimpleNamespace(names=["Fv1", "share"]))
    return SimpleNamespace(selected=[SimpleNamespace(answer=answer)], prediction=prediction)


@pytest.mark.parametrize(("share", "out"), [(1.0, False), (1.35, False), (1.826, True), (0.141, True)])
def test_a_coefficient_beyond_what_physics_allows_beside_all_refuses_the_finding(share, out):
    assert excluded_by_physics(found(share), 0) is out


def test_a_coefficient_of_which_physics_says_nothing_refuses_nothing():
    assert not excluded_by_physics(found(1e3, mean=0.0), 0)


@cache
def searched(also):
    """After two runs of an arm with a spring, and so much torque of no known kind on the same joint [N m]."""

    def change(_role, motion, current):
        wave = np.sin(2.0 * np.pi * motion.time * (1.0 + 0.05 * motion.time)) * np.sign(motion.velocity[:, 0])
        return current + np.outer(also * wave, [0.0, 1.0]) / two_joints.GAIN

    spring, values = (JointSpring(("elbow",)),), {"Ks2": small_diagnosis.STIFFNESS}
    runs = small_search.record(spring, values, ("identify", "identify"), change=change)
    return small_search.searched(runs)


def diagnosis(depends_on):
    """What a diagnosis says is left on the second joint."""
    remainder = Remainder(1, 3.0, 0.99, depends_on)
    return SimpleNamespace(evidence=SimpleNamespace(noise=np.full(2, 0.1)), remainders=(remainder,))


def test_what_is_left_and_depends_on_something_may_be_what_a_finding_is_part_of():
    few, many = (nameless_torque(diagnosis("time, at 1.0 Hz"), searched(also)) for also in (0.0, 4.0))
    assert many[0] == few[0] == 0.0
    assert many[1] == pytest.approx(8.0, rel=0.5)
    assert few[1] < 0.05 * many[1]
    assert nameless_odds(searched(4.0), 0, many) > 20.0 * nameless_odds(searched(0.0), 0, few)


def test_what_depends_on_nothing_is_noise():
    assert not np.any(nameless_torque(diagnosis(UNCERTAIN), searched(4.0)))


def nothing_by(search, left):
    belief = belief_of(search, suspects_of(search), [], left)
    question = next(one for one in belief.questions if one.seen)
    return next(one.probability for one in question.answers if not one.effect)


def test_a_finding_beside_which_more_is_left_than_it_explains_is_open():
    search = searched(4.0)
    square = 8.0 / nameless_odds(search, 0, np.array([0.0, 8.0]))
    for share, least, most in ((0.5, 0.0, 0.05), (2.0, 0.05, 0.15)):
        nothing = nothing_by(search, np.array([0.0, share * square]))
        assert least <= nothing <= most
