"""A robot.toml that explains itself, and is the same robot."""

import pytest

from exidyn.identification.robot_files.commented import commented_text
from exidyn.identification.robot_files.robot_file import model_text, parse_model, read_model


@pytest.mark.parametrize("name", ["cobot", "kr270"])
def test_each_key_has_a_comment_above(name):
    seen, before = set(), ""
    for line in commented_text(read_model(name)).splitlines():
        key = line.partition(" = ")[0]
        if line.startswith("["):
            seen = seen if line == "[[link]]" else set()
        elif line and not line.startswith("#") and key not in seen:
            assert before.startswith("# "), line
            seen.add(key)
        before = line


@pytest.mark.parametrize("name", ["cobot", "kr270"])
def test_it_reads_back_as_the_same_robot(name):
    model = read_model(name)
    assert model_text(parse_model(commented_text(model))) == model_text(model)


def test_values_are_named_with_their_units():
    text = commented_text(read_model("kr270"))
    assert "# Nominal values of Kr [N/m]; K0 [N]" in text
    assert "# Distance of the fixed end from the joint's axis [m]" in text
    assert "# Nominal values of Fc1, Fc2, Fc3, Fc4, Fc5, Fc6 [N m]" in text
