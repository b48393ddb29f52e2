"""Runs held out: findings and fitted parameters predict them no worse than the nominal model does."""

from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identify.diagnosis.search import checks
from exidyn.identify.effects import JointSpring

from ...parts.small import two_joints
from ...parts.small.small_search import names, problem, record, searched


def test_a_finding_is_compared_with_the_model_without_it_on_runs_held_out():
    found = searched(record([JointSpring(("elbow",))], {"Ks2": 6.0}))
    with_spring, without = (
        checks._held_out(found.problem, some, found.without_findings) for some in (found.selected, ())
    )
    assert with_spring[1] < 0.5
    assert np.all(without > 0.95)  # but for weights that are estimated anew


@pytest.mark.parametrize(
    ("fitted", "nominal", "kept"), [(1.2, 0.9, "nominal"), (1.2, 1.3, "fitted"), (1.03, 0.9, "fitted")]
)
def test_nominal_values_stay_where_fitted_ones_predict_a_joint_worse(monkeypatch, fitted, nominal, kept):
    at_nominal = SimpleNamespace()
    as_fitted = SimpleNamespace(at_nominal=lambda: at_nominal)
    squares = {id(as_fitted): [0.5, fitted], id(at_nominal): [0.5, nominal]}
    monkeypatch.setattr(checks, "_held_out", lambda one, *_: np.array(squares[id(one)]))
    chosen = checks.nominal_where_better(as_fitted, [object()], None)
    assert chosen is {"nominal": at_nominal, "fitted": as_fitted}[kept]
    assert checks.nominal_where_better(as_fitted, [], None) is as_fitted


def test_a_problem_at_nominal_holds_what_the_model_states():
    one = problem(record([JointSpring(("elbow",))], {"Ks2": 6.0}))
    held, free = one.at_nominal().prediction([]), one.prediction([])
    np.testing.assert_allclose(held.values[one.stated], held.rows.mean[one.stated], atol=1e-9)
    assert np.any(np.abs(free.values - free.rows.mean)[one.stated] > 1e-3)


def tight_spot(role, motion, current):
    """Dry friction of the elbow that is larger near one angle."""
    near = np.exp(-0.5 * ((motion.position[:, 1] - 0.3) / 0.25) ** 2)
    return current + np.outer(2.0 * near * np.sign(motion.velocity[:, 1]), [0.0, 1.0]) / two_joints.GAIN


def test_a_finding_that_predicts_worse_stays_in_a_shape_that_does_not(monkeypatch):
    found = searched(record(change=tight_spot))
    [one] = found.selected
    assert names(found) == [("position_dependent_friction", (1,))]
    assert len(one.answer.candidate.names) == 12

    def never_worse(limit):
        """What stays where shapes of more coefficients predict a joint worse."""
        many = lambda some: any(len(each.answer.candidate.names) > limit for each in some)  # noqa: E731
        monkeypatch.setattr(checks, "_held_out", lambda _, some, __: np.array([0.9, 0.9 + many(some)]))
        return checks._never_worse(found.problem, list(found.selected), found.without_findings, 10.0)

    assert never_worse(12)[0] is one
    [again] = never_worse(2)
    assert again.answer.candidate.key == one.answer.candidate.key
    assert len(again.answer.candidate.names) == 2
    assert 0.0 < again.answer.gain < one.answer.gain
    assert not never_worse(1)
    # Without findings nothing can go.
    monkeypatch.setattr(checks, "_held_out", lambda *_: np.array([1.5]))
    assert checks._never_worse(found.problem, [], found.without_findings, 10.0) == []
