"""The table that comes first: parts of a joint's misfit by what its torque depends on."""

from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.candidates import dependence_of, family_of
from exidyn.identification.diagnosis.findings.family import FAMILIES
from exidyn.identification.diagnosis.findings.residuals import Budget, Remainder, Share
from exidyn.identification.diagnosis.results.budget import LEAST, located


def found(effect, probability, joint=0):
    candidate = SimpleNamespace(effect=effect, joints=(joint,), kind="", shape={"exponent": 0.5})
    return SimpleNamespace(
        answer=SimpleNamespace(candidate=candidate), dependence_probability=probability, proven=True
    )


def test_findings_of_one_dependence_are_one_row_and_small_parts_are_none():
    selected = [
        found("stribeck_friction", 0.99),
        found("nonlinear_viscous_friction", 0.6),
        found("hose", 0.9),
    ]
    shares = (
        Share(0, "", 100.0 * np.array([0.3, 0.0])),
        Share(1, "", 100.0 * np.array([0.2, 0.5 * LEAST])),
        Share(2, "", 100.0 * np.array([0.0, 0.4])),
        Share(None, "load", 100.0 * np.array([0.1, 0.2])),
        Share(None, "sensor noise", 100.0 * np.array([0.4, 0.395])),
    )
    budget = Budget(np.ones(2), np.ones(2), shares, ("other",))
    rows = located(budget, selected, [Remainder(1, 3.0, 0.995, "load")])
    assert [(row.joint, row.depends_on, row.finding) for row in rows] == [
        (0, "velocity", 0),
        (0, "sensor noise", None),
        (0, "load", None),
        (1, "hose", 2),
        (1, "sensor noise", None),
        (1, "load", None),
    ]
    assert rows[0].share == pytest.approx(0.5)
    assert [row.probability for row in rows] == [0.99, None, None, 0.9, None, 0.995]


def test_an_effect_of_no_family_has_no_dependence():
    assert dependence_of(found("hose_spring", 1.0).answer.candidate) == ""
    spring = found("joint_spring", 1.0).answer.candidate
    assert dependence_of(spring) == FAMILIES[family_of(spring)].dependence == "position"
