"""Rivals count together; a family is named where its member is not known; a formula is wrong by a tenth."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

from exidyn.identification.diagnosis.candidates import KINDS, family_of, kinds
from exidyn.identification.diagnosis.candidates.friction import GRADUAL
from exidyn.identification.diagnosis.findings.family import FAMILIES
from exidyn.identification.diagnosis.questions.block_answer import CERTAIN_ODDS
from exidyn.identification.diagnosis.search import selected
from exidyn.identification.diagnosis.search.selected import most_probable, odds_of
from exidyn.identification.effects import StribeckFriction
from exidyn.identification.effects.effect import JointEffect
from exidyn.identification.effects.smooth_sign import smooth_sign

from ...parts.small.small_search import record, searched


def answer(effect, odds, joint=0, kind="", **shape):
    candidate = SimpleNamespace(
        effect=effect, joints=(joint,), prior=1.0, everywhere=False, kind=kind, shape=shape
    )
    candidate.same_torque = None
    by_joint, columns = np.array([odds + 3.0, 0.0]), SimpleNamespace(joints=[0])
    return SimpleNamespace(
        candidate=candidate, columns=columns, gain=odds + 1.0, odds=odds, by_joint=by_joint, relief=0.0
    )


@pytest.fixture
def plain(monkeypatch):
    """Answers compete by their odds alone."""
    monkeypatch.setattr(selected, "competing", lambda one, other: True)
    monkeypatch.setattr(selected, "better", lambda one, other, blocks, prior: one.odds - other.odds + prior)


def asked(*answers):
    return most_probable(answers, 1.0, lambda one, other: 0.0)


DRAG, DRY = {"exponent": 0.5}, {"reversal": 0.1}


def test_rivals_of_one_joint_count_together_and_a_family_is_named(plain):
    rivals = [
        answer("nonlinear_viscous_friction", 1.8, **DRAG),
        answer("coulomb_friction", 1.4, kind=GRADUAL, **DRY),
        answer("hysteresis", 1.3),
        answer("joint_spring", 0.2),
    ]
    assert all(odds_of(one, 1.0) < CERTAIN_ODDS for one in rivals)
    found = asked(*rivals)
    assert found.answer is rivals[0]
    assert len(found.others) == 3
    assert found.odds + found.together == pytest.approx(np.log(np.exp([1.8, 1.4, 1.3, 0.2]).sum()))
    assert not found.named
    assert found.family[0] == ""
    assert asked(answer("hysteresis", 2.0), answer("hysteresis", 2.0, joint=1)) is None
    found = asked(
        answer("nonlinear_viscous_friction", 3.5, **DRAG),
        answer("coulomb_friction", 3.4, kind=GRADUAL, **DRY),
    )
    assert not found.named
    family, probability = found.family
    assert family == "sublinear"
    assert probability > 0.95
    found = asked(answer("nonlinear_viscous_friction", 3.5, **DRAG), answer("stribeck_friction", 3.4))
    assert found.family[0] == "velocity"


def test_every_family_is_in_the_table():
    for name in kinds():
        family = KINDS[name].family if name in KINDS else ""
        assert callable(family) or not family or family in FAMILIES
    drags = [answer("nonlinear_viscous_friction", 1.0, exponent=power).candidate for power in (0.5, 2.0)]
    assert [family_of(drag) for drag in drags] == ["sublinear", "superlinear"]


@dataclass(frozen=True)
class Lorentzian(JointEffect):
    """Friction that rises towards standstill, by another formula than the vocabulary's."""

    massless: ClassVar[bool] = True

    def parameters(self, robot):
        return self.on_each(robot, ("Fl", "N m", 0.0))

    def regressor(self, robot, motion):
        speed = motion.velocity / 0.1
        return self.on_joints(robot, smooth_sign(motion.velocity, 0.003) / (1.0 + speed**2))


@pytest.mark.slow
@pytest.mark.long
def test_the_mismatch_of_a_formula_has_no_second_name():
    found = searched(record([Lorentzian(("elbow",))], {"Fl2": 1.0}))
    [one] = [one for one in found.selected if one.answer.candidate.joints == (1,)]
    assert FAMILIES[family_of(one.answer.candidate)].dependence == "velocity"
    assert one.family[0]


@pytest.mark.slow
def test_a_formula_that_is_right_is_named_and_no_curve():
    found = searched(record([StribeckFriction(("elbow",), fade=0.1)], {"Fs2": 1.0}))
    assert [one.answer.candidate.effect for one in found.selected] == ["stribeck_friction"]
    assert found.selected[0].named
