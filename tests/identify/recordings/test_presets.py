"""Presets: columns, units and signs of a kind of log, shipped ones and those beside a log."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exidyn.identification.errors import BadUnit, RecordingError, RobotError, WrongShape
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.tables.preset import preset_names, read_preset

from ...parts.runs.runs import TIME, model, motion, noise, require, table


def write_rtde(path: Path, joints: int, **fields) -> Path:
    """As CSVWriter of UR's RTDE client writes it: a vector's fields numbered, spaces between columns."""
    header, columns = ["timestamp"], [TIME + 5000.0]
    for name, values in fields.items():
        header += [f"{name}_{k}" for k in range(joints)]
        columns += list(values.T)
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, delimiter=" ")
        writer.writerow([*header, "runtime_state", "output_bit_register0_to_31"])
        writer.writerows([*row, 2, True] for row in np.column_stack(columns).tolist())
    return path


def write_libfranka(path: Path) -> Path:
    """As logToCSV of libfranka writes it; time in milliseconds."""
    states = {"q": motion(7), "q_d": motion(7), "dq": noise(7, 1), "dq_d": noise(7, 2), "tau_J": noise(7)}
    states["tau_ext_hat_filtered"] = noise(7, 3)
    fields = [f"state.{name}[{k}]" for name in states for k in range(7)]
    fields += [f"cmd.q_d[{k}]" for k in range(7)] + [f"cmd.O_T_EE_d[{k}]" for k in range(16)]
    columns = [np.ones(len(TIME)), *states.values(), np.zeros((len(TIME), 23))]
    return table(path, ",".join(["time", "success_rate", *fields]), *columns, time=np.rint(1e3 * TIME))


def test_a_log_of_universal_robots(tmp_path):
    fields = {"actual_q": motion(6), "actual_qd": noise(6, 1), "actual_current": noise(6, 2)}
    path = write_rtde(tmp_path / "robot_data.csv", 6, **fields, target_q=motion(6), target_moment=noise(6))
    [found] = import_source(path, model(6))
    assert set(found.signals) == {"position", "velocity", "current", "command"}
    for name, values in zip(("position", "velocity", "current"), fields.values(), strict=True):
        assert np.array_equal(found.signals[name].values, values)
    require(found, time=TIME, atol=1e-9)
    assert found.settings["preset"] == "ur_rtde"


def test_a_log_of_libfranka(tmp_path):
    [found] = import_source(write_libfranka(tmp_path / "log.csv"), model(7))
    assert set(found.signals) == {"position", "velocity", "torque", "command", "command_velocity"}
    require(found, torque=noise(7), command_velocity=noise(7, 2))
    require(found, time=TIME, atol=1e-9)
    assert found.settings["preset"] == "libfranka"


def test_columns_that_are_named_are_no_preset(tmp_path):
    path = table(tmp_path / "run.csv", "clock,a1,a2,b1,b2", motion(), noise())
    columns = {"time": "clock", "position": "a", "torque": "b"}
    [found] = import_source(path, model(), columns=columns)
    assert "preset" not in found.settings
    with pytest.raises(WrongShape, match=r"run.csv \(preset lerobot\): no column observation.state1, obs"):
        import_source(path, model(), columns={"time": "clock"}, preset="lerobot")


def test_columns_that_are_named_take_precedence(tmp_path):
    path = write_rtde(tmp_path / "log.csv", 6, actual_q=motion(6), target_current=noise(6))
    columns = {"current": "target_current_{index}", "position": ["actual_q_1", "actual_q_0"]}
    columns["current"] = ["target_current_0", "target_current_1"]
    [found] = import_source(path, model(), columns=columns)
    require(found, position=motion(6)[:, 1::-1], current=noise(6)[:, :2])


PAGE = Path(__file__).parents[3] / "docs" / "import.md"
OWN = """
[time]
column = "Zeit"
unit = "ms"

[position]
column = ["A1", "A2"]
unit = "°"
sign = [1, -1]

[effort]
column = "M_{joint}"
unit = "mA"
sign = -1

[temperature]
column = "T{number}"
unit = "K"
"""


@pytest.fixture
def log(tmp_path):
    header = "Zeit;A1;A2;M_axis1;M_axis2;T1;T2;state"
    columns = [np.degrees(motion()), noise(), 300 + noise(seed=1), np.zeros(len(TIME))]
    path = table(tmp_path / "log.csv", header, *columns, separator=";", time=1e3 * TIME)
    header, *rows = path.read_text().split()
    path.write_text("\n".join([header, *(f"{row[:-3]}run" for row in rows)]))
    return path


@pytest.mark.parametrize("beside", [True, False])
def test_an_own_preset(log, tmp_path, beside):
    name = "preset.toml" if beside else "ours.toml"
    (tmp_path / name).write_text(OWN)
    given = {} if beside else {"preset": tmp_path / name}
    [found] = import_source(log, model(), effort="current", **given)
    require(found, position=motion() * [1, -1], atol=1e-12)
    require(found, current=-1e-3 * noise(), atol=1e-15)
    require(found, temperature=26.85 + noise(seed=1), atol=1e-12)
    require(found, time=TIME, atol=1e-9)
    assert found.settings["preset"] == str(tmp_path / name)


def test_effort_is_torque_unless_it_is_said_to_be_current(log, tmp_path):
    (tmp_path / "preset.toml").write_text(OWN.replace('"mA"', '"N m"'))
    [found] = import_source(log, model())
    require(found, torque=-noise())
    with pytest.raises(BadUnit, match="current: unit 'N m'; valid: A, mA"):
        import_source(log, model(), effort="current")
    with pytest.raises(RecordingError, match="'power': valid are current, torque"):
        import_source(log, model(), effort="power")


def test_a_log_without_time_has_a_rate(tmp_path):
    np.savez(tmp_path / "run.npz", q=motion(), tau=noise())
    (tmp_path / "preset.toml").write_text("rate = 250")
    [found] = import_source(tmp_path / "run.npz", model())
    np.testing.assert_allclose(found.signals["torque"].time, TIME, atol=1e-9)
    np.savez(tmp_path / "run.npz", q=motion(), tau=noise())
    [found] = import_source(tmp_path / "run.npz", model(), rate=250)
    np.testing.assert_allclose(found.signals["torque"].time, TIME, atol=1e-9)
    np.savez(tmp_path / "timed.npz", time=TIME, q=motion(), tau=noise())
    with pytest.raises(RecordingError, match="has its own time, column time; --rate"):
        import_source(tmp_path / "timed.npz", model(), rate=250)
    with pytest.raises(RecordingError, match="has its own time, column q1; --rate"):
        import_source(tmp_path / "run.npz", model(), rate=250, columns={"time": "q1"})


def test_a_preset_has_scale_zero_and_unit_of_each_joint(tmp_path):
    counts = np.column_stack([motion()[:, 0] * 4096 / (2 * np.pi) + 2048, np.degrees(motion()[:, 1]) * -2.0])
    path = table(
        tmp_path / "log.csv", "t,q1,q2,tau1,tau2,q_ref1,q_ref2", counts, noise(), counts + [1.0, 2.0]
    )
    (tmp_path / "preset.toml").write_text(
        '[position]\ncolumn = "q"\nunit = ["turn", "deg"]\nzero = [2048, 0]\nscale = [2.44140625e-4, 0.5]\n'
        "sign = [1, -1]\n"
    )
    [found] = import_source(path, model())
    expected = motion()
    require(found, position=expected, atol=1e-9)
    apart = found.signals["command"].values - expected  # commands have the units of positions
    np.testing.assert_allclose(
        apart, np.tile([2 * np.pi / 4096, -np.radians(1.0)], (len(TIME), 1)), atol=1e-9
    )


def test_a_preset_of_units_alone_applies_them_to_the_usual_columns(tmp_path):
    path = table(tmp_path / "log.csv", "t,q1,q2,i1,i2,tau1,tau2", np.degrees(motion()), noise(), noise(2, 1))
    (tmp_path / "preset.toml").write_text('[position]\nunit = "deg"\n[current]\nunit = "mA"\n')
    [found] = import_source(path, model())
    require(found, position=motion(), current=1e-3 * noise(), atol=1e-12)
    assert "torque" not in found.signals  # the preset states that efforts are currents


def test_efforts_that_were_not_measured_are_left_out_beside_others(tmp_path):
    path = table(tmp_path / "log.csv", "t,q1,q2,i1,i2,tau1,tau2", motion(), noise(), 0.0 * noise())
    [found] = import_source(path, model())
    assert "torque" not in found.signals
    assert any(word.startswith("torque is left out: no effort was measured") for word in found.warnings)


@pytest.mark.parametrize(
    "names", ["effort1,effort2", "axis1_effort,axis2_effort", "joint1 effort,joint2 effort"]
)
@pytest.mark.parametrize("signal", ["torque", "current"])
def test_the_option_says_what_columns_of_effort_are(tmp_path, names, signal):
    path = table(tmp_path / "log.csv", f"t,q1,q2,{names}", motion(), noise())
    [found] = import_source(path, model(), effort=signal)
    assert np.array_equal(found.signals[signal].values, noise())
    path = table(tmp_path / "log.csv", "t,q1,q2,tau1,tau2", motion(), noise())
    with pytest.raises(RecordingError, match="no columns of effort, .* name those of current by --columns"):
        import_source(path, model(), effort="current")


@pytest.mark.parametrize("word", ["cmd", "target", "goal"])
def test_words_for_commands_may_stand_before_the_joint(tmp_path, word):
    names = [f"{prefix}_axis{k}" for prefix in ("q", "tau", word) for k in (1, 2)]
    path = table(tmp_path / "log.csv", ",".join(["t", *names]), motion(), noise(), motion() + 0.1)
    [found] = import_source(path, model())
    require(found, command=motion() + 0.1, atol=0.0)


def limited(lower, upper):
    """The small arm with limits of its two joints."""
    arm = model()
    limits = replace(arm.robot.limits, position_lower=np.array(lower), position_upper=np.array(upper))
    return replace(arm, robot=replace(arm.robot, limits=limits))


@pytest.mark.parametrize("stated", ["option", "preset"])
def test_positions_in_per_cent_of_travel(tmp_path, stated):
    arm = limited([-2.0, 0.5], [3.0, 1.5])
    position = np.column_stack([0.5 + 0.5 * motion()[:, 0], 1.0 + 0.1 * motion()[:, 1]])
    share = np.column_stack([(position[:, 0] - 0.5) / 2.5, position[:, 1] - 0.5]) * 100.0
    path = table(tmp_path / "log.csv", "t,q1,q2,tau1,tau2,q_ref1,q_ref2", share, noise(), share)
    options = {"units": {"position": ["%", "0-100%"]}}
    if stated == "preset":
        (tmp_path / "preset.toml").write_text('[position]\ncolumn = "q"\nunit = ["%", "0-100 %"]\n')
        options = {}
    [found] = import_source(path, arm, **options)
    require(found, position=position, command=position, atol=1e-9)
    endless = limited([-2.0, -np.inf], [3.0, np.inf])
    with pytest.raises(
        BadUnit, match="of joint 2 is a share of its travel, and the robot's description states"
    ):
        import_source(path, endless, **options)


@pytest.mark.parametrize(
    ("changed", "error", "message"),
    [
        (("[effort]", "[power]"), RobotError, "unknown key 'power'. Valid keys: command, .*effort"),
        (('unit = "K"', 'units = "K"'), RobotError, r"\[temperature\]: unknown key 'units'. Valid keys: col"),
        (('"°"', '"inch"'), BadUnit, "position: unit 'inch'; valid: rad, mrad, deg, turn, %, 0-100%"),
        (('"°"', '["°", "mm"]'), BadUnit, "position: unit 'mm'; valid: rad, mrad, deg"),
        (('"°"', '["°"]'), WrongShape, "position: 1 units, but there are 2 joints"),
        (('"ms"', '"min"'), BadUnit, "time: unit 'min'; valid: s, ms, us, ns"),
        (("[1, -1]", "[1, 2]"), RobotError, r"\[position\] sign: expected 1 or -1, or .*; found \[1.0, 2"),
        (("[1, -1]", "[1, -1, 1]"), WrongShape, "position: 3 values of sign for 2 joints"),
        (("T{number}", "Temp{number}"), WrongShape, "no column Temp1, Temp2 for temperature. Columns: Zeit"),
        (('"Zeit"', '"state"'), WrongShape, "line 2: 'run' in column 'state' is not a number"),
        (("[time]", "rate = 0.5\n[time]"), RobotError, "give it or .time., not both"),
        (("[time]", "[time"), RobotError, "preset.toml: not TOML"),
        (('"Zeit"', "3"), RobotError, r"\[time\] column: expected text in quotes or list; found 3"),
    ],
)
def test_a_wrong_preset_is_refused_in_one_line(log, tmp_path, changed, error, message):
    assert changed[0] in OWN
    (tmp_path / "preset.toml").write_text(OWN.replace(*changed))
    with pytest.raises(error, match=message):
        import_source(log, model(), effort="current")


def test_a_preset_that_is_not_there_lists_those_that_are(log, tmp_path):
    with pytest.raises(RobotError, match="no preset or file called 'kuka'. Presets: lerobot, libfranka, ur"):
        import_source(log, model(), preset="kuka")


def test_the_preset_of_the_page_can_be_pasted(tmp_path):
    text = PAGE.read_text(encoding="utf-8").partition("## Presets")[2].split("```toml\n")[1].split("```")[0]
    (tmp_path / "preset.toml").write_text(text, encoding="utf-8")
    header = "Zeit,A1_ist,A2_ist,I1,I2"
    numbers = np.degrees(motion()) / [1.0, 0.5] + [0.0, 12.5]
    path = table(tmp_path / "run.csv", header, numbers, 1e3 * noise(), time=1e3 * TIME)
    [found] = import_source(path, model())
    require(found, position=motion() * [1, -1], current=noise(), atol=1e-12)
    assert all(f"`{name}`" in PAGE.read_text(encoding="utf-8") for name in preset_names())


@pytest.mark.parametrize("name", preset_names())
def test_every_preset_names_time_position_and_effort(name):
    preset = read_preset(name)
    assert {"time", "position"} <= set(preset.signals)
    assert {"torque", "current", "effort"} & set(preset.signals)
    for signal in set(preset.signals) - {"time"}:
        assert "{number}" in preset.signals[signal].column or "{index}" in preset.signals[signal].column
