"""A balancer that was found is told as the data know it: products of stiffness and lengths, and torque."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.diagnosis import Quantity
from exidyn.identification.diagnosis.candidates.springs import LEVERS, PRELOAD, STIFFNESS, balancers
from exidyn.identification.diagnosis.diagnose import _range
from exidyn.identification.diagnosis.findings.arm import Arm
from exidyn.identification.diagnosis.improved.improved import with_finding
from exidyn.identification.diagnosis.words.diagnosis_file import as_json
from exidyn.identification.diagnosis.words.measures import in_units_of_joints
from exidyn.identification.diagnosis.words.verdict import details
from exidyn.identification.effects import SpringBalancer
from exidyn.identification.simulation.plant import Transmission

from ...parts.small import two_joints
from .test_diagnosis_words import diagnosis, finding, summary

TRUE = SpringBalancer("shoulder", d21=0.7, d22=0.21, phi=0.4)
KR, K0 = 50400.0, -20000.0


def found():
    """As the search has it: lengths over d21, so stiffness times its square."""
    values = {"Kr": KR * 0.7**2, "K0": K0 * 0.7, "d21": 1.0, "d22": 0.3, "phi": 0.4}
    units = {"Kr": "N/m", "K0": "N", "d21": "m", "d22": "m", "phi": "rad"}
    numbers = {name: Quantity(value, 0.01 * abs(value), units[name]) for name, value in values.items()}
    ends = {"torque_least": Quantity(-3100.0, np.nan, "N m"), "torque_most": Quantity(240.0, np.nan, "N m")}
    return finding("spring_balancer", (0,), parameters=numbers | ends)


def stated():
    """As a diagnosis states it."""
    return in_units_of_joints(found(), two_joints.arm())


def test_stiffness_is_told_with_the_length_that_is_not_known():
    table = as_json(diagnosis(stated()))["findings"][0]["parameters"]
    assert set(table) == {STIFFNESS, PRELOAD, LEVERS, "phi", "torque_least", "torque_most"}
    assert {table[name]["unit"] for name in (STIFFNESS, PRELOAD)} == {"N m"}
    assert table[STIFFNESS]["value"] / TRUE.d21**2 == pytest.approx(KR)
    assert table[PRELOAD]["value"] / TRUE.d21 == pytest.approx(K0)
    assert table[LEVERS]["value"] * TRUE.d21 == pytest.approx(TRUE.d22)
    page = summary(diagnosis(stated()))
    assert "N/m " not in page.replace("[N/m]", "")
    told = diagnosis(stated())
    lines = " ".join(details(told, told.findings[0]))
    assert "from -3100 to 240.0 N m over the recorded range" in lines
    assert "With d21 from the drawing, the distance of its fixed end from the axis, K_r is" in lines


def test_the_products_are_the_same_torque_at_any_length():
    motion = Motion.of(np.arange(5.0), *np.random.default_rng(0).normal(size=(3, 5, 2)))
    robot = two_joints.arm()
    relative = replace(TRUE, d21=1.0, d22=0.3)
    np.testing.assert_allclose(
        relative.regressor(robot, motion) @ [KR * 0.7**2, K0 * 0.7], TRUE.regressor(robot, motion) @ [KR, K0]
    )


def test_the_range_of_torque_is_that_of_what_was_recorded():
    candidate = next(balancers(two_joints.model()))
    columns = SimpleNamespace(values=np.array([[[1.0, 2.0]], [[3.0, -1.0]], [[0.5, 0.5]]]))
    ends = _range(SimpleNamespace(candidate=candidate, columns=columns), np.array([2.0, 1.0]))
    assert (ends["torque_least"].value, ends["torque_most"].value) == (1.5, 5.0)


def test_a_model_takes_a_balancer_that_is_told_so():
    model = two_joints.model()
    arm = Arm(model, model.nominal_values, model.robot.drive_gain, Transmission.rigid(model.robot.dof))
    fitted = replace(found(), term=next(balancers(model)).instance)
    stated = in_units_of_joints(fitted, model.robot)
    assert "Kr" not in stated.parameters
    for each in (fitted, stated):
        values = with_finding(arm, each).by_name
        assert (values["Kr"], values["K0"]) == pytest.approx((KR * 0.7**2, K0 * 0.7))
