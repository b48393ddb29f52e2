"""exidyn init: what it proposes for tables as people have them, import reads; nothing is overwritten."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.identification.effects.rigid_body import RigidBody
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.fit.base_parameters import rich_motion
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.robot_files.robot_file import read_model, urdf_text

from ...parts.runs.logs import columns, short_log

LOG = short_log()
DOF = LOG.model.robot.dof
PLAIN = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("i{k}", LOG.current)}
"""Columns that need no option."""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The working folder, with arm.urdf, and log.csv of a controller in ms, degrees and amperes."""
    monkeypatch.chdir(tmp_path)
    Path("arm.urdf").write_text(urdf_text(LOG.model))
    named = {"Zeit": 1e3 * LOG.time, **columns("A{k}_Winkel", np.degrees(LOG.position))}
    write("log.csv", named | columns("A{k}_Strom", LOG.current))
    return tmp_path


def write(name, named, above=(), separator=","):
    rows = np.column_stack(list(named.values())).tolist()
    lines = [separator.join(f"{value:.9g}" for value in row) for row in rows]
    if separator == ";":
        lines = [line.replace(".", ",") for line in lines]
    Path(name).write_text("\n".join([separator.join(named), *above, *lines]) + "\n")


def named_by_joints(signal, values, joints=LOG.model.robot.joints):
    """Columns such as joint1_position, whose names settle the order of joints."""
    return dict(zip([f"{joint}_{signal}" for joint in joints], values.T, strict=True))


def init(*arguments):
    """What init proposes, as JSON."""
    assert main(["init", *arguments, "--robot", "arm.urdf", "--json", "found.json"]) == 0
    return json.loads(Path("found.json").read_text())


def imported(log, *options):
    """The run, imported as init proposes."""
    proposal = init(log, *options)
    assert not proposal["refusal"]
    assert main(shlex.split(proposal["then"])[1:]) == 0
    return read_recording(re.sub(r"\..*", ".mcap", log))


def require(run, rows=slice(None), **expected):
    """Signals of a run are those of the log, in SI, or those that are given."""
    for name, values in ({"position": LOG.position} | expected).items():
        np.testing.assert_allclose(run.signals[name].values, values[rows], rtol=1e-6, atol=1e-5)


def known_gains(proposal):
    """Whether the gain of each joint is decided, and the gains that robot.toml states."""
    return np.array([gain["known"] for gain in proposal["gains"]]), read_model("robot.toml").robot.drive_gain


def said(capsys):
    page, notes = capsys.readouterr()
    return " ".join((page + notes[notes.find("written: ") :]).split())


def refused(capsys, *arguments):
    """The error of a command that is refused."""
    capsys.readouterr()
    assert main([str(argument) for argument in arguments]) == REFUSED
    return capsys.readouterr().err


def test_what_init_writes_imports_the_log_in_si_and_states_gains_that_are_decided(capsys):
    run = imported("log.csv")
    assert re.search(r"^unit of position +deg +> 99\.9 %", capsys.readouterr().out, re.MULTILINE)
    require(run, current=LOG.current)
    assert run.signals["position"].time[-1] == pytest.approx(LOG.time[-1])
    proposal = json.loads(Path("found.json").read_text())
    assert proposal["then"] == "exidyn import log.csv --robot robot.toml"
    known, stated = known_gains(proposal)
    assert known.any()
    assert not known.all()
    np.testing.assert_allclose(
        stated[known], [gain["value"] for gain in proposal["gains"] if gain["known"]], rtol=1e-3
    )
    robot = read_model("robot.toml").robot
    assert np.all(robot.drive_gain_tolerance[known] < 0.4)
    assert np.all(robot.drive_gain_tolerance[~known] > 0.35)
    joint = robot.joints[int(np.argmax(robot.drive_gain_tolerance))]
    assert re.search(rf"^# \[drive\] gain of {joint}.* is a guess", Path("robot.toml").read_text(), re.M)


def test_a_log_of_commands_and_no_effort_is_one_of_position_servos(capsys):
    stiffness = 4000.0
    command = LOG.position + LOG.current * LOG.model.robot.drive_gain / stiffness
    write("servos.csv", {"t": LOG.time, **columns("q{k}", LOG.position), **columns("q_ref{k}", command)})
    run = imported("servos.csv")
    printed = capsys.readouterr().out
    assert "the position error takes its place" in " ".join(printed.split())
    gains = [float(value) for value in re.findall(r"^gain of \S+ +(\S+) N m ±", printed, re.MULTILINE)]
    assert len(gains) >= 2
    assert np.all(np.abs(np.log(np.array(gains) / stiffness)) < 0.7)
    assert "\nservo_gain = [1.0, " in Path("robot.toml").read_text()
    require(run, current=command - LOG.position)


def test_an_mjcf_is_taken_where_a_urdf_is():
    pytest.importorskip("mujoco")
    Path("arm.xml").write_text(FORMATS["mjcf"].text(Portable.of(LOG.model)))
    assert main(["init", "log.csv", "--robot", "arm.xml"]) == 0
    assert '\nmjcf = "arm.xml"' in Path("robot.toml").read_text()
    motion = rich_motion(LOG.model)
    read, expected = (
        RigidBody().regressor(model.robot, motion) @ model.nominal_values[: 10 * DOF]
        for model in (read_model("robot.toml"), LOG.model)
    )
    np.testing.assert_allclose(read, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("existing", "other"), [("robot.toml", "preset.toml"), ("preset.toml", "robot.toml")]
)
def test_no_file_is_written_over_without_force(existing, other, capsys):
    Path(existing).write_text("mine")
    error = refused(capsys, "init", "log.csv", "--robot", "arm.urdf")
    assert f"{existing}: this file exists; --force" in error
    assert Path(existing).read_text() == "mine"
    assert not Path(other).exists()
    init("log.csv", "--force")
    assert Path(existing).read_text() != "mine"


@pytest.mark.parametrize(("efforts", "gain"), [(LOG.current / 50.0, None), (-LOG.torque, -1.0)])
def test_a_recording_needs_no_preset_but_efforts_of_another_unit_or_sign_an_export(efforts, gain):
    signals = {"position": Signal(LOG.time, LOG.position), "torque": Signal(LOG.time, efforts)}
    write_recording(Recording("run", LOG.model, signals), "run.mcap")
    proposal = init("run.mcap")
    assert not Path("preset.toml").exists()
    assert proposal["then"] == ""
    assert "exidyn export run.mcap --to csv" in proposal["refusal"]
    assert gain is None or np.all(read_model("robot.toml").robot.drive_gain == gain)


def test_torques_that_count_against_the_joints_are_imported_with_the_other_sign():
    write("log.csv", {"t": LOG.time, **columns("q{k}", LOG.position), **columns("tau{k}", -LOG.torque)})
    run = imported("log.csv")
    require(run, torque=LOG.torque)
    assert "current" not in run.signals


def test_a_log_without_time_has_the_rate_that_is_given_and_one_with_time_its_own(capsys):
    write("bare.csv", {name: column for name, column in PLAIN.items() if name != "t"})
    assert "exidyn init --rate HZ" in refused(capsys, "init", "bare.csv", "--robot", "arm.urdf")
    run = imported("bare.csv", "--rate", "100")
    require(run)
    np.testing.assert_allclose(run.signals["position"].time, LOG.time, atol=1e-9)
    write("log.csv", {"Time": LOG.time} | {name: PLAIN[name] for name in PLAIN if name != "t"})
    for command in ("init", "import"):
        error = refused(capsys, command, "log.csv", "--robot", "arm.urdf", "--rate", "100")
        assert "log.csv has its own time, column Time; --rate" in error


def test_what_is_undecided_is_said_and_the_best_guess_is_written(capsys):
    noise = np.random.default_rng(0).normal(size=LOG.position.shape)
    write("far.csv", {"t": LOG.time, **columns("q{k}", 2.0 * LOG.position), **columns("i{k}", noise)})
    init("far.csv")
    printed = said(capsys)
    assert "NOT DECIDED: " in printed
    assert re.search(r"Check first what is not decided \(.*next: exidyn import far.csv", printed)
    for file in ("preset.toml", "robot.toml"):
        assert re.search("^# (unit of position|order of joints)", Path(file).read_text(), re.MULTILINE)
    assert main(["import", "far.csv", "--robot", "robot.toml"]) == 0


GRIPPER = """<link name="finger"/><link name="thumb"/>
<joint name="grip" type="prismatic"><parent link="{last}"/><child link="finger"/><axis xyz="1 0 0"/></joint>
<joint name="follow" type="prismatic"><parent link="{last}"/><child link="thumb"/><axis xyz="1 0 0"/>
<mimic joint="grip"/></joint></robot>"""


def test_joints_of_the_urdf_that_the_log_lacks_are_held(capsys):
    text = urdf_text(LOG.model)
    last = re.findall(r'child link="(\w+)"', text)[-1]
    Path("arm.urdf").write_text(text.replace("</robot>", GRIPPER.format(last=last)))
    joints = LOG.model.robot.joints
    named = named_by_joints("position", LOG.position) | named_by_joints("effort", LOG.torque)
    write("log.csv", {"t": LOG.time, **named, "grip_position": 0.01 * np.sin(LOG.time)})
    require(imported("log.csv"), torque=LOG.torque)
    assert re.search(r"held fixed.*their effort: grip, follow", said(capsys))
    assert read_model("robot.toml").robot.joints == joints


def log_with_a_joint_at_rest(name, turn=0.0):
    """The second joint stands at 40 degrees, or turns away from there by so much [deg]."""
    position = np.degrees(LOG.position)
    position[:, 1] = 40.0 + turn * LOG.time / LOG.time[-1]
    velocity = columns("dq{k}", np.degrees(LOG.velocity))
    write(name, PLAIN | columns("q{k}", position) | velocity)


def test_a_joint_that_never_moves_is_held_where_it_stands(capsys):
    log_with_a_joint_at_rest("rest.csv")
    run = imported("rest.csv")
    second, *others = np.roll(LOG.model.robot.joints, -1).tolist()
    assert f"* {second} does not move: the model holds it at 0.6981 rad" in capsys.readouterr().out
    assert sorted(run.robot.joints) == sorted(others)
    kept = [LOG.model.robot.joints.index(joint) for joint in run.robot.joints]
    require(run, (slice(None), kept), current=LOG.current)
    log_with_a_joint_at_rest("moved.csv", turn=5.0)
    error = refused(capsys, "import", "moved.csv", "--robot", "robot.toml")
    assert "column q2 goes from 40.00 to 45.00, but its joint is held between 39.94 and 40.06" in error
    init("rest.csv", "moved.csv", "--force")
    assert read_model("robot.toml").robot.joints == LOG.model.robot.joints


def test_a_log_of_joints_that_turn_and_slide_is_imported_as_proposed():
    slide = '<link name="floor"/><joint name="lift" type="prismatic"><parent link="floor"/>'
    slide += '<child link="{first}"/><axis xyz="0 0 1"/></joint>'
    text = urdf_text(LOG.model)
    first = re.findall(r'link name="(\w+)"', text)[0]
    Path("arm.urdf").write_text(text.replace("<link", slide.format(first=first) + "<link", 1))
    joints = ("lift", *LOG.model.robot.joints)
    height = 0.2 * np.sin(LOG.time)
    position = np.column_stack([height, np.degrees(LOG.position)])
    effort = np.column_stack([300.0 + np.cos(LOG.time), LOG.current])
    named = named_by_joints("position", position, joints) | named_by_joints("current", effort, joints)
    write("log.csv", {"t": LOG.time, **named})
    require(imported("log.csv"), position=np.column_stack([height, LOG.position]))
    assert 'unit = ["m", "deg", "deg"' in Path("preset.toml").read_text()


def test_efforts_that_are_not_measured_give_no_gain(capsys):
    silent = 0.001 * (np.random.default_rng(1).random(len(LOG.time)) > 0.9)
    named = named_by_joints("position", LOG.position) | named_by_joints("current", LOG.current)
    write("mute.csv", {"t": LOG.time, **named, "joint3_current": silent})
    run = imported("mute.csv")
    assert re.search(r"not measured: joint3 in [89]\d %", said(capsys))
    known, _ = known_gains(json.loads(Path("found.json").read_text()))
    assert known[1:3].tolist() == [True, False]
    [warning] = run.warnings
    assert "as if they were not measured: joint3 in " in warning


def write_runs(first=slice(0, 990), second=slice(990, None)):
    """Rows of the log as two runs, the time of each from zero."""
    head, *rows = Path("log.csv").read_text().splitlines()
    for name, which in (("a.csv", first), ("b.csv", second)):
        cells = [row.split(",", 1) for row in rows[which]]
        lines = [f"{float(time) - float(cells[0][0]):.9g},{rest}" for time, rest in cells]
        Path(name).write_text("\n".join([head, *lines]))


def test_several_logs_are_weighed_together(capsys):
    write_runs()
    whole, both = init("log.csv"), init("a.csv", "b.csv", "--force")
    assert "s in 2 runs" in said(capsys)
    assert [guess["value"] for guess in both["guesses"]][:5] == [
        guess["value"] for guess in whole["guesses"]
    ][:5]
    assert both["then"] == "exidyn import a.csv --robot robot.toml"
    write_runs(slice(0, None, 5), slice(0, 150))  # most samples are of the slow one
    for logs in (["a.csv", "b.csv"], ["b.csv", "a.csv"]):
        init(*logs, "--force")
        text = said(capsys)
        assert "s in 2 runs" in text
        assert all(f"next: exidyn import {log} --robot robot.toml" in text for log in logs)


def test_logs_with_other_columns_are_refused(capsys):
    write_runs()
    Path("b.csv").write_text(Path("b.csv").read_text().replace("A1_Strom", "A1_Drehmoment"))
    error = refused(capsys, "init", "a.csv", "b.csv", "--robot", "arm.urdf")
    assert "b.csv has other columns than a.csv: A1_Drehmoment, A1_Strom" in error
    assert not Path("robot.toml").exists()


def test_a_preset_with_a_number_for_its_ranges_is_refused(capsys):
    init("log.csv")
    Path("preset.toml").write_text("still = 3\n" + Path("preset.toml").read_text())
    error = refused(capsys, "import", "log.csv", "--robot", "robot.toml")
    assert "[still] is 3; expected a table of COLUMN = [LOWEST, HIGHEST]" in error


@pytest.mark.parametrize(
    ("column", "outcome"), [("Temperatur_A2", "leaves the column out"), ("A2_Winkel", "refuses that")]
)
def test_text_in_a_column_is_said(capsys, column, outcome):
    head, *lines = Path("log.csv").read_text().splitlines()
    names = [*head.split(","), *(f"Temperatur_A{k + 1}" for k in range(DOF))]
    rows = [line.split(",") + ["30"] * DOF for line in lines]
    rows[40][names.index(column)] = "err"
    Path("log.csv").write_text("\n".join(",".join(row) for row in [names, *rows]) + "\n")
    proposal = init("log.csv")
    text = said(capsys)
    assert f"log.csv line 42: 'err' in column '{column}' is not a number: import {outcome}" in text
    code = main(["import", "log.csv", "--robot", "robot.toml"])
    if outcome == "refuses that":
        assert code == REFUSED
        assert "correct the cell, or empty it if nothing was measured" in text
        assert "next:" not in text
        assert proposal["refusal"]
    else:
        assert code == 0


def test_the_hint_for_a_log_of_fewer_joints_leads_on(capsys):
    """What the error about numbered columns of some joints advises is what works."""
    write("part.csv", {name: PLAIN[name] for name in ("t", "q1", "q2", "i1", "i2")})
    error = refused(capsys, "init", "part.csv", "--robot", "arm.urdf")
    assert "name the 2 in a robot.toml (urdf = ..., joints = [...])" in error
    joints = json.dumps(list(LOG.model.robot.joints[:2]))
    Path("two.toml").write_text(f'format = 1\nurdf = "arm.urdf"\njoints = {joints}\n')
    assert main(["init", "part.csv", "--robot", "two.toml", "-o", "made.toml"]) == 0


def test_columns_of_all_joints_stand_for_joints_with_other_names():
    words = [f"axle{'abcdef'[k]}" for k in range(DOF - 1)] + [LOG.model.robot.joints[-1]]
    named = {"t": LOG.time}
    for prefix, values in (("q", LOG.position), ("i", LOG.current)):
        named |= {f"{prefix}_{word}": column for word, column in zip(words, values.T, strict=True)}
    write("words.csv", named)
    letters = {"position": "q", "current": "i"}
    chosen = [f"{signal}={','.join(f'{letters[signal]}_{word}' for word in words)}" for signal in letters]
    init("words.csv", "--columns", *chosen)
    assert read_model("robot.toml").robot.joints == LOG.model.robot.joints


def test_a_row_of_units_and_decimal_commas():
    named = {"Time": 1e3 * LOG.time, **columns("J{k} Position", np.degrees(LOG.position))}
    named |= columns("J{k} Current", 1e3 * LOG.current)
    write("log.csv", named, [";".join(["ms", *DOF * ["deg"], *DOF * ["mA"]])], ";")
    run = imported("log.csv")
    require(run, current=LOG.current)
    assert run.signals["position"].time[-1] == pytest.approx(LOG.time[-1])
    decided, stated = known_gains(json.loads(Path("found.json").read_text()))
    ratio = stated[decided] / LOG.model.robot.drive_gain[decided]
    assert np.all(np.abs(np.log(ratio)) < 0.7)  # N m/A, not N m/mA


def test_torques_of_another_unit_that_are_no_torques_of_joints_keep_their_gains():
    named = {"t": LOG.time, **columns("q{k}", LOG.position), **columns("tau{k} [mNm]", 1e3 * LOG.current)}
    write("log.csv", named)
    run = imported("log.csv")
    decided, stated = known_gains(json.loads(Path("found.json").read_text()))
    torque = np.abs(run.signals["current"].values * stated).mean(axis=0)
    true = np.abs(LOG.current * LOG.model.robot.drive_gain).mean(axis=0)
    assert np.all(np.abs(np.log(torque[decided] / true[decided])) < 0.7)


def test_missing_numbers_and_rows():
    current = np.where((LOG.time > 2) & (LOG.time < 2.05), np.nan, PLAIN["i3"])
    empty = np.arange(len(LOG.time)) == 700
    cells = (PLAIN | {"i3": current}).items()
    write("log.csv", {n: column if n == "t" else np.where(empty, np.nan, column) for n, column in cells})
    run = imported("log.csv")
    lost = np.flatnonzero(np.isnan(current) | empty)
    np.testing.assert_allclose(run.signals["current"].values, np.delete(LOG.current, lost, axis=0), atol=1e-6)
    assert f"these {len(lost) - 1} rows are left out" in " ".join(run.warnings)


@pytest.mark.parametrize(("measured", "silent"), [("i", "tau"), ("tau", "i")])
def test_an_effort_of_zeros_beside_another_is_left_out(measured, silent):
    values = {"i": LOG.current, "tau": LOG.torque}[measured]
    named = columns(f"{measured}{{k}}", values) | columns(f"{silent}{{k}}", 0.0 * values)
    write("log.csv", {"t": LOG.time, **columns("q{k}", LOG.position), **named})
    run = imported("log.csv")
    assert ({"torque", "current"} & set(run.signals)) == {"torque" if measured == "tau" else "current"}


@pytest.mark.parametrize("options", [["--degrees"], ["--units", "position=deg", "time=ms"]])
def test_units_that_are_stated_are_not_guessed(options):
    proposal = init("log.csv", *options)
    guess = next(guess for guess in proposal["guesses"] if guess["what"] == "unit of position")
    assert (guess["value"], guess["why"], guess["probability"]) == ("deg", "as stated", 1.0)
    assert main(shlex.split(proposal["then"])[1:]) == 0
    require(read_recording("log.mcap"), current=LOG.current)


def test_gains_belong_to_currents_in_the_stated_unit():
    write("log.csv", PLAIN | columns("i{k}", 1e3 * LOG.current))
    run = imported("log.csv", "--units", "current=mA")
    require(run, current=LOG.current)
    decided, stated = known_gains(json.loads(Path("found.json").read_text()))
    assert decided.any()
    assert np.all(np.abs(np.log(stated / LOG.model.robot.drive_gain))[decided] < 0.7)


def test_a_unit_of_no_signal_and_options_of_tables_are_refused(capsys):
    error = refused(capsys, "init", "log.csv", "--robot", "arm.urdf", "--units", "temperature=K")
    assert "the log has no temperature; it has position, current" in error
    signals = {"position": Signal(LOG.time, LOG.position), "torque": Signal(LOG.time, LOG.torque)}
    write_recording(Recording("run", LOG.model, signals), "run.mcap")
    error = refused(capsys, "init", "run.mcap", "--robot", "arm.urdf", "--degrees")
    assert "--degrees is for tables" in error


def test_identify_reads_a_table_in_degrees():
    write("log.csv", PLAIN | columns("q{k}", np.degrees(LOG.position)))
    assert main(["identify", "log.csv", "--robot", "arm.urdf", "--degrees", "--as-recorded"]) == 0


def test_columns_may_be_named(capsys):
    named = {
        "a": 1e3 * LOG.time,
        **columns("x{k}", np.degrees(LOG.position)),
        **columns("q{k}", LOG.velocity),
    }
    write("log.csv", named | columns("i{k}", LOG.current))
    run = imported("log.csv", "--columns", "time=a", f"position=x1..{DOF}", "velocity=q{number}")
    require(run, current=LOG.current, velocity=LOG.velocity)
    assert "order of joints" not in said(capsys)
    chosen = ("--force", "--columns", f"position=y1..{DOF}")
    assert "no column y1, y2" in refused(capsys, "init", "log.csv", "--robot", "arm.urdf", *chosen)


def test_a_gripper_behind_the_joints_is_left_out_and_of_two_arms_one_is_named(capsys):
    share = 0.5 + 0.5 * np.sin(LOG.time)[:, None]
    arms = {"obs/qpos": LOG.position, "obs/effort": LOG.torque}
    np.savez("one.npz", **{name: np.hstack([values, share]) for name, values in arms.items()})
    require(imported("one.npz", "--rate", "100"), torque=LOG.torque)
    assert f"obs/qpos{DOF + 1} stays between 0 and full scale like a gripper" in said(capsys)
    both = {name: np.hstack([values[::-1], share, values, share]) for name, values in arms.items()}
    np.savez("two.npz", **both)
    error = refused(capsys, "init", "two.npz", "--robot", "arm.urdf", "--rate", "100", "--force")
    assert (
        "obs/qpos has 10 columns for 4 joints (joint1 to joint4): which? For example 1 to 4, or 6 to 9"
        in error
    )
    run = imported("two.npz", "--rate", "100", "--force", "--columns", "position=obs/qpos6..9")
    require(run, torque=LOG.torque)
