"""External torque live: the same as offline, and its words."""

import json
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.run.listener import Reading
from exidyn.acquire.terminal.live_contact import LiveContact
from exidyn.acquire.terminal.watch_text import External, JointUnits, json_line, line, table_lines
from exidyn.drivers import Info, Sample
from exidyn.identification.contact.contact import contact
from exidyn.identification.errors import RecordingError
from exidyn.identification.fit.fit_file import write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.robot_files.robot_file import model_text

from ...parts.small import small_fit, two_joint_files

arm = pytest.importorskip("parts.contact.touched_arm")

TOUCH = arm.Touch((0.0, 0.0, -12.0), 3.0, 4.0)


def samples(run):
    """Samples of a driver that measures what a run has."""
    position, torque = run.signals["position"], run.signals["torque"]
    unknown = np.full(3, np.nan)
    return [
        Sample(10**9, int(1e9 * (t + 7.0)), q, unknown, unknown, tau, unknown)
        for t, q, tau in zip(position.time, position.values, torque.values, strict=True)
    ]


def test_live_and_offline_agree_in_pieces_of_any_length():
    fit, free = identify([arm.run("train", 1)]), [arm.run("free", 2)]
    run = arm.run("touched", 4, 6.0, [TOUCH])
    offline = contact(fit, run, free)
    live, received, readings = LiveContact(fit, free, "", 1.0), samples(run), []
    for start in range(0, len(received), 91):
        readings.append(live.add(received[start : start + 91]))
    assert readings[-1].contacts == len(offline.alarms) == 1
    touched = [k for k, reading in enumerate(readings) if reading.over]
    assert 3.0 < (touched[0] + 1) * 91 * arm.STEP < 3.4
    assert 4.0 < (touched[-1] + 1) * 91 * arm.STEP < 4.6
    middle = readings[touched[len(touched) // 2]]
    np.testing.assert_allclose(middle.force, TOUCH.force, atol=1.5)
    assert np.any(np.abs(middle.torque) > middle.contact_from)
    assert live.add([]).contacts == 1
    alone = LiveContact(fit, [], "", 1.0)
    last = alone.add(received)
    assert np.isnan(last.contact_from).all()
    assert last.over == ()
    np.testing.assert_allclose(last.torque, offline.estimates.torque[-1], atol=1e-6)  # whole ns


def test_a_threshold_needs_runs_that_the_fit_has_not_used():
    with pytest.raises(RecordingError, match="empty was used for the fit"):
        LiveContact(small_fit.fit(), [two_joint_files.run("empty")], "", 1.0)


def test_the_arm_of_watch_is_that_of_the_fit(tmp_path, capsys):
    """Joint names alone would let the fit of one arm judge another with six joints."""
    fit = small_fit.fit()
    write_fit(fit, tmp_path / "fit.json")
    model = two_joint_files.of_another_arm(two_joint_files.run("new")).model
    other = replace(model, robot=replace(model.robot, name="long arm"))
    (tmp_path / "robot.toml").write_text(model_text(other))
    arguments = ["--robot", str(tmp_path / "robot.toml"), "--fit", str(tmp_path / "fit.json")]
    assert main(["watch", "--driver", "mock", *arguments, "--length", "0.1"]) == REFUSED
    assert "is of two joints, an arm with other geometry than --robot" in capsys.readouterr().err
    assert main(["watch", "--driver", "mock", "--robot", "cobot", "--free", "run.mcap"]) == REFUSED
    assert "--free is for a threshold of contact; name the fit with --fit" in capsys.readouterr().err


def test_words_of_a_reading():
    numbers = np.array([0.1, 0.2])
    reading = Reading(0, numbers, numbers, numbers, numbers, numbers, ("", ""), 3, np.zeros(2), (), "")
    units = JointUnits.of(two_joint_files.NOMINAL.robot)
    info = Info(0.002, "host", ("position", "current"))
    external = External(np.array([0.5, -7.25]), np.array([3.0, 2.0]), np.array([1.0, np.nan, -9.0]), (1,), 2)
    text = line(reading, units, info, 1.0, external)
    assert "external torque 0.50 -7.25 N m; CONTACT: elbow; force on the flange 1.0 - -9.0 N" in text
    rows = table_lines(reading, units, info, 1.0, [], external)
    assert rows[3].split()[-3:-1] == ["-7.25", "2.00"]
    assert "CONTACT: elbow" in rows
    assert "contacts so far: 2" in rows
    content = json.loads(json_line(reading, units, 1.0, external))
    assert content["external_torque"] == [0.5, -7.25]
    assert (content["contact"], content["contacts"], content["force"]) == (["elbow"], 2, [1.0, None, -9.0])
    assert "external_torque" not in json.loads(json_line(reading, units, 1.0))
    hint = "no threshold of contact: state runs without contact with --free"
    assert hint not in text
    assert hint in line(reading, units, info, 1.0, external._replace(contact_from=np.full(2, np.nan)))


@pytest.mark.clocked(patient=True)
def test_watch_estimates_on_the_mock(tmp_path, monkeypatch, capsys):
    write_fit(small_fit.fit(), tmp_path / "fit.json")
    monkeypatch.chdir(tmp_path)
    arguments = ["--fit", "fit.json", "--driver", "mock", "--length", "2", "--json", "-"]
    assert main(["watch", *arguments]) == 0
    last = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert last["joints"] == ["shoulder", "elbow"]
    assert np.all(np.isfinite(last["external_torque"]))
    assert last["contact_from"] == [None, None]
