"""exidyn init: files that it writes, reads back as proposed, and does not write over."""

import json
import re

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.effects.rigid_body import RigidBody
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.fit.base_parameters import rich_motion
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model, urdf_text

from ...parts.runs.logs import cobot_log, columns

LOG = cobot_log()


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(urdf_text(LOG.model))
    named = {"Zeit": 1e3 * LOG.time, **columns("A{k}_Winkel", np.degrees(LOG.position))}
    named |= columns("A{k}_Strom", LOG.current)
    rows = np.column_stack(list(named.values()))
    np.savetxt("log.csv", rows, delimiter=",", header=",".join(named), comments="", fmt="%.9g")
    return tmp_path


def test_what_init_writes_imports_the_log_in_si(files, capsys):
    assert main(["init", "log.csv", "--robot", "arm.urdf", "--json", "found.json"]) == 0
    assert re.search(r"^unit of position +deg +> 99\.9 %", capsys.readouterr().out, re.MULTILINE)
    found = json.loads((files / "found.json").read_text())
    assert found["then"] == "exidyn import log.csv --robot robot.toml"
    assert main(found["then"].split()[1:]) == 0
    run = read_recording(files / "log.mcap")
    np.testing.assert_allclose(run.signals["position"].values, LOG.position, atol=1e-6)
    np.testing.assert_allclose(run.signals["current"].values, LOG.current, atol=1e-6)
    assert run.signals["position"].time[-1] == pytest.approx(LOG.time[-1])


def test_gains_that_are_decided_are_stated_beside_others(files):
    assert main(["init", "log.csv", "--robot", "arm.urdf", "--json", "found.json"]) == 0
    gains = json.loads((files / "found.json").read_text())["gains"]
    known = np.array([gain["known"] for gain in gains])
    assert known.any()
    assert not known.all()
    robot = read_model(files / "robot.toml").robot
    stated = [gain["value"] for gain in gains if gain["known"]]
    np.testing.assert_allclose(robot.drive_gain[known], stated, rtol=1e-3)
    assert np.all(robot.drive_gain_tolerance[known] < 0.4)
    assert np.all(robot.drive_gain_tolerance[~known] == 1.0)
    joint = robot.joints[int(np.argmin(known))]
    assert re.search(rf"^# \[drive\] gain of {joint}.* is a guess", (files / "robot.toml").read_text(), re.M)


def test_a_log_of_commands_and_no_effort_is_one_of_position_servos(files, capsys):
    stiffness = 4000.0
    command = LOG.position + LOG.current * LOG.model.robot.drive_gain / stiffness
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("q_ref{k}", command)}
    rows = np.column_stack(list(named.values()))
    np.savetxt("servos.csv", rows, delimiter=",", header=",".join(named), comments="", fmt="%.9g")
    assert main(["init", "servos.csv", "--robot", "arm.urdf"]) == 0
    said = capsys.readouterr().out
    assert "the position error takes its place" in " ".join(said.split())
    gains = [float(value) for value in re.findall(r"^gain of \S+ +(\S+) N m ±", said, re.MULTILINE)]
    assert len(gains) >= 2
    assert np.all(np.abs(np.log(np.array(gains) / stiffness)) < 0.7)
    assert "\nservo_gain = [1.0, " in (files / "robot.toml").read_text()
    assert main(["import", "servos.csv", "--robot", "robot.toml"]) == 0
    run = read_recording(files / "servos.mcap")
    np.testing.assert_allclose(run.signals["current"].values, command - LOG.position, atol=1e-6)


def test_an_mjcf_is_taken_where_a_urdf_is(files):
    pytest.importorskip("mujoco")
    (files / "arm.xml").write_text(FORMATS["mjcf"].text(Portable.of(LOG.model)))
    assert main(["init", "log.csv", "--robot", "arm.xml"]) == 0
    assert '\nmjcf = "arm.xml"' in (files / "robot.toml").read_text()
    motion = rich_motion(LOG.model)
    found, expected = (
        RigidBody().regressor(model.robot, motion) @ model.nominal_values[:60]
        for model in (read_model(files / "robot.toml"), LOG.model)
    )
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("existing", ["robot.toml", "preset.toml"])
def test_no_file_is_written_over_without_force(files, existing, capsys):
    (files / existing).write_text("mine")
    assert main(["init", "log.csv", "--robot", "arm.urdf"]) == REFUSED
    assert f"{existing}: this file exists; --force" in capsys.readouterr().err
    assert (files / existing).read_text() == "mine"
    other = {"robot.toml": "preset.toml", "preset.toml": "robot.toml"}[existing]
    assert not (files / other).exists()
    assert main(["init", "log.csv", "--robot", "arm.urdf", "--force"]) == 0
    assert (files / existing).read_text() != "mine"


def test_a_recording_needs_no_preset_and_efforts_in_amperes_an_option(files):
    signals = {"position": LOG.position, "torque": LOG.current / 50.0}
    run = Recording("run", LOG.model, {name: Signal(LOG.time, one) for name, one in signals.items()})
    write_recording(run, files / "run.mcap")
    assert main(["init", "run.mcap", "--robot", "arm.urdf", "--json", "found.json"]) == 0
    assert not (files / "preset.toml").exists()
    found = json.loads((files / "found.json").read_text())
    assert found["then"] == ""
    assert "exidyn export run.mcap --to csv" in found["refusal"]


def test_torques_that_count_against_the_joints_are_imported_with_the_other_sign(files):
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("tau{k}", -LOG.torque)}
    rows = np.column_stack(list(named.values()))
    np.savetxt("against.csv", rows, delimiter=",", header=",".join(named), comments="", fmt="%.9g")
    assert main(["init", "against.csv", "--robot", "arm.urdf"]) == 0
    assert main(["import", "against.csv", "--robot", "robot.toml"]) == 0
    signals = read_recording(files / "against.mcap").signals
    np.testing.assert_allclose(signals["torque"].values, LOG.torque, atol=1e-5)
    assert "current" not in signals


def test_of_a_recording_such_torques_have_a_gain_of_minus_one(files):
    signals = {"position": LOG.position, "torque": -LOG.torque}
    run = Recording("run", LOG.model, {name: Signal(LOG.time, one) for name, one in signals.items()})
    write_recording(run, files / "run.mcap")
    assert main(["init", "run.mcap", "--robot", "arm.urdf", "--json", "found.json"]) == 0
    assert "exidyn export run.mcap --to csv" in json.loads((files / "found.json").read_text())["refusal"]
    assert np.all(read_model(files / "robot.toml").robot.drive_gain == -1.0)


def test_a_log_without_time_has_the_rate_that_is_given(files, capsys):
    named = {**columns("q{k}", LOG.position), **columns("i{k}", LOG.current)}
    rows = np.column_stack(list(named.values()))
    np.savetxt("bare.csv", rows, delimiter=",", header=",".join(named), comments="", fmt="%.9g")
    assert main(["init", "bare.csv", "--robot", "arm.urdf"]) == REFUSED
    assert "exidyn init --rate HZ" in capsys.readouterr().err
    assert main(["init", "bare.csv", "--robot", "arm.urdf", "--rate", "100"]) == 0
    assert main(["import", "bare.csv", "--robot", "robot.toml"]) == 0
    position = read_recording(files / "bare.mcap").signals["position"]
    np.testing.assert_allclose(position.values, LOG.position, atol=1e-6)
    np.testing.assert_allclose(position.time, LOG.time, atol=1e-9)


def test_what_is_undecided_is_said_and_no_preset_is_written(files, capsys):
    noise = np.random.default_rng(0).normal(size=LOG.position.shape)
    names = ["t", *columns("q{k}", noise), *columns("i{k}", noise)]
    rows = np.column_stack([LOG.time, 1.5 * LOG.position, noise])
    np.savetxt("far.csv", rows, delimiter=",", header=",".join(names), comments="")
    assert main(["init", "far.csv", "--robot", "arm.urdf"]) == 0
    said = capsys.readouterr()
    assert "NOT DECIDED: unit of position" in said.out
    assert "Next:" not in said.out
    assert not (files / "preset.toml").exists()
    assert "# unit of position" in (files / "robot.toml").read_text()


GRIPPER = """<link name="finger"/><link name="thumb"/>
<joint name="grip" type="prismatic"><parent link="{last}"/><child link="finger"/><axis xyz="1 0 0"/></joint>
<joint name="follow" type="prismatic"><parent link="{last}"/><child link="thumb"/><axis xyz="1 0 0"/>
<mimic joint="grip"/></joint></robot>"""


def test_joints_of_the_urdf_that_the_log_lacks_are_held(files, capsys):
    text = (files / "arm.urdf").read_text()
    last = re.findall(r'child link="(\w+)"', text)[-1]
    (files / "arm.urdf").write_text(text.replace("</robot>", GRIPPER.format(last=last)))
    joints = LOG.model.robot.joints
    named = {"t": LOG.time, **dict(zip([f"{j}_position" for j in joints], LOG.position.T, strict=True))}
    named |= dict(zip([f"{j}_effort" for j in joints], LOG.torque.T, strict=True))
    named["grip_position"] = 0.01 * np.sin(LOG.time)
    rows = np.column_stack(list(named.values()))
    np.savetxt("named.csv", rows, delimiter=",", header=",".join(named), comments="", fmt="%.9g")
    assert main(["init", "named.csv", "--robot", "arm.urdf"]) == 0
    assert re.search(r"held\s+fixed.*their\s+effort:\s+grip,\s+follow", capsys.readouterr().out, re.DOTALL)
    assert read_model(files / "robot.toml").robot.joints == joints
    assert main(["import", "named.csv", "--robot", "robot.toml"]) == 0
    np.testing.assert_allclose(
        read_recording(files / "named.mcap").signals["torque"].values, LOG.torque, rtol=1e-6, atol=1e-6
    )


def log_with_a_joint_at_rest(path, turn=0.0):
    """The second joint stands at 40 degrees, or turns away from there by so much [deg]."""
    position = np.degrees(LOG.position)
    position[:, 1] = 40.0 + turn * LOG.time / LOG.time[-1]
    named = {"t": LOG.time, **columns("q{k}", position), **columns("i{k}", LOG.current)}
    named |= columns("dq{k}", np.degrees(LOG.velocity))
    np.savetxt(path, np.column_stack([*named.values()]), delimiter=",", header=",".join(named), comments="")


def test_a_joint_that_never_moves_is_held_where_it_stands(files, capsys):
    log_with_a_joint_at_rest(files / "rest.csv")
    assert main(["init", "rest.csv", "--robot", "arm.urdf"]) == 0
    second, *others = np.roll(LOG.model.robot.joints, -1).tolist()
    assert f"* {second} does not move: the model holds it at 0.6981 rad" in capsys.readouterr().out
    assert main(["import", "rest.csv", "--robot", "robot.toml"]) == 0
    run = read_recording(files / "rest.mcap")
    assert sorted(run.robot.joints) == sorted(others)
    kept = [LOG.model.robot.joints.index(joint) for joint in run.robot.joints]
    np.testing.assert_allclose(run.signals["position"].values, LOG.position[:, kept], atol=1e-6)
    np.testing.assert_allclose(run.signals["current"].values, LOG.current[:, kept], atol=1e-6)
    assert main(["identify", "rest.mcap"]) == 0


def test_a_log_that_moves_a_joint_that_is_held_is_refused(files, capsys):
    log_with_a_joint_at_rest(files / "rest.csv")
    assert main(["init", "rest.csv", "--robot", "arm.urdf"]) == 0
    log_with_a_joint_at_rest(files / "moved.csv", turn=5.0)
    capsys.readouterr()
    assert main(["import", "moved.csv", "--robot", "robot.toml"]) == REFUSED
    message = capsys.readouterr().err
    assert (
        "moved.csv: column q2 goes from 40.00 to 45.00, but its joint is held between 39.94 and 40.06"
        in message
    )
    assert main(["init", "rest.csv", "moved.csv", "--robot", "arm.urdf", "--force"]) == 0
    assert read_model(files / "robot.toml").robot.joints == LOG.model.robot.joints


def test_a_log_of_joints_that_turn_and_slide_is_imported_as_proposed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    slide = '<link name="floor"/><joint name="lift" type="prismatic"><parent link="floor"/>'
    slide += '<child link="{first}"/><axis xyz="0 0 1"/></joint>'
    text = urdf_text(LOG.model)
    first = re.findall(r'link name="(\w+)"', text)[0]
    (tmp_path / "arm.urdf").write_text(text.replace("<link", slide.format(first=first) + "<link", 1))
    joints = ("lift", *LOG.model.robot.joints)
    position = np.column_stack([0.2 * np.sin(LOG.time), np.degrees(LOG.position)])
    effort = np.column_stack([300.0 + np.cos(LOG.time), LOG.current])
    named = dict(zip([f"{j}_position" for j in joints], position.T, strict=True))
    named |= dict(zip([f"{j}_current" for j in joints], effort.T, strict=True))
    rows = np.column_stack([LOG.time, *named.values()])
    np.savetxt("log.csv", rows, delimiter=",", header=",".join(["t", *named]), comments="", fmt="%.9g")
    assert main(["init", "log.csv", "--robot", "arm.urdf"]) == 0
    assert 'unit = ["m", "deg", "deg"' in (tmp_path / "preset.toml").read_text()
    assert main(["import", "log.csv", "--robot", "robot.toml"]) == 0
    found = read_recording(tmp_path / "log.mcap").signals["position"].values
    np.testing.assert_allclose(found, np.column_stack([position[:, 0], LOG.position]), atol=1e-6)


def test_efforts_that_are_not_measured_give_no_gain(files, capsys):
    current = LOG.current.copy()
    current[:, 2] = 0.001 * (np.random.default_rng(1).random(len(current)) > 0.9)
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("i{k}", current)}
    rows = np.column_stack(list(named.values()))
    np.savetxt("mute.csv", rows, delimiter=",", header=",".join(named), comments="", fmt="%.9g")
    assert main(["init", "mute.csv", "--robot", "arm.urdf", "--json", "found.json"]) == 0
    assert re.search(r"not\s+measured: joint3 in 9\d %", capsys.readouterr().out)
    gains = json.loads((files / "found.json").read_text())["gains"]
    assert [gain["known"] for gain in gains][1:3] == [True, False]
    assert main(["import", "mute.csv", "--robot", "robot.toml"]) == 0
    [warning] = read_recording(files / "mute.mcap").warnings
    assert "as if they were not measured: joint3 in 9" in warning


def write_runs(folder, first=slice(0, 990), second=slice(990, None)):
    """Rows of the log as two runs, the time of each from zero."""
    head, *rows = (folder / "log.csv").read_text().splitlines()
    for name, which in (("a.csv", first), ("b.csv", second)):
        cells = [row.split(",", 1) for row in rows[which]]
        lines = [f"{float(time) - float(cells[0][0]):.9g},{rest}" for time, rest in cells]
        (folder / name).write_text("\n".join([head, *lines]))


def test_several_logs_are_weighed_together(files, capsys):
    write_runs(files)
    assert main(["init", "log.csv", "--robot", "arm.urdf", "--json", "whole.json"]) == 0
    assert main(["init", "a.csv", "b.csv", "--robot", "arm.urdf", "--force", "--json", "both.json"]) == 0
    assert "s in 2 runs" in capsys.readouterr().out
    whole, both = (json.loads((files / name).read_text()) for name in ("whole.json", "both.json"))
    assert [one["value"] for one in both["guesses"]][:5] == [one["value"] for one in whole["guesses"]][:5]
    assert both["then"] == "exidyn import a.csv --robot robot.toml"


def test_logs_of_different_rates_are_two_runs(files, capsys):
    write_runs(files, slice(0, None, 5), slice(0, 150))  # most samples are of the slow one
    for logs in (["a.csv", "b.csv"], ["b.csv", "a.csv"]):
        assert main(["init", *logs, "--robot", "arm.urdf", "--force"]) == 0
        text = capsys.readouterr().out
        assert "s in 2 runs" in text
        assert "and the same for 1 other log" in text


def test_logs_with_other_columns_are_refused(files, capsys):
    write_runs(files)
    (files / "b.csv").write_text((files / "b.csv").read_text().replace("A1_Strom", "A1_Drehmoment"))
    assert main(["init", "a.csv", "b.csv", "--robot", "arm.urdf"]) == REFUSED
    assert "b.csv has other columns than a.csv: A1_Drehmoment, A1_Strom" in capsys.readouterr().err
    assert not (files / "robot.toml").exists()


def test_a_preset_with_a_number_for_its_ranges_is_refused(files, capsys):
    assert main(["init", "log.csv", "--robot", "arm.urdf"]) == 0
    preset = files / "preset.toml"
    preset.write_text("still = 3\n" + preset.read_text())
    capsys.readouterr()
    assert main(["import", "log.csv", "--robot", "robot.toml"]) == REFUSED
    assert "[still] is 3; expected a table of COLUMN = [LOWEST, HIGHEST]" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("column", "said"), [("Temperatur_A2", "leaves the column out"), ("A2_Winkel", "refuses that")]
)
def test_text_in_a_column_is_said(files, capsys, column, said):
    head, *lines = (files / "log.csv").read_text().splitlines()
    warm = columns("Temperatur_A{k}", np.full_like(LOG.position, 30.0))
    rows = [line.split(",") + ["30"] * len(warm) for line in lines]
    names = [*head.split(","), *warm]
    rows[40][names.index(column)] = "err"
    (files / "log.csv").write_text("\n".join(",".join(row) for row in [names, *rows]) + "\n")
    assert main(["init", "log.csv", "--robot", "arm.urdf"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert f"log.csv line 42: 'err' in column '{column}' is not a number: import {said}" in text
    code = main(["import", "log.csv", "--robot", "robot.toml"])
    assert (code == 0) == (said == "leaves the column out")


def test_the_hint_for_a_log_of_fewer_joints_leads_on(files, capsys):
    """What the error about numbered columns of some joints advises is what works."""
    four = {"t": LOG.time, **columns("q{k}", LOG.position[:, :4]), **columns("i{k}", LOG.current[:, :4])}
    table = np.column_stack(list(four.values()))
    np.savetxt("part.csv", table, delimiter=",", header=",".join(four), comments="", fmt="%.9g")
    assert main(["init", "part.csv", "--robot", "arm.urdf"]) == REFUSED
    assert "name the 4 in a robot.toml (urdf = ..., joints = [...])" in capsys.readouterr().err
    joints = json.dumps(list(LOG.model.robot.joints[:4]))
    (files / "four.toml").write_text(f'format = 1\nurdf = "arm.urdf"\njoints = {joints}\n')
    assert main(["init", "part.csv", "--robot", "four.toml", "-o", "made.toml"]) == 0


def test_columns_of_all_joints_stand_for_joints_with_other_names(files):
    words = [f"axle{'abcdef'[k]}" for k in range(LOG.model.robot.dof - 1)] + [LOG.model.robot.joints[-1]]
    named = {"t": LOG.time}
    for prefix, values in (("q", LOG.position), ("i", LOG.current)):
        named |= {f"{prefix}_{word}": column for word, column in zip(words, values.T, strict=True)}
    rows = np.column_stack(list(named.values()))
    np.savetxt("words.csv", rows, delimiter=",", header=",".join(named), comments="", fmt="%.9g")
    letters = {"position": "q", "current": "i"}
    chosen = [
        f"{signal}={','.join(f'{letter}_{word}' for word in words)}" for signal, letter in letters.items()
    ]
    assert main(["init", "words.csv", "--robot", "arm.urdf", "--columns", *chosen]) == 0
    assert read_model(files / "robot.toml").robot.joints == LOG.model.robot.joints
