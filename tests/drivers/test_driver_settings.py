import importlib.util
import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass

import numpy as np
import pytest

from exidyn.drivers import DRIVERS, Arm, MissingPackage, create, driver_class, explain
from exidyn.drivers.errors import BadSettings, UnknownDriver
from exidyn.drivers.settings import read_settings, setting, template


@dataclass(frozen=True)
class Settings:
    port: str = setting(..., "serial port")
    cycle: float = setting(0.002, "time between exchanges", unit="s", low=0.001, high=1.0)
    sign: tuple[int, ...] = setting(1, "direction", choices=(1, -1))
    fast: bool = setting(False, "in a hurry")


def read(**table):
    return read_settings(Settings, {"port": "x", **table}, 3, "driver test")


def test_one_value_is_taken_for_all_joints():
    assert read(sign=-1).sign == (-1, -1, -1)
    assert read(sign=[1, -1, 1]).sign == (1, -1, 1)
    assert read().cycle == 0.002


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"speed": 3}, "unknown setting 'speed'. Valid: port, cycle, sign, fast"),
        ({"cycle": 0.0}, "cycle is 0 s; valid are 0.001 to 1"),
        ({"cycle": "fast"}, "cycle is 'fast'; expected a number"),
        ({"cycle": True}, "cycle is True; expected a number"),
        ({"fast": 1}, "fast is 1; expected true or false"),
        ({"sign": [1, 1]}, "sign has 2 entries, the arm 3 joints"),
        ({"sign": 2}, "sign[0] is 2. Valid: 1, -1"),
        ({"port": 3}, "port is 3; expected a text"),
        ({"cycle": float("nan")}, "cycle is nan s; valid are 0.001 to 1"),
        ({"cycle": 10**400}, "expected a number: time between exchanges"),
        ({"sign": [1, True, 1]}, "sign[1] is True; expected a whole number"),
    ],
)
def test_what_cannot_be_is_named(table, words):
    with pytest.raises(BadSettings, match=re.escape(words)):
        read(**table)


def test_what_is_missing_is_named():
    with pytest.raises(BadSettings, match=r"missing port \(serial port\)"):
        read_settings(Settings, {}, 3, "driver test")


def test_the_template_is_valid_once_the_required_is_filled_in():
    text = template(Settings).replace("# port =", 'port = "x"')
    assert read_settings(Settings, tomllib.loads(text), 3, "driver test") == read()


def test_an_unknown_driver_lists_the_valid_ones():
    with pytest.raises(UnknownDriver, match="mock, kuka_rsi, ur_rtde, franka"):
        driver_class("kuka")


@pytest.mark.parametrize("name", DRIVERS)
def test_every_driver_explains_its_settings(name):
    table = tomllib.loads(explain(name))
    assert table["driver"] == name
    assert all(
        about.text
        for about in (f.metadata["about"] for f in driver_class(name).Settings.__dataclass_fields__.values())
    )


@pytest.mark.parametrize(
    ("name", "package", "extra"), [("can_mit", "can", "can"), ("feetech", "serial", "serial")]
)
def test_a_driver_whose_package_is_missing_names_the_extra(name, package, extra):
    """In a process of its own, in which the package cannot be imported."""
    code = (
        f"import sys; sys.modules[{package!r}] = None\n"
        "from exidyn.drivers import MissingPackage, driver_class\n"
        f"try: driver_class({name!r})\n"
        "except MissingPackage as error: print(error)"
    )
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert f"driver {name} needs the package {package}" in output
    assert f'pip install ".[{extra}]"' in output


def test_a_library_of_a_maker_that_is_missing_is_named_when_a_robot_is_opened(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert "address" in explain("franka")
    arm = Arm(tuple("abcdefg"), *(np.zeros(7),) * 3)
    with create("franka", {"address": "127.0.0.1"}, arm) as driver:
        with pytest.raises(MissingPackage, match=r'pylibfranka.*pip install "\.\[franka\]"') as caught:
            driver.open()
    assert "\n" not in str(caught.value)
