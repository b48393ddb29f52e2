import re

import pytest

from exidyn.acquire.arguments.run_options import read_controller
from exidyn.drivers.errors import BadSettings

pytestmark = pytest.mark.clocked


def test_settings_of_the_command_line_come_before_those_of_the_file(tmp_path):
    path = tmp_path / "cell.toml"
    path.write_text('driver = "can_mit"\n[settings]\nchannel = "can0"\ncycle = 0.002\n')
    name, settings = read_controller(
        path, None, ["cycle=4e-3", "ids=[1, 2]", "note=a text", "sign=-1", "fast=true"]
    )
    assert name == "can_mit"
    assert settings == {
        "channel": "can0",
        "cycle": 0.004,
        "ids": [1, 2],
        "note": "a text",
        "sign": -1,
        "fast": True,
    }
    assert isinstance(settings["sign"], int)
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
    (tmp_path / "cell.toml").write_text(text)
    with pytest.raises(BadSettings, match=re.escape(words)):
        read_controller(tmp_path / "cell.toml", name, assignments)
