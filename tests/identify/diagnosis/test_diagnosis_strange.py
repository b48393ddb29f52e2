"""Shapes whose coefficient is not what physics expects: excluded, unless a finer shape of theirs is not."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.diagnosis.questions.candidate import Thinned
from exidyn.identification.diagnosis.questions.question import ask
from exidyn.identification.diagnosis.questions.shape import reshaped
from exidyn.identification.diagnosis.search import ranking
from exidyn.identification.diagnosis.search.ranking import ranked

from ...parts.small.small_search import sound_problem

TRIED = 3.0
"""Resonance on the grid [Hz]."""


@pytest.fixture(scope="module")
def clean():
    return sound_problem(2)


def with_gear(clean, resonance, share=1.0):
    """A problem that asks for one resonance only, and an arm whose gear has another."""
    asked = [pair for pair in clean.candidates if pair[0].key == ("joint_elasticity", (1,), "")]
    tried = min(asked, key=lambda pair: abs(pair[0].shape["resonance"] - TRIED))
    true = tried[0].reshaped({**tried[0].shape, "resonance": resonance})
    columns = Thinned.of(true, clean.runs)
    torque = share * columns.everywhere(2) @ columns.mean
    rows = replace(clean.rows, difference=clean.rows.difference + torque)
    return replace(clean, rows=rows, candidates=[tried])


def test_a_strange_shape_is_no_answer_until_another_is_found_near_it(clean):
    soft = with_gear(clean, 3.75)
    prediction = soft.prediction([])
    assert ask(prediction, soft.candidates) == []
    [strange] = ask(prediction, soft.candidates, strange=True)
    assert strange.strange
    best = ranked(soft, prediction, [], {})[0]
    assert best.candidate.key == strange.candidate.key
    assert not best.strange
    assert best.gain > strange.gain
    assert best.candidate.shape["resonance"] == pytest.approx(3.75, rel=0.05)


def test_a_strange_shape_without_a_finer_one_is_no_answer(clean):
    asked = with_gear(clean, 3.75)
    only = [(replace(candidate, bounds={}), columns) for candidate, columns in asked.candidates]
    best = ranked(replace(asked, candidates=only), asked.prediction([]), [], {})
    assert "joint_elasticity" not in {one.candidate.effect for one in best}


def test_a_shape_that_was_searched_is_asked_again_and_not_searched_anew(clean, monkeypatch):
    soft, shapes, searched = with_gear(clean, 3.75), {}, []
    prediction = soft.prediction([])
    once = ranked(soft, prediction, [], shapes)[0]
    assert list(shapes) == [once.candidate.key]

    def fails(prediction, answer, *more):
        searched.append(answer.candidate.key)
        return answer

    monkeypatch.setattr(ranking, "refined", fails)
    again = ranked(soft, prediction, [], shapes)[0]
    assert searched == []
    assert again.candidate.shape == once.candidate.shape
    np.testing.assert_allclose(again.errors, once.errors, rtol=1e-6)


def test_a_shape_of_the_grid_that_fits_better_than_the_one_known_is_refined(clean):
    soft, shapes = with_gear(clean, 3.75), {}
    ranked(soft, soft.prediction([]), [], shapes)
    [(key, known)] = shapes.items()
    far = reshaped(known.candidate, {"resonance": 9.0})
    shapes = {key: replace(known, candidate=far, columns=Thinned.of(far, soft.runs))}
    best = ranked(soft, soft.prediction([]), [], shapes)[0]
    assert best.candidate.shape["resonance"] == pytest.approx(3.75, rel=0.05)
