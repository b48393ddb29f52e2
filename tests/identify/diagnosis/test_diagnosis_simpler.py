"""An effect that is a part of another wins, unless the rest of the other is needed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.identification.diagnosis.search.simpler import contains
from exidyn.identification.effects import Prior

from ...parts.small import two_joints
from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import names, record, searched

POSITION = np.linspace(-1.0, 1.0, 200)


def answer(*columns, joint=1):
    values = np.stack(columns, axis=1)[:, None, :]
    thinned = SimpleNamespace(joints=np.array([joint]), values=values)
    return SimpleNamespace(columns=thinned, values=np.ones(len(columns)))


def test_an_offset_is_a_part_of_a_spring_on_the_same_joint_and_no_more():
    spring, offset = answer(POSITION, np.ones(200)), answer(np.full(200, 2.0))
    assert contains(spring, offset)
    assert not contains(offset, spring)
    assert not contains(spring, answer(np.full(200, 2.0), joint=0))
    assert not contains(spring, answer(POSITION**3))


@pytest.mark.parametrize(("stiffness", "effect"), [(0.0, "current_offset"), (8.0, "joint_spring")])
def test_an_offset_beyond_its_tolerance_is_no_spring_and_a_spring_no_offset(stiffness, effect):
    model = nominal_model()
    stated = {**model.stated, "Off2": Prior(-0.5, 0.05)}
    model = replace(model, stated=stated)

    def pulled(role, motion, current):
        # A little that depends on position, as the model misses everywhere: a spring would take it up.
        more = 2.0 + (stiffness + 0.1) * motion.position[:, 1]
        return current + np.outer(more, [0.0, 1.0]) / two_joints.GAIN

    found = searched(record(change=pulled, model=nominal_model()), model)
    assert (effect, (1,)) in names(found)
    assert not {"current_offset", "joint_spring"} - {effect} & {name for name, _ in names(found)}
