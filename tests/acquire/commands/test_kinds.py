"""The kinds of run beside the optimised one, as the command line asks for them."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.effects import JointSpring, Prior
from exidyn.identification.robot_files.robot_file import model_text
from exidyn.trajectories.clearances.region import Region, box
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.planning.by_rule import KINDS
from exidyn.trajectories.plans.plan_file import read_plan

from ...parts.plans.excitation import limits
from ...parts.plans.small_search import make_small
from ...parts.small import two_joints

pytestmark = pytest.mark.slow

TICK = 0.004
REGION = '[[region]]\npoint = "flange"\nlower = [-9.0, -9.0, -0.6]\nupper = [9.0, 9.0, 9.0]\n'
FLOOR = Region.of(two_joints.arm(), "flange", box([-9.0, -9.0, -0.6], [9.0, 9.0, 9.0]))


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "robot.toml").write_text(model_text(two_joints.model()))
    (tmp_path / "cell.toml").write_text(REGION)
    return tmp_path


def excite(folder, *arguments):
    paths = [str(folder / "robot.toml"), "-o", str(folder / "trajectory.toml"), "--tick", str(TICK)]
    return main(["excite", *paths, *arguments])


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_keeps_to_limits_and_region(robot, capsys, kind):
    period = ["--period", "3", "--harmonics", "1"]  # of the calm motion under a chirp
    assert excite(robot, "--kind", kind, "--cell", str(robot / "cell.toml"), *period) == 0
    assert "BEYOND" not in capsys.readouterr().out
    plan = read_plan(robot / "trajectory.toml")
    assert plan.details["kind"] == kind
    assert not check(plan.trajectory, limits(), TICK)
    assert FLOOR.worst(plan.trajectory).allowed


@pytest.mark.parametrize("kind", ["sweeps", "single-joint"])
def test_one_joint_alone_moves(robot, kind):
    assert excite(robot, "--kind", kind, "--joints", "elbow") == 0
    reached = read_plan(robot / "trajectory.toml").trajectory.extremes().position
    np.testing.assert_array_equal(reached.upper - reached.lower > 0.1, [False, True])


def test_what_cannot_be_is_reported_by_the_joints_name(robot, capsys):
    assert excite(robot, "--kind", "single-joint", "--joints", "elbow", "--start", "0", "2.44") == REFUSED
    assert "exidyn: elbow: at 2.44 rad its excursion is at most" in capsys.readouterr().err


def test_a_run_against_another_model_states_how_well_it_distinguishes(robot, capsys, monkeypatch):
    make_small(monkeypatch)
    springy = two_joints.model(JointSpring(("elbow",)))
    springy = replace(springy, stated={**springy.stated, "Ks2": Prior(20.0)})
    (robot / "springy.toml").write_text(model_text(springy))
    small = ["--period", "3", "--harmonics", "1", "--length", "7"]
    assert excite(robot, "--against", str(robot / "springy.toml"), *small) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "robot.toml or " in printed
    assert "the probability of choosing right is 50 % before the run" in printed
    plan = read_plan(robot / "trajectory.toml")
    assert plan.criterion == "discriminate"
    assert 0.5 < plan.reached <= 1.0
    assert plan.details["goal"] == f"probability of choosing right {100 * plan.reached:.3g} %"
    assert not check(plan.trajectory, limits(), TICK)


def test_a_model_whose_own_effect_has_no_values_explains_nothing(robot, capsys):
    springy = two_joints.model(JointSpring(("elbow",)))
    (robot / "springy.toml").write_text(model_text(springy))
    assert excite(robot, "--against", str(robot / "springy.toml")) == REFUSED
    assert "Ks2, Ts2 have no values" in capsys.readouterr().err


def test_a_file_that_cannot_be_written_is_reported_before_the_search(robot, capsys):
    assert main(["excite", str(robot / "robot.toml"), "-o", str(robot)]) == REFUSED
    assert "--output needs a file" in capsys.readouterr().err
    assert "searching" not in capsys.readouterr().err


def test_a_poor_motion_is_called_poor(robot, capsys, monkeypatch):
    make_small(monkeypatch)
    tight = ["--start", "0.1", "0.2", "--window", "0.0005", "--period", "3", "--harmonics", "1"]
    assert excite(robot, *tight, "--search", "5") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "WARNING: the best motion found is poor: condition number" in out
