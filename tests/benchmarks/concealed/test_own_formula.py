"""Arms by exidyn's own formulas, whose diagnosed numbers are held against the truth."""

import numpy as np
import pytest
from parts.concealed import own_formula
from parts.concealed.own_formula import DRAWS, JOINTS, diagnosed_numbers, nominal

from exidyn.identification.diagnosis.findings.diagnosis import Diagnosis
from exidyn.identification.diagnosis.findings.finding import Finding
from exidyn.identification.quantity import Quantity

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("effect", DRAWS)
def test_every_drawn_number_is_one_of_the_effect(effect):
    drawn = DRAWS[effect](JOINTS[1], 2, 6.0, np.random.default_rng(1))
    names = [parameter.name for parameter in drawn.effect.parameters(nominal().robot)]
    assert sorted(drawn.values) == sorted(names)
    assert set(drawn.shape) <= set(drawn.effect.shapes())


@pytest.mark.parametrize(("named", "count"), [("load_dependent_friction", 1), ("hysteresis", 0)])
def test_numbers_of_the_right_finding_count_and_no_others(monkeypatch, named, count):
    """The arm of seed 0 has friction by load; the diagnosis is made up."""
    joints = (int(np.random.default_rng(0).integers(2)),)
    numbers = {f"mu{joints[0] + 1}": Quantity(0.1, 0.01, "1"), "preload": Quantity(1.0, 0.5, "N m")}
    finding = Finding(
        effect=named, joints=joints, parameters=numbers, probability=1.0, torque_rms=np.zeros(2), held_out=0.0
    )
    made = Diagnosis(
        name="small",
        joints=JOINTS,
        torque_units=("N m",) * 2,
        findings=(finding,),
        noise=np.ones(2),
        runs=("run",),
    )
    monkeypatch.setattr(own_formula, "diagnose", lambda *given, **options: made)
    found = diagnosed_numbers(0)
    assert [(one.effect, one.name, one.value) for one in found] == [("load_dependent_friction", "mu", 0.1)][
        :count
    ]
