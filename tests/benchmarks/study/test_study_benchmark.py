"""The benchmark of a study: which programme is the best, and what is counted."""

import pytest
from common import Kept
from parts.study.answer import Answer
from parts.study.best import best_programme
from parts.study.case import LEANS, Case, named, others, scored
from parts.study.programme import Run, programmes
from study import compared


def answer(found, motion=20.0, error=0.01, still=frozenset(), decided=True):
    return Answer(found, still, error, motion, decided, 0)


def test_arms_that_are_scored_are_not_those_on_which_programmes_are_searched():
    assert not {case.seed for case in scored()} & {case.seed for case in others()}


def test_what_is_alike_has_to_stay_open():
    case = Case.drawn("a base that leans", 1)
    assert answer(frozenset(), still=LEANS).right(case)
    assert not answer(frozenset()).right(case)
    assert not answer(named([("base_tilt", ())]), still=LEANS).right(case)


def test_wrong_gains_are_to_be_named():
    case = Case.drawn("gains", 1)
    assert not answer(frozenset()).right(case)
    assert answer(named([("drive_gain", (1,)), ("drive_gain", (2,))])).suffices(case)


def test_the_best_programme_is_the_shortest_that_suffices_for_most():
    cases = others()
    enough = frozenset({Run("chirp", True), Run("excitation", False)})

    def asked(pairs):
        return [
            answer(
                case.concealed if enough <= set(programme) else frozenset({("backlash", (1,))}),
                9.0 * len(programme),
            )
            for case, programme in pairs
        ]

    best, share = best_programme(cases, asked)
    assert frozenset(best) == enough
    assert share == 1.0


def test_programmes_have_two_or_three_runs_and_long_ones_no_third():
    every = list(programmes())
    assert {len(one) for one in every} == {2, 3}
    assert all(run.motion != "sweeps" for one in every if len(one) == 3 for run in one)


def test_a_wrong_end_is_counted_and_motion_only_where_both_suffice():
    cases = [Case.drawn("nothing", 1), Case.drawn("gains", 2)]
    study = [answer(frozenset(), 10.0), answer(frozenset(), 10.0)]
    fixed = [answer(frozenset(), 20.0), answer(cases[1].concealed, 20.0)]
    table = compared(cases, study, fixed)
    assert (table["right"], table["fixed_right"], table["false_decided"]) == (0.5, 1.0, 1)
    assert table["motion_over_best_fixed"] == pytest.approx(0.5)


def test_results_are_kept_as_soon_as_they_are_there(tmp_path):
    path = tmp_path / "results.jsonl"
    assert Kept(path).of("one", lambda: {"right": True}) == {"right": True}
    assert Kept(path).of("one", lambda: 1 / 0) == {"right": True}
