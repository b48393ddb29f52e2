"""What `exidyn record` refuses, before anything is rehearsed, asked or written."""

import json
import re
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exidyn.acquire.arguments.parser import STOPPED, UNSAFE
from exidyn.acquire.arguments.run_options import check_duration
from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.commands.record_command import _clearances
from exidyn.acquire.run.errors import NotAllowed
from exidyn.acquire.terminal.run_summary import UNATTENDED
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.robot_files.robot_file import model_text, read_model, urdf_text
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import parse_plan, write_plan

from ...parts.plans.plans import known_plan
from ...parts.runs.run_parts import MODEL, motion
from ...parts.small import two_joints

pytestmark = pytest.mark.clocked


@pytest.fixture
def arguments(tmp_path, monkeypatch):
    """Trajectory and robot on the command line, in a folder of their own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv(UNATTENDED, raising=False)
    (tmp_path / "robot.toml").write_text(model_text(MODEL))
    write_plan(Plan.of(motion(), MODEL, tick=0.002), tmp_path / "trajectory.toml")
    return ["record", "trajectory.toml", "--robot", "robot.toml"]


SERVOS = ["--driver", "feetech", "--set", "port=/dev/nowhere", "--set", "ids=[1, 2, 3, 4, 5, 6]"]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--output", "robot.toml"], "robot.toml exists, and recordings are not overwritten"),
        (["--output", "there/run.mcap"], "there is no folder there"),
        (["--output", "run.txt"], "recordings end in .mcap. Use run.mcap"),
        (["--save", "there/run.rrd"], "there is no folder"),
        (["--serve", "nowhere"], "--serve nowhere"),
        ([*SERVOS, "--yes"], f"only if {UNATTENDED}=yes"),
        ([*SERVOS, "--plant", "kr270"], "feetech moves a real arm"),
        (["--current", "1", "2"], "--current has 2 values"),
        (["--tracking", "3600"], "with more than 59 degrees no stop of joint1 could act in time"),
        (["--com", "0", "0", "1"], "com given without --mass"),
        (["--speed", "0.01"], "confirm a run of more than 1 h with --long"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line_before_anything_else(arguments, more, words, capsys, tmp_path):
    assert main([*arguments, *more]) == REFUSED
    printed = capsys.readouterr()
    assert words in printed.err
    assert len(printed.err.splitlines()) == 1
    assert not list(tmp_path.glob("*.mcap*"))


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [("--speed", value, value) for value in ("fast", "0", "120", "nan")]
    + [("--temperature", value, "no winding withstands more than 180") for value in ("1e9", "180.1")]
    + [("--temperature", "inf", "--temperature")],
)
def test_a_speed_or_temperature_that_cannot_be_is_reported_in_a_line(arguments, option, value, words, capsys):
    with pytest.raises(SystemExit) as ended:
        main([*arguments, option, value])
    assert ended.value.code == REFUSED
    [line] = capsys.readouterr().err.splitlines()
    assert words in line


@pytest.mark.parametrize(
    ("planned", "speed", "long", "stated"),
    [(20.0, 1.0, False, ""), (20.0, 0.1, False, "200 s (3 min 20 s) at 10 %"), (400.0, 0.1, True, "4000 s")],
)
def test_the_length_of_a_run_is_stated_before_it_is_checked(planned, speed, long, stated, capsys):
    check_duration(planned, speed, long)
    printed = capsys.readouterr().err
    assert stated in printed
    assert len(printed.splitlines()) == bool(stated)


@pytest.mark.parametrize("speed", [1.0, 0.1])
def test_a_run_of_more_than_an_hour_has_to_be_meant(speed):
    check_duration(3600.0 * speed, speed, False)
    with pytest.raises(NotAllowed, match=r"takes 3601 s \(60 min 1 s\)"):
        check_duration(3601.0 * speed, speed, False)


def test_a_run_prints_where_it_is_how_long_it_takes_and_what_to_do_with_it(arguments, capsys, tmp_path):
    path = Path(arguments[1])
    planned = parse_plan(path.read_text())
    for followed_by, details in (
        ("exidyn identify run.mcap", {}),
        ("exidyn payload run.mcap --fit FIT", {"payload": "any up to 4 kg"}),
    ):
        write_plan(replace(planned, details=planned.details | details), path)
        assert main([*arguments, "--output", "run.mcap"]) == 0
        printed = capsys.readouterr()
        assert f"written: run.mcap\nnext: {followed_by}\n" in printed.err
        assert "0 in which a joint was silent" in printed.out
        takes = re.search(r"takes: +(\d+) s, a recording of about ([\d.]+) MB", printed.err)
        assert float(takes[1]) == round(motion().duration)
        assert 1e6 * float(takes[2]) == pytest.approx(Path("run.mcap").stat().st_size, rel=0.25)
        assert read_recording("run.mcap").outcome["stop"] == "none"
        Path("run.mcap").unlink()


def test_the_simulated_arm_is_not_the_one_in_the_robot_file(arguments, tmp_path):
    runs = []
    for more in ([], ["--plant", "robot.toml"]):
        assert main([*arguments, *more, "-o", "run.mcap"]) == 0
        runs.append(read_recording("run.mcap").signals["current"].values)
        (tmp_path / "run.mcap").unlink()
    usual, nominal = (np.sqrt(np.mean(run**2, axis=0)) for run in runs)
    assert np.all(np.abs(usual / nominal - 1) > 1e-3)


def test_a_slower_run_has_the_motion_as_planned_inside_and_the_speed_beside_it(arguments, tmp_path):
    assert main([*arguments, "--speed", "80"]) == 0
    run = read_recording("run.mcap")
    assert run.trajectory == (tmp_path / "trajectory.toml").read_text(encoding="utf-8")
    assert run.settings["speed"] == "0.8"
    assert run.duration > motion().duration / 0.8


def test_one_that_is_stopped_fails_and_prints_where_to_look(arguments, capsys):
    assert main([*arguments, "--current", "0.001"]) == 1
    printed = capsys.readouterr()
    assert "STOPPED (brake)" in printed.out
    assert "limit 0.001" in printed.out
    assert "exidyn info run.mcap" in printed.err
    assert main(["info", "run.mcap"]) == 0
    assert "ended: STOPPED (brake): " in capsys.readouterr().out


RUNS_AWAY = ["--set", "faults=runaway joint2 2 at 0.5; deaf at start; stop fails 3 at start"]


def test_an_arm_that_cannot_be_stopped_is_told_of_whatever_the_tolerance(arguments, capsys):
    assert main([*arguments, *RUNS_AWAY, "--tracking", "50", "--json", "run.json"]) == UNSAFE
    printed = capsys.readouterr()
    assert "joint2 STILL MOVES at 2 rad/s after torque off was requested" in printed.out
    assert printed.err.splitlines()[-1].endswith("PRESS THE EMERGENCY STOP")
    outcome = read_recording("run.mcap").outcome
    assert outcome["moving"] == "True"
    table = json.loads(Path("run.json").read_text())
    assert table["moving"] is True
    assert table["joint"] == "joint2"


def test_position_limits_hold_at_every_tolerance(arguments, capsys):
    """Within the tolerance, and beyond the limits: the limits have a tolerance of their own."""
    model = replace(MODEL.robot.limits, position_upper=MODEL.robot.limits.position_upper.copy())
    model.position_upper[1] = motion().state_at(motion().duration).position[1] + 0.02
    narrow = replace(MODEL, robot=replace(MODEL.robot, limits=model))
    Path("robot.toml").write_text(model_text(narrow))
    write_plan(Plan.of(motion(), narrow, tick=0.002), Path("trajectory.toml"))
    code = main([*arguments, "--set", "faults=runaway joint2 0.5 at 0.1", "--tracking", "40"])
    assert code == STOPPED
    assert "position beyond its limits by" in capsys.readouterr().out


NOBODY = ["--driver", "ur_rtde", "--set", "address=127.0.0.1", "--set", "rtde_port=1"]


def test_a_controller_that_is_not_there_is_reported_before_a_rehearsal(arguments, capsys, monkeypatch):
    monkeypatch.setenv(UNATTENDED, "yes")
    assert main([*arguments, *NOBODY, "--yes"]) == REFUSED
    printed = capsys.readouterr().err
    assert "no connection to 127.0.0.1:1" in printed
    assert "rehears" not in printed


@pytest.mark.parametrize("edited", [False, True])
def test_collisions_of_an_edited_motion_are_looked_at_again(edited, tmp_path):
    robot = tmp_path / "bodies.urdf"
    robot.write_text(urdf_text(two_joints.model()).replace("visual>", "collision>"))
    given = Namespace(robot=str(robot), cell=None, approach=False, no_collision=False)
    assert bool(_clearances(given, replace(known_plan(), edited=edited), read_model(robot))) == edited


def test_a_recording_of_an_edited_motion_does_not_make_it_pass_for_a_planned_one(arguments, tmp_path):
    planned = Plan.of(motion(), MODEL, tick=0.002)
    raised = replace(planned.limits, velocity=50.0 * planned.limits.velocity)
    write_plan(replace(planned, limits=raised, edited=True), tmp_path / "trajectory.toml")
    assert main(arguments) == 0
    inside = parse_plan(read_recording(tmp_path / "run.mcap").trajectory)
    assert inside.edited
    assert np.array_equal(inside.limits.velocity, MODEL.robot.limits.velocity)
