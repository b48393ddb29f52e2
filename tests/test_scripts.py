"""Plain scripts that plan, as processes of their own: they start others, which import the script."""

import subprocess
import sys

import pytest

from exidyn.identification.robot_files.robot_file import model_text

from .parts.small import two_joints

pytestmark = pytest.mark.slow

WITHOUT_GUARD = """
import exidyn as ex
plan = ex.plan("robot.toml", search_iterations=1, seconds=7, period=3, harmonics=1)
print("planned", plan.trajectory.duration > 0)
"""
OWN_EFFECT = """
from dataclasses import replace
import exidyn as ex
from exidyn.identification.effects import ViscousFriction

class Grease(ViscousFriction):
    pass

if __name__ == "__main__":
    arm = ex.robot("robot.toml")
    effects = [Grease() if type(effect) is ViscousFriction else effect for effect in arm.effects]
    arm = replace(arm, effects=tuple(effects))
    plan = ex.plan(arm, search_iterations=1, seconds=7, period=3, harmonics=1)
    print("planned", plan.trajectory.duration > 0)
"""


@pytest.mark.parametrize("script", [WITHOUT_GUARD, OWN_EFFECT], ids=["without guard", "own effect"])
def test_a_script_plans_once(tmp_path, script):
    (tmp_path / "robot.toml").write_text(model_text(two_joints.model()))
    (tmp_path / "script.py").write_text(script)
    command = [sys.executable, "script.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("planned True\n", "")
