import numpy as np
import pytest

from exidyn.acquire.arguments.controllers import read_controller
from exidyn.drivers.errors import BadSettings

pytestmark = pytest.mark.clocked


def write(tmp_path, text):
    path = tmp_path / "cell.toml"
    path.write_text(text)
    return path


def test_settings_of_the_command_line_come_before_those_of_the_file(tmp_path):
    path = write(tmp_path, 'driver = "can_mit"\n[settings]\nchannel = "can0"\ncycle = 0.002\n')
    name, settings = read_controller(path, None, ["cycle=0.004", "ids=[1, 2]", "note=a text"])
    assert name == "can_mit"
    assert settings == {"channel": "can0", "cycle": 0.004, "ids": [1, 2], "note": "a text"}


def test_without_anything_it_is_the_mock():
    assert read_controller(None, None, []) == ("mock", {})


@pytest.mark.parametrize(
    ("text", "name", "assignments", "words"),
    [
        ('driver = "can_mit"', "mock", [], "cell.toml is for can_mit"),
        ("driver = ", None, [], "not a controller file"),
        ("rate = 3", None, [], "unknown key 'rate'. Valid: driver, settings"),
        ("driver = 3", None, [], "driver is 3; expected a text"),
        ("settings = 3", None, [], "settings is 3; expected a table"),
        ("", None, ["cycle"], "expected NAME=VALUE"),
    ],
)
def test_what_cannot_be_is_named(tmp_path, text, name, assignments, words):
    with pytest.raises(BadSettings) as caught:
        read_controller(write(tmp_path, text), name, assignments)
    assert words in str(caught.value)


def test_values_are_numbers_where_they_look_like_them():
    _, settings = read_controller(None, None, ["sign=-1", "cycle=4e-3", "fast=true"])
    assert settings == {"sign": -1, "cycle": pytest.approx(0.004), "fast": True}
    assert isinstance(settings["sign"], int)
    assert np.isclose(settings["cycle"], 0.004)
