"""Plain scripts that use the library, as processes of their own."""

import subprocess
import sys

import pytest

pytestmark = pytest.mark.slow

WITHOUT_GUARD = """
import exidyn as ex
print("planned", ex.plan("cobot", search_seconds=1, seconds=8).trajectory.duration > 0)
"""
OWN_EFFECT = """
from dataclasses import replace
import exidyn as ex
from exidyn.identification.effects import ViscousFriction

class Grease(ViscousFriction):
    pass

if __name__ == "__main__":
    arm = ex.robot("cobot")
    effects = [Grease() if type(effect) is ViscousFriction else effect for effect in arm.effects]
    arm = replace(arm, effects=tuple(effects))
    print("planned", ex.plan(arm, search_seconds=1, seconds=8).trajectory.duration > 0)
"""


@pytest.mark.parametrize("script", [WITHOUT_GUARD, OWN_EFFECT])
def test_a_script_plans_once(tmp_path, script):
    (tmp_path / "script.py").write_text(script)
    command = [sys.executable, "script.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("planned True\n", "")
