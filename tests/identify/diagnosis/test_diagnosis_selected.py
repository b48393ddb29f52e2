"""What acts on the whole arm is named only if several joints show it, and explains what one joint shows."""

from types import SimpleNamespace

import numpy as np

from exidyn.identification.diagnosis.questions.block_answer import CERTAIN_ODDS
from exidyn.identification.diagnosis.search import selected
from exidyn.identification.diagnosis.search.selected import Selected, most_probable, odds_of


def answer(effect, joints, gain, by_joint):
    candidate = SimpleNamespace(effect=effect, joints=joints, prior=1.0, everywhere=False, same_torque=None)
    return SimpleNamespace(
        candidate=candidate,
        gain=gain,
        odds=gain,
        by_joint=np.array(by_joint),
        columns=SimpleNamespace(joints=list(range(len(by_joint)))),
        relief=0.0,
        held_out=1.0,
        scatter_held_out=0.0,
    )


def test_a_base_tilt_that_one_joint_alone_shows_comes_first_and_has_no_name(monkeypatch):
    monkeypatch.setattr(selected, "competing", lambda one, other: True)
    monkeypatch.setattr(selected, "better", lambda one, other, blocks, prior: one.gain - other.gain + prior)
    tilt = answer("base_tilt", (), 44.0, [43.0, 1.0])
    spring = answer("joint_spring", (0,), 40.0, [40.0, 0.0])
    assert odds_of(tilt, 2.0) < CERTAIN_ODDS
    found = most_probable([tilt, spring], 2.0, lambda one, other: 0.0)
    assert found.answer is tilt
    assert found.probability > 0.95
    assert found.alone
    assert not found.named
    [(other, odds)] = found.others
    assert other is spring
    assert odds > 3.0


def test_what_has_no_name_takes_its_share_of_a_finding_and_of_its_alternatives_alike():
    spring, hose = answer("joint_spring", (0,), 40.0, [40.0]), answer("hose_spring", (), 38.0, [38.0])
    alone = Selected(spring, 40.0, ((hose, 1.0),))
    beside = alone._replace(unnamed=3.0)
    assert beside.certainty == 0.25 * alone.certainty
    [(_, before)], [(_, after)] = alone.elsewhere, beside.elsewhere
    assert after == 0.25 * before
