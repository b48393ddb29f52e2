"""Shapes of findings in the file of a choice."""

import json

from exidyn.acquire.study.choice_file import read_shapes, shape_table
from exidyn.identification.diagnosis.questions.shape import Shaped


def test_shapes_are_read_as_they_were_written_and_of_one_hypothesis_the_last_stays():
    before = [
        Shaped("joint_elasticity", (0,), "", {"resonance": 5.4, "damping_ratio": 0.01}),
        Shaped("torque_ripple", (1,), "20 to 40", {"frequency": 30.0}),
    ]
    later = Shaped("joint_elasticity", (0,), "", {"resonance": 5.5, "damping_ratio": 0.02})
    table = json.loads(json.dumps(shape_table([*before, later])))
    assert table[0][1] == [1]
    assert read_shapes({"shapes": table}) == [later, before[1]]


def test_a_choice_made_without_shapes_has_none():
    assert read_shapes(None) == []
    assert read_shapes({"verdict": "run"}) == []
