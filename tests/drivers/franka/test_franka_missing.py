"""Driver franka where Franka's library is not installed: its settings can be had, a robot cannot."""

import importlib.util

import numpy as np
import pytest

from exidyn.drivers import Arm, MissingPackage, create, explain


def test_a_missing_library_is_named_with_the_command_that_brings_it(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert "address" in explain("franka")
    arm = Arm(tuple("abcdefg"), *(np.zeros(7),) * 3)
    with create("franka", {"address": "127.0.0.1"}, arm) as driver:
        with pytest.raises(MissingPackage, match=r'pylibfranka.*pip install "\.\[franka\]"') as found:
            driver.open()
    assert "\n" not in str(found.value)
