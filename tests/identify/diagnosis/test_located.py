"""The table that comes first: parts of a joint's misfit by what its torque depends on."""

from types import SimpleNamespace

import numpy as np

from exidyn.identification.diagnosis.candidates import dependence_of, family_of
from exidyn.identification.diagnosis.findings.family import FAMILIES
from exidyn.identification.diagnosis.findings.residuals import Budget, Remainder, Share
from exidyn.identification.diagnosis.results.budget import LEAST, located


def found(effect, probability, *joints):
    candidate = SimpleNamespace(effect=effect, joints=joints, kind="", shape={"exponent": 0.5})
    answer = SimpleNamespace(candidate=candidate, columns=SimpleNamespace(joints=joints))
    return SimpleNamespace(answer=answer, dependence_probability=probability, proven=True)


def test_a_row_has_the_finding_that_acts_on_its_joint_and_its_own_probability():
    selected = [
        found("stribeck_friction", 0.99, 0),
        found("nonlinear_viscous_friction", 0.6, 1),
        found("hose", 0.9, 0, 1),
    ]
    shares = (
        Share(0, "", 100.0 * np.array([0.3, 0.1])),  # masses that it frees explain more of the other joint
        Share(1, "", 100.0 * np.array([0.0, 0.2])),
        Share(2, "", 100.0 * np.array([0.5 * LEAST, 0.3])),
        Share(None, "velocity", 100.0 * np.array([0.1, 0.15])),
        Share(None, "sensor noise", 100.0 * np.array([0.595, 0.25])),
    )
    budget = Budget(np.ones(2), np.ones(2), shares, ("other",))
    rows = located(budget, selected, [Remainder(1, 3.0, 0.995, "velocity")])
    assert [(row.joint, row.depends_on, row.finding, row.probability) for row in rows] == [
        (0, "sensor noise", None, None),
        (0, "velocity", 0, 0.99),
        (0, "velocity", None, None),
        (1, "hose", 2, 0.9),
        (1, "sensor noise", None, None),
        (1, "velocity", 1, 0.6),
        (1, "velocity", None, 0.995),
    ]


def test_an_effect_of_no_family_has_no_dependence():
    assert dependence_of(found("hose_spring", 1.0, 0).answer.candidate) == ""
    spring = found("joint_spring", 1.0, 0).answer.candidate
    assert dependence_of(spring) == FAMILIES[family_of(spring)].dependence == "position"
