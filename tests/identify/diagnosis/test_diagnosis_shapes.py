"""Shapes that were found before are asked for beside the grid."""

import pytest

from exidyn.identification.diagnosis.candidates import candidates
from exidyn.identification.diagnosis.questions.shape import Shaped, in_found_shapes
from exidyn.identification.diagnosis.search.problem import Problem

from ...parts.small import small_diagnosis, small_search

RINGING = {"resonance": 5.404, "damping_ratio": 0.011}


def gears(asked):
    return [one for one in asked if one.key[:2] == ("joint_elasticity", (1,))]


def test_a_shape_between_those_of_the_grid_is_asked_for():
    grid = gears(candidates(small_diagnosis.nominal_model()))
    [one] = in_found_shapes(grid, [Shaped("joint_elasticity", (1,), "", RINGING)])
    assert {name: one.shape[name] for name in RINGING} == RINGING
    assert one.key == grid[0].key
    assert all(abs(one.shape["resonance"] - other.shape["resonance"]) > 0.1 for other in grid)


@pytest.mark.parametrize(
    "other",
    [
        Shaped("joint_elasticity", (7,), "", RINGING),
        Shaped("joint_elasticity", (1,), "", {"resonance": 5.4}),
        Shaped("no_such_effect", (1,), "", RINGING),
    ],
    ids=["another arm's joint", "other numbers", "an effect that is gone"],
)
def test_what_the_model_does_not_have_is_left_out(other):
    assert not list(in_found_shapes(list(candidates(small_diagnosis.nominal_model())), [other]))


def test_a_problem_has_columns_of_the_shape():
    one = small_search.sound_problem()
    again = Problem.of(one.model, one.runs, [Shaped("joint_elasticity", (1,), "", RINGING)])
    assert len(again.candidates) == len(one.candidates) + 1
    found = [pair for pair in again.candidates if pair[0].shape.get("resonance") == RINGING["resonance"]]
    assert len(found) == 1
    assert found[0][1].values.shape[0] == len(again.rows.columns)
