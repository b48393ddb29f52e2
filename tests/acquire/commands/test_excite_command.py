"""exidyn excite: what it writes and prints, one line for each wrong wish, and Ctrl-C."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.fit.fit_file import write_fit
from exidyn.identification.robot_files.robot_file import model_text, urdf_text
from exidyn.trajectories.clearances.region import Region, box
from exidyn.trajectories.limits.check import check
from exidyn.trajectories.plans.plan_file import read_plan
from exidyn.trajectories.search.torque_bound import TorqueBound

from ...parts.plans.excitation import limits
from ...parts.plans.small_search import make_small
from ...parts.small import two_joints
from ...parts.small.small_fit import fit

pytestmark = pytest.mark.clocked(patient=True)

QUICK = "--harmonics 1 --period 3 --length 7 --tick 0.004 --search 60".split()


@pytest.fixture(autouse=True)
def small(monkeypatch):
    make_small(monkeypatch)


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "robot.toml").write_text(model_text(two_joints.model()))
    return str(tmp_path / "robot.toml")


def excite(robot, *arguments):
    """Into trajectory.toml beside the robot."""
    output = os.path.join(os.path.dirname(robot), "made", "trajectory.toml")
    return main(["excite", robot, *QUICK, "-o", output, *arguments]), output


def test_it_writes_a_plan_that_can_be_run(robot, capsys):
    code, output = excite(robot, "--seed", "7")
    assert code == 0
    plan = read_plan(output)
    assert (plan.seed, plan.tick, plan.criterion) == (7, 0.004, "condition")
    torque = TorqueBound(two_joints.model(), limits().torque).of("")
    assert not check(plan.trajectory, limits(), 0.004, torque)
    printed, text = capsys.readouterr()
    assert f"written: {output}\nnext: exidyn excite {robot} --show {output}\n" in text
    assert f"condition number {plan.reached:.4g}" in text
    assert "BEYOND" not in printed
    assert "start 1 of 1: condition number" in text


def test_a_window_in_degrees_is_kept(robot, monkeypatch):
    make_small(monkeypatch, criterion="volume")
    code, output = excite(robot, "--start", "20", "-30", "--degrees", "--window", "15")
    assert code == 0
    reached = read_plan(output).trajectory.extremes().position
    start = np.radians([20.0, -30.0])
    assert np.all(np.abs([reached.lower - start, reached.upper - start]) <= np.radians(15.0) + 1e-9)
    np.testing.assert_allclose(read_plan(output).trajectory.at(np.zeros(1)).position[0], start, atol=1e-6)


def test_a_run_after_a_fit(robot, tmp_path, capsys):
    write_fit(fit(), tmp_path / "fit.json")
    code, output = excite(robot, "--after", str(tmp_path / "fit.json"))
    assert code == 0
    assert read_plan(output).criterion == "worst"
    assert "worst relative standard deviation" in capsys.readouterr().out


def test_a_region_is_kept(robot, tmp_path, monkeypatch):
    make_small(monkeypatch, criterion="volume")
    region = '[[region]]\npoint = "flange"\nlower = [-9.0, -9.0, -0.2]\nupper = [9.0, 9.0, 9.0]\n'
    (tmp_path / "cell.toml").write_text(region)
    floor = Region.of(two_joints.arm(), "flange", box([-9.0, -9.0, -0.2], [9.0, 9.0, 9.0]))
    code, output = excite(robot, "--cell", str(tmp_path / "cell.toml"))
    assert code == 0
    assert floor.worst(read_plan(output).trajectory).allowed
    code, output = excite(robot)
    assert code == 0
    assert not floor.worst(read_plan(output).trajectory).allowed


def test_an_obstacle_in_the_robot_file_is_kept_clear_of(tmp_path, capsys, monkeypatch):
    """The motion that is searched without it runs into it, and `exidyn record` refuses that one."""
    make_small(monkeypatch, criterion="volume")
    text = urdf_text(two_joints.model()).replace("visual>", "collision>")
    (tmp_path / "bodies.urdf").write_text(text)
    crate = '[[obstacle]]\nname = "crate"\nbox = 0.3\nat = [0.5, 0.0, -0.3]\n'
    limits = "[limits]\nacceleration = 20.0\njerk = 400.0\n"
    robot, recorded = tmp_path / "robot.toml", tmp_path / "run.mcap"
    robot.write_text(f'urdf = "bodies.urdf"\n{limits}{crate}')
    record = ["--robot", str(robot), "--dry-run", "-o", str(recorded)]
    code, through = excite(str(robot), "--no-collision")
    assert code == 0
    capsys.readouterr()
    assert main(["record", through, *record]) == REFUSED
    assert "to crate by" in capsys.readouterr().err
    assert not recorded.exists()
    code, around = excite(str(robot))
    assert code == 0
    assert main(["record", around, *record]) == 0
    assert read_plan(around).details["nearest"].startswith("link")


def test_several_bodies_have_a_run_each(robot, capsys, monkeypatch):
    make_small(monkeypatch, criterion="volume")
    code, output = excite(robot, "--mass", "1", "2", "--com", "0", "0", "0.1", "--com", "0", "0.1", "0")
    assert code == 0
    assert "To be run unloaded, and with each of the bodies" in " ".join(capsys.readouterr().out.split())
    assert read_plan(output).payload_pair
    assert excite(robot, "--mass", "1", "2", "--com", "0", "0", "0.1")[0] == REFUSED
    assert "2 masses and 1 centers of mass" in capsys.readouterr().err


def test_an_obstacle_near_an_arm_without_bodies_is_refused(robot, tmp_path, capsys):
    (tmp_path / "cell.toml").write_text('[[obstacle]]\nname = "crate"\nbox = 0.3\n')
    assert excite(robot, "--cell", str(tmp_path / "cell.toml"))[0] == REFUSED
    assert "obstacle 'crate' cannot be checked: " in capsys.readouterr().err


WRONG = {
    "no time": (["--search", "-1"], "-1 s"),
    "no harmonics": (["--harmonics", "0"], "harmonics: 0; there must be at least 1"),
    "no tick": (["--tick", "0"], "tick: 0 s"),
    "period NaN": (["--period", "nan"], "period: nan s"),
    "period endless": (["--period", "inf"], "period: inf s"),
    "length": (["--length", "-2"], "length: -2 s"),
    "short": (["--length", "6"], "length: 6 s; the shortest possible is 6.2 s: one period of 3 s"),
    "seed": (["--seed", "-1"], "seed: -1"),
    "start values": (["--start", "1", "2", "3"], "--start: 3 values; give 1 or 2, one per joint"),
    "start NaN": (["--start", "nan"], "shoulder: start nan is outside"),
    "window alone": (["--window", "0.1"], "window is relative to the start pose"),
    "window NaN": (["--start", "0", "--window", "nan"], "shoulder: correction window"),
    "margin": (["--margin", "1"], "margins: velocity is 1"),
    "no fit": (["--after", "nowhere.json"], "nowhere.json"),
    "payload": (["--mass", "-3"], "payload: mass is -3.0 kg; it must be above 0"),
    "payload NaN": (["--mass", "nan"], "payload: mass is nan kg"),
    "payload endless": (["--mass", "inf"], "payload: mass is inf kg"),
    "centre NaN": (["--mass", "3", "--com", "nan", "0", "0"], "payload: com is nan, 0.0, 0.0"),
    "centre without payload": (["--com", "0", "0", "0"], "--com is the center"),
    "focus": (["--focus", "Kr"], "no base parameter called 'Kr'"),
    "cell": (["--cell", "nowhere.toml"], "nowhere.toml"),
}


@pytest.mark.parametrize(("arguments", "words"), WRONG.values(), ids=WRONG.keys())
def test_a_wrong_wish_is_one_clear_line(robot, capsys, arguments, words):
    code, output = excite(robot, *arguments)
    printed, text = capsys.readouterr()
    assert code == REFUSED
    lines = [line for line in text.splitlines() if line.startswith("exidyn: ") and "warning" not in line]
    assert len(lines) == 1
    assert words in lines[0]
    assert printed == ""
    assert not os.path.exists(output)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("--shapes rust", "stribeck"),
        ("--seed x", "'x' is not a whole number"),
        ("--kind sweeps --mass 3", "--kind sweeps and --mass cannot be used together"),
        ("--against rival.toml --shapes coulomb_friction", "--against and --shapes cannot be used together"),
        ("--kind sweeps --length 9", "--kind sweeps and --length cannot be used together"),
        ("--against rival.toml --kind poses", "--kind poses and --against cannot be used together"),
        ("--joints elbow", "--joints cannot be used with kind 'best'"),
        ("--search 9 --iterations 9", "--search and --iterations cannot be used together"),
    ],
)
def test_options_that_there_are_not_or_that_would_be_ignored_are_refused(robot, capsys, arguments, words):
    with pytest.raises(SystemExit) as ended:
        main(["excite", robot, *arguments.split()])
    assert ended.value.code == REFUSED
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("sweeps", ["make sweeps", "2 of 2 joints", "compute the torque", "check it against all limits"]),
        ("single-joint", ["make single-joint", "1 of 2 joints", "2 of 2 joints"]),
        ("poses", ["make poses", "move to pose 1 of ", "check it against all limits"]),
    ],
)
def test_each_step_of_a_run_by_rule_is_said(robot, tmp_path, capsys, kind, said):
    main(["excite", robot, "--kind", kind, "--tick", "0.004", "-o", str(tmp_path / "made.toml")])
    text = capsys.readouterr().err
    places = [text.index(one) for one in said]
    assert places == sorted(places)


def test_ctrl_c_keeps_the_best(robot, tmp_path):
    """The whole group gets the signal, as from a keyboard, a second into a search of half a minute."""
    output = tmp_path / "best.toml"
    command = [sys.executable, "-m", "exidyn.acquire.command_line", "excite", robot, "-o", str(output)]
    command += ["--harmonics", "3", "--period", "3", "--length", "7", "--search", "600"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        first = process.stderr.readline()
        assert "collision geometry" in first, first + process.stderr.read()
        time.sleep(1.0)  # what comes before the search takes a tenth
        assert process.poll() is None
        os.killpg(process.pid, signal.SIGINT)
        printed, errors = process.communicate(timeout=300)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == 0, errors
    assert "Traceback" not in errors
    assert f"written: {output}" in errors
    assert read_plan(output).reached > 1
