"""Answers of a gap: effects are attached for findings, or for what the robot file states."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from exidyn.identification.effects import Prior, StribeckFriction
from exidyn.identification.in_mujoco.answer import Answer, attached
from exidyn.identification.in_mujoco.distances import Gain
from exidyn.identification.in_mujoco.ladder import Step
from tests.parts.servo_arms import described

pytest.importorskip("mujoco")


def with_stribeck():
    """An arm whose robot file states what MJCF cannot hold."""
    model = described()
    effects = (*model.effects, StribeckFriction(joints=("elbow",)))
    return replace(model, effects=effects, stated=dict(model.stated) | {"Fs2": Prior(1.0)})


@pytest.mark.parametrize(
    ("arm", "findings", "gain", "attaches"),
    [
        (described, [], Gain.BETTER, False),  # dry friction by another law
        (described, ["a finding"], Gain.SAME, True),
        (described, ["a finding"], Gain.WORSE, False),
        (with_stribeck, [], Gain.BETTER, True),
        (with_stribeck, [], Gain.SAME, False),
    ],
)
def test_effects_are_attached_for_findings_or_for_what_the_robot_file_states(arm, findings, gain, attaches):
    file = Answer(b"the file", None, (), described())
    ladder = SimpleNamespace(
        judge=SimpleNamespace(compared=lambda first, second: gain),
        best=Step("a fit", arm(), b"a step", (), ()), last=None, findings=findings,
    )  # fmt: skip
    answer = attached(ladder, file)
    assert answer.attaches == attaches
    assert answer.text == (b"a step" if attaches else b"the file")
