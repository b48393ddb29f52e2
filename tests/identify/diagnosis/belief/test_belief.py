"""What a search leaves open, and what runs would do about it, on an arm of two joints."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from exidyn.identification.diagnosis.belief.belief import Believed, Question, separations
from exidyn.identification.diagnosis.belief.gain_item import gain_deviations, gain_words, untested
from exidyn.identification.diagnosis.belief.open_items import information, items, parameter_entropy, remaining
from exidyn.identification.diagnosis.belief.questions import belief_of, confirmed
from exidyn.identification.diagnosis.belief.run_columns import run_columns
from exidyn.identification.diagnosis.belief.suspects import suspects_of
from exidyn.identification.effects import JointSpring, known_parameters
from exidyn.identification.recordings.recording import KnownPayload

from ....parts.small import small_diagnosis, small_search

pytestmark = pytest.mark.slow

BODY = KnownPayload("L", known_parameters(3.0, (0.1, 0.0, 0.05), (0.02, 0.0, 0.0, 0.02, 0.0, 0.02)))


@cache
def believed(gain=0.02, inertias=0.02):
    """After one run of an arm with a spring; another run on offer, without and with a body."""
    model = small_diagnosis.nominal_model()
    robot = replace(model.robot, drive_gain_tolerance=np.full(2, gain), inertial_tolerance=inertias)
    model = replace(model, robot=robot)
    spring, values = (JointSpring(("elbow",)),), {"Ks2": small_diagnosis.STIFFNESS}
    first, other = small_search.record(spring, values, ("identify", "identify"), model)
    search = small_search.searched([first], model)
    suspects, found = suspects_of(search), [one.answer for one in search.selected]
    offers = [other[1], replace(other[1], payload=BODY)]
    columns = [run_columns(search.problem, found, suspects.every, one) for one in offers]
    return belief_of(search, suspects, columns), columns


def question(belief, *effects):
    """As if each of some effects were as probable as the others."""
    keys = [(one.candidate.effect, one.candidate.joints) for one in belief.suspects]
    answers = [Believed(*one, 1.0 / len(effects), belief.places[keys.index(one)]) for one in effects]
    return Question(tuple(answers), True, np.zeros(0, int))


def apart(belief, asked, run):
    """Separations over the power of what is to be separated."""
    stances, gram = [belief.stance(asked, one) for one in asked.answers], information(belief, run)
    power = [np.sum(one.variations * (gram @ one.variations)) for one in stances]
    return separations(stances, gram) / np.array(power)[:, None]


def test_the_spring_is_a_question_and_what_was_not_found_is_counted_together():
    belief, _ = believed()
    every = items(belief)
    assert any("spring" in one.words for one in every[:-3])
    assert all(one.entropy >= 0.0 for one in every)
    assert all(np.isclose(one.probabilities.sum(), 1.0) for one in belief.questions)


def test_what_two_answers_share_no_run_separates_and_the_words_say_why():
    belief, [run, _] = believed()
    asked = question(belief, ("payload", ()), ("link_inertia", (1,)))
    alike = apart(belief, asked, run)
    other = apart(belief, question(belief, *(("coulomb_friction", (joint,)) for joint in (0, 1))), run)
    assert np.max(alike) < 0.1
    assert np.max(other) > 10.0 * np.max(alike)
    words = " ".join(remaining(belief, asked))
    assert "No motion can decide" in words
    assert "a run with a body of known mass on the flange" in words


def test_a_body_of_known_mass_settles_gains_and_masses_that_are_known_together_only():
    belief, [empty, loaded] = believed(gain=0.3, inertias=0.3)
    now = parameter_entropy(belief)
    without, with_body = (
        now - parameter_entropy(belief, information(belief, run)) for run in (empty, loaded)
    )
    assert 0.0 <= without <= now
    assert with_body > 2.0 * without


def test_what_gives_the_same_torque_is_a_rival_whatever_the_blocks_say():
    belief, _ = believed()
    [found] = belief.search.selected
    [asked] = [one for one in belief.questions if one.seen]
    assert found.answer.candidate.effect == "joint_spring"
    assert found.named
    assert {one.effect for one in asked.answers} == {"spring_balancer", "joint_spring", "position_curve", ""}
    assert max(asked.probabilities) < 0.9
    assert min(asked.probabilities) > 0.09
    assert items(belief)[0].open


def test_what_one_run_shows_is_no_proof_before_another_one_repeats_it():
    of_one, _ = believed()
    for search, repeated in ((of_one.search, False), (small_search.spring_search(), True)):
        assert [confirmed(search, place) for place in range(len(search.selected))] == [repeated]


def test_a_body_tests_gains_and_no_motion_without_one_does_where_masses_are_not_stated():
    belief, [empty, loaded] = believed(gain=0.03, inertias=100.0)
    assert untested(belief) == [0, 1]
    without, with_body = (gain_deviations(belief, information(belief, run)) for run in (empty, loaded))
    assert np.all(without > 0.06)  # by friction, which is stated
    assert np.all(with_body < 0.03)
    assert "taken as stated: no run so far or on offer tests them" in gain_words(belief)


def test_masses_that_are_stated_test_gains():
    belief, _ = believed()
    assert untested(belief) == []


def test_what_nothing_was_found_of_is_settled_where_nothing_is_credible():
    nothing, something = Believed("", (), 0.96, np.zeros(0, int)), Believed("payload", (), 0.04, np.arange(1))
    assert Question((nothing, something), True, np.zeros(0, int)).settled
    assert not Question((nothing, something), True, np.arange(1)).settled


def test_a_long_motion_is_looked_at_in_stretches_that_add_up_to_it(monkeypatch):
    model = small_diagnosis.nominal_model()
    first, other = small_search.record((), {}, ("identify", "identify"), model)
    search = small_search.searched([first], model)
    suspects = suspects_of(search).every
    whole = run_columns(search.problem, [], suspects, other[1], True)
    monkeypatch.setitem(run_columns.__globals__, "LONGEST", other[1].duration / 2.5)
    parts = run_columns(search.problem, [], suspects, other[1], True)
    count = len(whole.names)
    # Each stretch loses what its filters need at both ends.
    assert 0.6 * whole.rows < parts.rows < whole.rows
    sizes = [
        np.sqrt(np.diagonal(one.by_joint[:, :count, :count].sum(axis=0)) / one.rows) for one in (whole, parts)
    ]
    assert np.corrcoef(*sizes)[0, 1] > 0.99
    assert [len(one) for one in parts.suspects] == [len(one) for one in whole.suspects]
