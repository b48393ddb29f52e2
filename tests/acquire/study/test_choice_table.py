"""Shapes of findings in the file of a choice."""

import json

from exidyn.acquire.study.choice_file import RoundChoice, shape_rows, shapes_in
from exidyn.identification.diagnosis.questions.shape import Shaped
from exidyn.identification.schema import checked

from ...parts.small.small_choice import choice


def test_shapes_are_read_as_they_were_written_and_of_one_hypothesis_the_last_stays():
    before = [
        Shaped("joint_elasticity", (0,), "", {"resonance": 5.4, "damping_ratio": 0.01}),
        Shaped("torque_ripple", (1,), "20 to 40", {"frequency": 30.0}),
    ]
    later = Shaped("joint_elasticity", (0,), "", {"resonance": 5.5, "damping_ratio": 0.02})
    table = json.loads(json.dumps(shape_rows([*before, later])))
    assert table[0][1] == [1]
    assert shapes_in(checked(choice("run") | {"shapes": table}, RoundChoice, "")) == [later, before[1]]


def test_a_choice_made_without_shapes_has_none():
    assert shapes_in(None) == []
    table = {name: value for name, value in choice("run").items() if name != "shapes"}
    assert shapes_in(checked(table, RoundChoice, "")) == []
