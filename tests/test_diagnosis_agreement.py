"""What joints and runs say of the size of a finding, and what it is worth if they disagree."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from exidyn.identify.diagnosis.agreement import agreed, loudest, sizes, told
from exidyn.identify.diagnosis.candidate import Candidate, Thinned
from exidyn.identify.diagnosis.confirmed import _felt, _mostly_else
from exidyn.identify.diagnosis.found import Found
from exidyn.identify.diagnosis.hypothesis import Hypothesis
from exidyn.identify.diagnosis.remainder import Left
from exidyn.identify.diagnosis.rows import Rows
from exidyn.identify.diagnosis.solving import solved

ROWS, JOINTS, RUNS = 600, 3, (slice(0, 300), slice(300, 600))
ODDS = 30.0


def searched(size, seed=0):
    """A finding whose torque is there by a size (runs, joints), beside another unknown and noise."""
    rng = np.random.default_rng(seed)
    column, other = rng.normal(size=(2, ROWS, JOINTS, 1))
    torque = column[:, :, 0] * np.repeat(size, 300, axis=0) + 0.5 * other[:, :, 0]
    rows = Rows(
        RUNS,
        torque + rng.normal(size=(ROWS, JOINTS)) * 3.0,
        np.ones((ROWS, JOINTS)),
        np.concatenate([other, column], axis=2),
        ("other", "joint_elasticity share"),
        np.array([10.0, 10.0]),
        np.zeros(2),
    )
    solution = solved(rows)
    candidate = Candidate("joint_elasticity", (1,), lambda run: run, ("share",), ("1",), (-np.inf,))
    thinned = Thinned(np.arange(JOINTS), column, np.array([1.0]), np.array([0.0]))
    one = Found(Hypothesis(candidate, thinned, solution.values[1:], ODDS, ODDS), (), ODDS)
    return SimpleNamespace(found=(one,), rows=rows, solution=solution), one


def big(found):
    """The finding with as much evidence as any rows may tell."""
    one = found.found[0]
    found.found = (one._replace(hypothesis=replace(one.hypothesis, evidence=1e9)),)
    return found.found[0]


def test_every_joint_in_every_run_tells_the_size_of_a_finding():
    found, one = searched(np.ones((2, JOINTS)))
    said, known, joints = sizes(found, one)
    assert joints.tolist() == [0, 0, 1, 1, 2, 2]
    value = found.solution.values[1]
    assert np.sum(known * said) / np.sum(known) == pytest.approx(1.0, abs=0.02)
    # As sure as noise of 3 and 300 rows allow, for a size in units of the value.
    assert known == pytest.approx(np.full(6, 300 * value**2 / 9.0), rel=0.3)
    assert np.all(np.abs(said - 1.0) < 4.0 / np.sqrt(known))


def test_a_finding_of_one_size_is_as_credible_as_it_was():
    assert [agreed(*searched(np.ones((2, JOINTS)), seed)) for seed in range(20)] == [ODDS] * 20


def test_joints_or_runs_that_disagree_take_credit_from_a_finding():
    elsewhere = np.array([[3.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    in_one_run = np.array([[2.0, 2.0, 2.0], [0.0, 0.0, 0.0]])
    for size in (elsewhere, in_one_run):
        assert agreed(*searched(size)) < ODDS - 10.0


def test_what_is_strong_stands_although_its_formula_is_not_quite_right():
    found, one = searched(10.0 * np.array([[1.1, 1.0, 0.9], [1.05, 1.0, 0.95]]))
    evidence = 0.5 * float(np.sum(sizes(found, one).known))
    sure = one._replace(odds=evidence, hypothesis=replace(one.hypothesis, evidence=evidence, own=evidence))
    found.found = (sure,)
    assert 0.01 * evidence < agreed(found, sure) < 0.5 * evidence


def test_what_another_unknown_could_do_as_well_tells_rows_nothing():
    found, one = searched(np.ones((2, JOINTS)))
    great = one._replace(hypothesis=replace(one.hypothesis, evidence=1e9))
    found.found = (great,)
    assert told(found, great) == pytest.approx(np.sum(sizes(found, great).known), rel=0.05)
    columns = found.rows.columns.copy()
    columns[:, :, 0] = columns[:, :, 1]
    alike = solved(replace(found.rows, columns=columns))
    again = SimpleNamespace(found=(great,), rows=alike.rows, solution=alike)
    assert told(again, great) < 0.01 * told(found, great)


@pytest.mark.parametrize(
    ("effect", "evidence", "left", "depends_on", "gone"),
    [
        ("joint_spring", 300.0, 20.0, "load", False),
        ("joint_spring", 300.0, 250.0, "load", True),  # nearly as much as is explained
        ("joint_spring", 300.0, 250.0, "position", False),  # more of the same: the formula's error
        ("joint_spring", 300.0, 350.0, "position", True),  # more than the whole formula
        ("joint_spring", 300.0, 5.0, "load", False),  # nothing that is credible
    ],
)
def test_a_name_has_to_explain_more_than_is_left_without_one(effect, evidence, left, depends_on, gone):
    found, one = searched(np.ones((2, JOINTS)))
    hypothesis = one.hypothesis
    candidate = replace(hypothesis.candidate, effect=effect)
    named = one._replace(hypothesis=replace(hypothesis, candidate=candidate, evidence=evidence))
    found.found = (named,)
    # All joints are alike, so that it is the first that counts; what is left has a hundredth of the torque.
    small = replace(hypothesis, values=0.1 * hypothesis.values)
    noise = np.full(JOINTS, 3.0)
    found.solution.whitening.scale[:] = 1.0
    places = [Left(joint, depends_on, left, small) for joint in range(JOINTS)]
    assert _mostly_else(found, named, places, noise) == gone


def test_what_joints_feel_beside_the_one_that_feels_most():
    everywhere, one = searched(np.ones((2, JOINTS)))
    _, beside = loudest(everywhere, one)
    assert beside == pytest.approx(told(everywhere, big(everywhere)) * 2 / 3, rel=0.15)
    alone, one = searched(np.array([[0.0, 1.0, 0.0]] * 2))
    joint, beside = loudest(alone, one)
    assert joint == 1
    assert beside < 0.0


@pytest.mark.parametrize(
    ("size", "another_on", "touch"),
    [([0.0, 1.0, 0.0], 1, False), ([0.0, 1.0, 0.0], 2, True), ([2.0, 2.0, 0.0], 1, True)],
)
def test_what_one_joint_feels_beside_another_finding_of_it_is_no_touch(size, another_on, touch):
    found, one = searched(np.array([size] * 2))
    contact = replace(one.hypothesis, candidate=replace(one.hypothesis.candidate, effect="contact_event"))
    event = one._replace(hypothesis=contact)
    columns = replace(contact.columns, joints=np.array([another_on]))
    other = one._replace(hypothesis=replace(one.hypothesis, columns=columns))
    found.found = (event,)
    assert _felt(found, event)  # nothing else was found
    found.found = (other, event)
    found.rows = found.rows.plus(["more"], 0.0 * found.rows.columns[:, :, :1], np.ones(1))
    order = [0, 2, 1]  # the event's column is the last
    found.rows = replace(found.rows, columns=found.rows.columns[:, :, order])
    found.solution = solved(found.rows)
    assert _felt(found, event) == touch
