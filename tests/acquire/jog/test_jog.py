"""Verdicts of `exidyn jog` on joints that are right, and of joints that are wrong in a known way."""

import io
import json
from dataclasses import replace
from functools import partial

import numpy as np
import pinocchio as pin
import pytest

from exidyn.acquire.arguments import run_options
from exidyn.acquire.arguments.parser import DONE, WRONG
from exidyn.acquire.command_line import REFUSED, STOPPED, main
from exidyn.acquire.commands import jog_command
from exidyn.acquire.jog.effort import flange_travel
from exidyn.acquire.jog.there_and_back import SHARE, TURN, Travel, run_limits, there_and_back
from exidyn.acquire.run.stopping import monitors
from exidyn.acquire.terminal.run_summary import UNATTENDED
from exidyn.drivers import Driver
from exidyn.identification.effects import CoulombFriction, RigidBody
from exidyn.identification.model import Model
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.robot_files.robot_file import model_text, read_model

from ...parts.controllers import rsi_controller
from ...parts.runs.commissioning_parts import CELLS, PATIENT, controller_file, jog, jog_on, verdicts
from ...parts.runs.full_run import model as sliding_model
from ...parts.runs.run_parts import MODEL, ROBOT

pytestmark = pytest.mark.clocked(patient=True)

FRICTION, GRAVITY, ZERO = "friction with the motion", "gravity torque", "encoder zero"
OTHERS = "largest way of another joint"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(UNATTENDED, "yes")
    monkeypatch.setattr(run_options, "WatchLimits", partial(replace, PATIENT))
    # A peer counts the cycles that its process gets, on a busy machine half of those by the host.
    monkeypatch.setattr(monitors, "CLOCK_RATE", 0.0)
    return tmp_path


def robot_with(**drive):
    """A robot file of the cobot with other drive gains."""
    path = "other.toml"
    with open(path, "w", encoding="utf-8") as file:
        file.write(model_text(replace(MODEL, robot=replace(ROBOT, **drive))))
    return path


def wrong(text):
    return [name for name, verdict in verdicts(text).items() if verdict == "wrong"]


@pytest.mark.parametrize(
    ("arguments", "degrees"), [(["2"], 2.0), (["joint3"], 2.0), ([3, "--degrees", -4], -4.0)]
)
def test_a_right_joint_is_judged_right(arguments, degrees, capsys):
    code, text = jog(capsys, *arguments)
    assert code == DONE
    assert list(verdicts(text).values())[:4] == ["right"] * 4
    assert text["stop"] == "none"
    assert text["distance"] == pytest.approx(np.radians(degrees))


def test_a_robot_with_negative_gains_and_a_balancer_is_right_too(capsys):
    assert main(["jog", "2", "--robot", "kr270", "--json", "-"]) == DONE
    text = json.loads(capsys.readouterr().out)
    assert set(verdicts(text).values()) == {"right"}
    zero = text["judgements"][-1]
    assert zero["low"] < 0.0 < zero["high"]


def test_a_joint_that_gravity_does_not_pull_at_shows_no_gain(capsys):
    code, output = jog(capsys, 1)
    assert code == DONE
    assert verdicts(output)[GRAVITY] == "unknown"
    assert verdicts(output)[ZERO] == "unknown"
    assert "cannot be judged from this motion" in output["judgements"][-1]["text"]
    assert verdicts(output)[FRICTION] == "right"


@pytest.mark.parametrize(
    ("faults", "value", "expected"),
    [
        ("scale -1 joint3 at start", -1.0, ["way"]),
        ("scale 2 joint3 at start", 2.0, ["way"]),
        ("scale 0.5 joint3 at start", 0.5, ["way"]),
        ("stuck joint3 at start", 0.0, ["way"]),
        ("exchange joint3 at start", 0.0, ["way", OTHERS]),
    ],
)
def test_wrong_encoders_are_reported(faults, value, expected, capsys):
    code, text = jog(capsys, 3, "--set", f"faults={faults}")
    assert code in (WRONG, STOPPED)
    assert wrong(text) == expected
    assert text["judgements"][0]["value"] == pytest.approx(value, abs=0.02)
    assert "NOT as it should be: way" in text["summary"]
    assert verdicts(text)[GRAVITY] == "unknown"


@pytest.mark.parametrize(
    ("factor", "expected", "words"),
    [
        (-1.0, [FRICTION, GRAVITY], "the sign of drive gain or current"),
        (0.5, [GRAVITY], "0.50 of the nominal torque"),
        (2.0, [GRAVITY], "2.0"),
    ],
)
def test_wrong_gains_are_reported(factor, expected, words, capsys):
    nominal = robot_with(drive_gain=factor * ROBOT.drive_gain)
    assert main(["jog", "2", "--robot", nominal, "--plant", "cobot", "--json", "-"]) == WRONG
    output = json.loads(capsys.readouterr().out)
    assert wrong(output) == expected
    assert words in " ".join(one["text"] for one in output["judgements"])


def test_a_load_that_nobody_named_is_seen_and_a_named_one_is_right(capsys):
    loaded = MODEL.robot.kinematics.copy()
    loaded.appendBodyToJoint(
        6, pin.Inertia(10.0, np.array([0.0, 0.0, 0.1]), 0.1 * np.eye(3)), MODEL.robot.flange
    )
    with open("loaded.toml", "w", encoding="utf-8") as file:
        file.write(model_text(replace(MODEL, robot=replace(ROBOT, kinematics=loaded))))
    code, text = jog(capsys, 2, "--plant", "loaded.toml")
    assert (code, wrong(text)) == (WRONG, [GRAVITY])
    code, text = jog(capsys, 2, "--mass", 10, "--com", 0, 0, 0.1)
    assert code == DONE
    assert verdicts(text)[GRAVITY] == "right"


def test_without_gains_currents_show_nothing(capsys):
    unknown = robot_with(drive_gain=np.ones(6))
    assert main(["jog", "2", "--robot", unknown, "--plant", "cobot", "--json", "-"]) == DONE
    output = json.loads(capsys.readouterr().out)
    assert verdicts(output)[FRICTION] == "unknown"
    assert "no drive gains" in output["judgements"][2]["text"]


def test_without_currents_only_the_way_is_reported(capsys):
    code, output = jog(capsys, 2, "--set", "silent=current")
    assert code == DONE
    assert "neither current nor torque" in output["judgements"][2]["text"]


def test_a_joint_that_slides_goes_millimetres(capsys, tmp_path):
    slides = sliding_model()
    limits = replace(slides.robot.limits, velocity=np.full(3, 1.0), velocity_lower=np.full(3, -1.0))
    slides = Model(replace(slides.robot, limits=limits), (RigidBody(), CoulombFriction(("achse_1",))))
    (tmp_path / "slides.toml").write_text(model_text(slides))
    assert main(["jog", "3", "--robot", "slides.toml", "--mm", "-8", "--json", "-"]) in (DONE, WRONG)
    text = json.loads(capsys.readouterr().out)
    assert text["distance"] == pytest.approx(-0.008)
    assert text["judgements"][0]["value"] == pytest.approx(1.0, abs=0.05)
    assert main(["jog", "3", "--robot", "slides.toml", "--degrees", "2"]) == REFUSED
    assert "achse_3 is prismatic: give the distance with --mm" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["elbow"], "no joint 'elbow'. Valid joints: joint1, joint2"),
        (["0"], "numbers 1 to 6"),
        (["7"], "no joint '7'"),
        (["2", "--degrees", "11"], "11 deg; a jog goes up to 10 deg in either direction"),
        (["2", "--degrees", "0"], "0 deg; a jog goes up to 10 deg"),
        (["2", "--mm", "5"], "joint2 is revolute: give the distance with --degrees"),
        (["2", "--com", "0", "0", "1"], "com given without --mass"),
        (["2", "--current", "1", "2"], "--current has 2 values"),
        (["2", "-o", "run.txt"], "recordings end in .mcap"),
        (["2", "--driver", "feetech", "--plant", "kr270"], "feetech moves a real arm"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line_before_anything_else(arguments, words, capsys, tmp_path):
    assert main(["jog", "--robot", "cobot", *arguments]) == REFUSED
    printed = capsys.readouterr()
    assert words in printed.err
    assert len(printed.err.splitlines()) == 1
    assert not list(tmp_path.glob("*.mcap*"))


def test_beyond_the_limits_nothing_is_powered_and_nothing_moved(capsys, tmp_path):
    narrow = replace(ROBOT.limits, position_upper=np.radians([0.0, -125.0, 0.0, 0.0, 0.0, 0.0]))
    (tmp_path / "narrow.toml").write_text(model_text(replace(MODEL, robot=replace(ROBOT, limits=narrow))))
    with CELLS["kuka_rsi"](tmp_path) as (peer, path):
        arguments = ["--robot", "narrow.toml", "--controller", str(path), "--yes"]
        assert main(["jog", "2", *arguments]) == REFUSED
        peer.close()
        assert json.loads(peer.lines[-1])["farthest"] == 0.0
    text = capsys.readouterr().err
    assert "joint2 would go to -124.00 deg, its limits are -180.0 to -125.0 deg" in text
    assert not list(tmp_path.glob("*.mcap*"))


def test_without_a_yes_nothing_is_opened(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr("sys.stdin", io.StringIO("y\n"))
    servos = ["--driver", "feetech", "--set", "port=/dev/nowhere", "--set", "ids=[1, 2, 3, 4, 5, 6]"]
    servos += ["--set", "cycle=0.01"]
    assert main(["jog", "2", "--robot", "cobot", *servos]) == STOPPED
    text = capsys.readouterr().err
    assert "joint2, joint 2 of 6, +2.00 deg and back at 2 deg/s" in text
    assert "not safety-rated" in text
    assert "nothing was moved" in text
    assert "--speed" not in text
    assert not list(tmp_path.glob("*.mcap*"))


def test_yes_alone_moves_nothing_real(capsys, monkeypatch):
    monkeypatch.delenv(UNATTENDED)
    servos = ["--driver", "feetech", "--set", "port=/dev/nowhere", "--set", "ids=[1, 2, 3, 4, 5, 6]"]
    assert main(["jog", "2", "--robot", "cobot", "--yes", *servos, "--set", "cycle=0.01"]) == REFUSED
    assert UNATTENDED in capsys.readouterr().err


def test_it_is_recorded_and_the_place_is_printed(capsys):
    assert main(["jog", "2", "--robot", "cobot"]) == DONE
    assert main(["jog", "2", "--robot", "cobot", "-o", "elbow.mcap"]) == DONE
    assert main(["jog", "2", "--robot", "cobot"]) == DONE
    printed = capsys.readouterr()
    for name in ("jog.mcap", "elbow.mcap", "jog-2.mcap"):
        assert f"written: {name}" in printed.err
        run = read_recording(name)
        assert run.settings["jog"] == "joint2 by 0.0349066 rad and back"
        assert run.outcome["stop"] == "none"
        way = run.signals["command"].values[:, 1]
        assert np.ptp(way) == pytest.approx(np.radians(2.0))


def test_a_person_reads_where_it_goes_and_what_is_in_order(capsys):
    assert main(["jog", "2", "--robot", "cobot"]) == DONE
    printed = capsys.readouterr()
    said = " ".join(printed.err.split())
    assert "joint2 stands at -126.00 deg (limits -180.0 to 0.0), goes to -124.00 deg and back" in said
    assert "the flange goes 39.8 mm" in said
    assert "the joint turns about" in said
    rows = [row.split() for row in printed.out.splitlines()]
    [(held, lowest, to, highest, *rest)] = [row[2:] for row in rows if row[:2] == ["gravity", "torque"]]
    # A mean over the cycles that were not missed, and a range around it: within 1 %, whichever those are.
    np.testing.assert_allclose([float(held), float(lowest), float(highest)], [86.93, 65.27, 116.0], rtol=0.01)
    assert [to, *rest] == ["to", "N", "m", "right"]
    assert "This program cannot see the arm." in " ".join(printed.out.split())


def test_the_motion_is_slow_and_ends_where_it_began():
    robot = read_model("cobot").robot
    way = Travel.of(robot, 2, np.radians(10.0))
    here = np.zeros(6)
    states = there_and_back(here, way, run_limits(robot), 0.004).every(0.004)
    assert np.abs(states.velocity).max() <= TURN + 1e-12
    assert np.ptp(states.position, axis=0) == pytest.approx([0, 0, np.radians(10.0), 0, 0, 0])
    np.testing.assert_allclose(states.position[-1], here, atol=1e-9)
    slow = replace(
        robot, limits=replace(robot.limits, velocity=np.full(6, 0.1), velocity_lower=np.full(6, -0.1))
    )
    assert Travel.of(slow, 2, 0.01).speed == pytest.approx(SHARE * 0.1)


def test_a_kuka_is_right_and_exchanged_axes_are_not(tmp_path, capsys):
    code, output, peer = jog_on("kuka_rsi", tmp_path, capsys, 2)
    assert code == DONE, output["text"]
    assert list(verdicts(output).values())[:4] == ["right"] * 4
    assert json.loads(peer.lines[-1])["farthest"] == pytest.approx(2.0, abs=0.01)
    code, output, peer = jog_on("kuka_rsi", tmp_path, capsys, 2, axes="A1 A3 A2 A4 A5 A6")
    assert (code, wrong(output)) == (WRONG, [GRAVITY])
    assert "the order of the joints" in output["judgements"][3]["text"]


@pytest.mark.parametrize("cell", ["kuka_rsi", "canopen_402", "can_mit"])
def test_planning_may_take_longer_than_a_controller_waits(cell, tmp_path, capsys, monkeypatch):
    """Their Timeout and dead man are 2 s."""

    def slow(*arguments):
        Driver.clock.sleep(2.5)
        return flange_travel(*arguments)

    monkeypatch.setattr(jog_command, "flange_travel", slow)
    _, output, _ = jog_on(cell, tmp_path, capsys, 2)
    assert output["stop"] == "none", output["text"]


def test_a_kuka_axis_that_turns_against_its_joint_is_wrong(tmp_path, capsys):
    sign = [1, 1, -1, 1, 1, 1]
    code, text, _ = jog_on("kuka_rsi", tmp_path, capsys, 3, sign=sign)
    assert code == WRONG
    assert FRICTION in wrong(text)


def test_drives_on_can_and_servos_are_right_and_a_current_of_the_other_sign_is_not(tmp_path, capsys):
    for driver in ("dynamixel", "canopen_402"):
        code, text, peer = jog_on(driver, tmp_path, capsys, 3, "--degrees", 4)
        assert code == DONE
        assert list(verdicts(text).values())[:3] == ["right"] * 3
    assert peer.printed("enabled")
    nominal = robot_with(drive_gain=-ROBOT.drive_gain)
    code, text, _ = jog_on("canopen_402", tmp_path, capsys, 3, "--degrees", 4, "--robot", nominal)
    assert code == WRONG
    assert FRICTION in wrong(text)


def test_torque_of_motors_that_is_none_is_seen(tmp_path, capsys):
    """These motors state their currents where the frame has torque."""
    code, text, _ = jog_on("can_mit", tmp_path, capsys, 2, "--degrees", 4)
    assert verdicts(text)["way"] == "right"
    assert code == WRONG
    assert wrong(text) == [GRAVITY]


def test_a_controller_that_only_reports_is_not_jogged(tmp_path, capsys):
    config = rsi_controller.config_file(tmp_path, only_send=True)
    given = {"controller": "127.0.0.1", "config": str(config), "wait": 20.0}
    with rsi_controller.running(config):
        path = controller_file(tmp_path, "kuka_rsi", given)
        assert main(["jog", "2", "--robot", "cobot", "--controller", str(path), "--yes"]) == REFUSED
    assert "the controller only sends" in capsys.readouterr().err
