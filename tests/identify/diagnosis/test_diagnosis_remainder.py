"""What is left: lines in spectra that two runs have."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.blocks.block_likelihood import common_variance
from exidyn.identification.diagnosis.questions.block_answer import Answer
from exidyn.identification.diagnosis.questions.candidate import Candidate
from exidyn.identification.diagnosis.results.remainder import beside_unnamed, discrepancies, line, remainders

from ...parts.small.small_search import spring_search


def left(amplitude, rng, lined=(0, 1)):
    parts = [rng.normal(size=800) for _ in range(3)]
    for run in lined:
        parts[run] = parts[run] + amplitude * np.sin(2 * np.pi * 0.117 * np.arange(800) + run)
    whole = np.concatenate(parts)[:, None]
    runs = tuple(slice(800 * k, 800 * (k + 1)) for k in range(3))
    return SimpleNamespace(
        rate=100.0, rows=SimpleNamespace(runs=runs, weight=np.ones((2400, 1))), residual=whole
    )


def test_line_is_found_where_two_runs_have_it():
    assert line(left(0.6, np.random.default_rng(8)), 0) == pytest.approx(11.7, abs=0.2)


@pytest.mark.parametrize("seed", range(3))
def test_no_line_in_noise_or_in_one_run_alone(seed):
    rng = np.random.default_rng(seed)
    assert line(left(0.0, rng), 0) == 0.0
    assert line(left(0.6, rng, lined=(1,)), 0) == 0.0


@pytest.mark.parametrize(("share", "found"), [(0.1, 0), (0.6, 1)])
def test_what_is_left_is_the_main_part_by_what_it_explains_and_not_by_its_torque(share, found):
    blocks, rows = 20, 40
    residual = np.random.default_rng(3).normal(size=(blocks * rows, 1))
    prediction = SimpleNamespace(
        rate=100.0,
        rows=SimpleNamespace(runs=(slice(0, blocks * rows),), weight=np.ones_like(residual)),
        residual=residual,
        common_variance=lambda errors, share: common_variance(share * errors, np.full((blocks, 1), rows)),
    )
    before, size = np.full((blocks, 1), float(rows)), np.full(blocks, 9.0)
    # Its own torque is thirty times the noise; the model's parameters take most of that back.
    torque = SimpleNamespace(joints=[0], values=np.full((*residual.shape, 1), 30.0), mean=np.zeros(1))
    answer = Answer(
        candidate=Candidate("velocity", (0,), lambda run: run, ("a",), ("N m",), (-np.inf,)),
        columns=torque,
        values=np.ones(1),
        free=np.ones(1, bool),
        predicted=before,
        errors=(1.0 - share) * before,
        along=size + np.random.default_rng(4).normal(size=blocks),
        size=size,
        gains=np.full((blocks, 1), 2.0),
        independent=np.ones(1),
        fitted=np.ones(blocks, bool),
    )
    assert len(remainders(prediction, [answer], np.ones(1), False, 0.7)) == found


@pytest.mark.parametrize(("share", "named"), [(0.1, 1), (3.0, 0)])
def test_a_finding_is_not_named_where_as_much_is_left_without_a_name(share, named):
    found = spring_search()
    [spring] = found.selected
    explained = spring.answer.predicted - spring.answer.errors
    feature = Candidate("velocity", (1,), lambda run: run, ("a",), ("N m",), (-np.inf,))
    left = replace(
        spring.answer, candidate=feature, predicted=spring.answer.errors + share * np.maximum(explained, 0.0)
    )
    [beside] = beside_unnamed(found, [left], np.full(2, np.inf)).selected
    assert beside.named == named
    assert spring.certainty > 0.99
    assert beside.certainty == pytest.approx(spring.certainty) if named else beside.certainty < 0.5


@pytest.mark.parametrize(("size", "named"), [(1.0, 1), (1e-6, 0)])
def test_a_finding_is_not_named_where_any_hypothesis_would_take_as_much_of_what_is_left(size, named):
    """What is left depends on nothing in particular: an eighth of it goes along with any dependence."""
    found = spring_search()
    [spring] = found.selected
    explained = np.maximum(spring.answer.predicted - spring.answer.errors, 0.0)
    weak = replace(spring.answer, predicted=spring.answer.errors + size * explained)
    every = discrepancies(found.problem, found.prediction)
    weakly = replace(found, selected=(spring._replace(answer=weak),))
    [beside] = beside_unnamed(weakly, every, np.zeros(2)).selected
    assert beside.named == named


@pytest.mark.parametrize(
    ("over", "rested", "found"), [(1.8, True, 0), (2.3, True, 1), (2.3, False, 0), (12.0, False, 1)]
)
def test_more_than_twice_the_noise_at_rest_is_left_though_it_depends_on_nothing(over, rested, found):
    residual = over * np.random.default_rng(5).normal(size=(800, 1))
    prediction = SimpleNamespace(
        rate=100.0, rows=SimpleNamespace(runs=(slice(0, 800),), weight=np.ones((800, 1))), residual=residual
    )
    assert len(remainders(prediction, [], np.ones(1), rested)) == found
