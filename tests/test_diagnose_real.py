"""Diagnosis of real arms with something taken out of the belief, and the scores of that benchmark."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

from diagnose_real_answer import Answer, Named, Question, ask
from diagnose_real_arms import ARMS, HEAVY, Asked, parts
from diagnose_real_belief import NAMES, believe, without
from diagnose_real_tables import new_names, taken_table

DATA = Path(os.environ.get("EXIDYN_DATA", Path(__file__).parents[1] / "../shared/data"))
needs_recordings = pytest.mark.skipif(
    not (DATA / "ur10e_mamedov").is_dir(), reason=f"no real recordings in {DATA}; set EXIDYN_DATA"
)


def named(effect, joint, value, unit):
    return Named(effect, (joint,), 0.99, value, 0.1, unit, ())


def answer(findings, effect="coulomb_friction", joint=2):
    residual = np.array([1.0, 1.0, 5.0])
    question = Question("arm", Asked((), ()), effect, joint)
    return Answer(question, tuple(findings), (), residual, residual / 5.0, 3.0, 1.0)


def test_parts_of_one_friction_are_one_whole():
    bent = answer([named("coulomb_friction", 2, 1.0, "N m"), named("hysteresis", 2, 2.0, "N m")])
    assert (bent.said, bent.value, bent.others()) == ("named", 3.0, [])
    alone = answer([named("hysteresis", 2, 2.0, "N m")])
    assert (alone.said, alone.value) == ("as hysteresis", 2.0)
    elsewhere = answer([named("hysteresis", 1, 2.0, "N m")])
    assert elsewhere.said == "missed"
    assert np.isnan(elsewhere.value)


def test_what_is_there_with_nothing_taken_out_is_not_new():
    usual, strange = named("load_dependent_friction", 1, 0.1, "1"), named("backlash", 0, 1.0, "1")
    said = answer([usual, strange])
    nothing = answer([usual], effect="", joint=-1)
    assert new_names(said, [nothing]) == [strange]
    assert new_names(said, []) is None
    scores = taken_table([said], [nothing])["taken_out"]["arm coulomb_friction"]
    assert (scores["missed"], scores["new_names"]) == (1, 1)


@needs_recordings
def test_no_run_that_is_diagnosed_made_the_belief():
    for arm in ARMS.values():
        hidden = [body.asked for body in arm.bodies]
        for asked in (*arm.asked, *hidden):
            assert not set(arm.believed) & {*asked.fitted, *asked.held_out}
            assert not set(asked.fitted) & set(asked.held_out)
        for body in (body for body in arm.bodies if body.known):
            assert body.known[0] not in " ".join((*body.asked.fitted, *body.asked.held_out))


@needs_recordings
def test_a_term_taken_out_is_gone_and_the_others_stay():
    model = believe(ARMS["panda"], None)
    left = without(model, "coulomb_friction", 3)
    gone = set(model.names) - set(left.names)
    assert gone == {f"{NAMES['coulomb_friction']}4"}
    assert without(model, "", -1) is model


@needs_recordings
def test_a_payload_that_nobody_told_of(monkeypatch):
    monkeypatch.setattr("exidyn.identify.diagnosis.search.MOST", 1)  # the friction of its gears takes longer
    arm = ARMS["ur10e"]
    [body] = [body for body in arm.bodies if body.asked.fitted == (HEAVY,)]
    asked = Asked(parts(HEAVY, 1), parts(HEAVY, 2))
    said = ask(Question("ur10e", asked, "payload", -1, body.known, body.mass))
    assert said.findings[0].effect == "payload"
    # 18 s of one run: the body's mass is told to some per cent
    assert abs(said.value / body.mass - 1) < 0.1
    # a gear that carries more rubs more, which is not looked for here; the wrist's carry little
    assert np.all(said.after[3:] < 0.3 * said.before[3:])
