"""Adequacy: a model that fits is adequate; what no hypothesis describes is located, and nothing is named."""

import numpy as np
import pytest

from exidyn.identification.diagnosis.findings.adequacy import Adequacy
from exidyn.identification.diagnosis.results.adequacy import adequacy
from exidyn.identification.diagnosis.search.problem import Problem
from exidyn.identification.plausible.adequacy import failing_joints, pooled_share

from ...parts.small.small_search import problem, record

pytestmark = [pytest.mark.numerical, pytest.mark.slow]


def adequacy_of(at: Problem) -> Adequacy:
    """Adequacy without findings."""
    return adequacy(at, at.without_findings)


def test_a_correct_recording_is_adequate_and_a_wrong_one_is_located():
    right = adequacy_of(problem(record()))
    assert right.failing == right.misfits == ()
    assert right.pooled_share < 0.05
    np.testing.assert_allclose(right.shares, right.shares_alone, rtol=0.3)

    def frozen(role, motion, current):
        stands = (motion.time > 3.0) & (motion.time < 4.0)
        return np.where(stands[:, None], current[np.argmax(stands)], current)

    wrong = adequacy_of(problem(record(change=frozen)))
    assert 0 in wrong.failing
    assert all(wrong.fails(joints) for joints in ((), (0,)))
    assert {misfit.joint for misfit in wrong.misfits} == set(wrong.failing)
    assert all(misfit.start < 4.0 and misfit.end > 3.0 for misfit in wrong.misfits)


def test_joints_fail_that_fit_alone_only_and_those_without_which_the_others_fit():
    power, revolute = np.array([1e4, 1e4, 1e2, 1.0]), np.array([True, True, True, False])
    fine = np.array([10.0, 10.0, 4.0, 0.005])
    assert failing_joints(fine, fine, power, revolute) == ()
    assert failing_joints(fine * [1, 7, 1, 1], fine, power, revolute) == (1,)
    assert failing_joints(fine * [1, 1, 7, 1], fine * 3, power, revolute) == (2,)  # .53 of its torque
    # 1 % of the squared torque in N m are 201: the largest error is more, and the rest is not
    assert failing_joints(np.array([300.0, 10.0, 20.0, 0.005]), np.full(4, 1e3), power, revolute) == (0,)
    # forces are judged apart from torques
    assert failing_joints(fine * [1, 1, 1, 4], np.full(4, 1e3), power, revolute) == (3,)
    assert pooled_share(fine * [1, 1, 1, 4], power, revolute) == pytest.approx(np.sqrt(0.02))
