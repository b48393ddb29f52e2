"""Tables, made up and real."""

import numpy as np
import pytest

from exidyn.identification.errors import BadTime, BadUnit, NotAFile, NotFinite, RecordingError, WrongShape
from exidyn.identification.recordings.importers import import_source

from ...parts.runs.runs import TIME, model, motion, noise, require, table


@pytest.mark.parametrize(
    ("name", "separator"), [("run.csv", ","), ("run.csv.gz", ","), ("run.csv", ";"), ("run.tsv", "\t")]
)
def test_a_table_with_usual_names(tmp_path, name, separator):
    header = separator.join("t q1 q2 dq1 dq2 i1 i2 tau1 tau2 temp1 temp2 ql1 ql2 q_ref1 q_ref2".split())
    columns = [motion(), noise(seed=1), noise(seed=2), noise(seed=3), 40 + noise(), motion(), motion()]
    [found] = import_source(table(tmp_path / name, header, *columns, separator=separator), model())
    names = ("position", "velocity", "current", "torque", "temperature", "link_position", "command")
    assert found.name == "run"
    assert set(found.signals) == set(names)
    for signal, values in zip(names, columns, strict=True):
        assert np.array_equal(found.signals[signal].values, values), signal
        assert np.array_equal(found.signals[signal].time, np.rint(TIME * 1e9) / 1e9)


@pytest.mark.parametrize(
    "header",
    ["time,q_axis1,q_axis2,i_axis1,i_axis2", "t,axis1_position,axis2_position,axis1/current,axis2/current"],
)
def test_a_table_named_by_joint(tmp_path, header):
    [found] = import_source(table(tmp_path / "run.csv", header, motion(), noise()), model())
    require(found, position=motion(), current=noise())


def test_a_table_with_mapped_names(tmp_path):
    path = table(
        tmp_path / "run.csv", "ms,A1,A2,J_axis1_amps,J_axis2_amps", motion(), noise(), time=TIME * 1000
    )
    columns = {"time": "ms", "position": ["A1", "A2"], "current": "J_{joint}_amps"}
    [found] = import_source(path, model(), columns=columns, units={"time": "ms"})
    require(found, current=noise())
    np.testing.assert_allclose(found.signals["current"].time, TIME, atol=1e-9)


def test_degrees_and_motor_side_become_the_joint(tmp_path):
    gears = np.array([100.0, -50.0])
    header = "t,q1,q2,tau1,tau2"
    path = table(tmp_path / "run.csv", header, np.degrees(motion()) * gears, noise() / gears)
    [found] = import_source(path, model(gear_ratio=gears), degrees=True, motor_side=True)
    require(found, position=motion(), torque=noise(), atol=1e-12)
    path = table(tmp_path / "run.csv", header, motion(), noise() / gears)
    [found] = import_source(path, model(gear_ratio=gears), motor_side=["torque"])
    require(found, position=motion())
    require(found, torque=noise(), atol=1e-12)


def test_rows_are_skipped_and_stamps_begin_at_zero(tmp_path):
    time = 1_000.0 + TIME + np.random.default_rng(0).uniform(0, 0.001, len(TIME))
    position = 0.5 * np.sin(np.outer(time, [3.0, 4.0]))
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2", position, noise(), time=time)
    [found] = import_source(path, model())
    require(found, time=time - time[0], atol=1e-9)
    assert float(found.settings["first_time_stamp_s"]) == time[0]
    time = TIME.copy()
    time[0] = 3000.0
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2", motion(), noise(), time=time)
    with pytest.raises(BadTime, match="skip_rows"):
        import_source(path, model())
    [found] = import_source(path, model(), skip_rows=1)
    assert len(found.signals["position"]) == len(TIME) - 1


def test_samples_and_joints_that_are_silent_stay_silent(tmp_path):
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2,ql1", motion(), noise(), motion()[:, 0])
    [found] = import_source(path, model())
    assert np.array_equal(found.signals["link_position"].values[:, 0], motion()[:, 0])
    assert np.isnan(found.signals["link_position"].values[:, 1]).all()
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2,temp1,temp2", motion(), noise(), 40 + noise())
    lines = path.read_text().splitlines()
    lines[2:] = [",".join(line.split(",")[:5]) + ",," for line in lines[2:]]
    path.write_text("\n".join(lines))
    [found] = import_source(path, model())
    assert len(found.signals["temperature"]) == 1
    require(found, position=motion())


@pytest.mark.parametrize(
    ("content", "error", "message"),
    [
        ("", NotAFile, "is empty"),
        ("t,q1,q2,i1,i2\n", NotAFile, "has no samples"),
        ("t,q1,i1,i2\n0,0,0,0\n", WrongShape, "no column q2 for position. Columns: t, q1, i1, i2"),
        ("x,q1,q2,i1,i2\n0,0,0,0,0\n", WrongShape, "no column of time"),
        ("t,q1,q2\n0,0,0\n1,1,1\n", WrongShape, "needs position and one of current, torque"),
        ("t,q1,q2,i1,i2\n0,0,0,0,0\n\n.2,,0,0,0\n", NotFinite, "no number for axis1 in 1 of 2 rows"),
        ("t,q1,q2,i1,i2\n0,0,0,0,0\n,0,0,0,0\n", NotFinite, "line 3: no time stamp in column t, as in"),
        ("t,q1,q2,i1,i2\n0,0,0,0,0\n1,0,0\n", WrongShape, "run.csv line 3: 3 cells for 5 names in line 1$"),
        ("t,q1,q2,i1,i2\n0,0,0,0,0\n1,on,0,0,0\n", WrongShape, "line 3: 'on' in column 'q1' is not a number"),
        ("t,q1,q2,i1,i2\n0,0,1,5,0,1,0,1\n", WrongShape, "8 cells .*decimal comma need semicolons"),
        ("t,q1,q2,i1,i2\n\n0,0,0,0,0\n", NotAFile, "has one sample, in line 3"),
        ("t,q1,q2,q3,i1,i2,i3\n0,0,0,0,0,0,0\n", WrongShape, r"which\? .* position=q1..2, or position=q2..3"),
        ("t,q1,q2,i1,i2\n0,0,0,0,0\n0.002,90,0,1,1\n", BadUnit, "looks like degrees"),
    ],
)
def test_a_bad_table_reports_what_is_wrong(tmp_path, content, error, message):
    (tmp_path / "run.csv").write_text(content)
    with pytest.raises(error, match=message):
        import_source(tmp_path / "run.csv", model())


def test_decimal_commas_between_semicolons(tmp_path):
    path = table(tmp_path / "run.csv", "t;q1;q2;i1;i2", motion(), noise(), separator=";")
    path.write_text(path.read_text().replace(".", ","))
    [found] = import_source(path, model())
    require(found, position=motion(), current=noise())


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_a_table_without_names(tmp_path, separator):
    path = tmp_path / "run.txt"
    np.savetxt(path, np.column_stack([TIME, motion(), noise()]), "%.17g", separator)
    columns = {"time": "1", "position": ["2", "3"], "current": ["4", "5"]}
    [found] = import_source(path, model(), columns=columns)
    require(found, position=motion(), current=noise())
    with pytest.raises(WrongShape, match="no column of time .* among 1, 2, 3, 4, 5; name it"):
        import_source(path, model())


def test_text_in_a_column_that_no_signal_uses_is_left_out(tmp_path):
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2,state", motion(), noise(), TIME)
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], *(f"{line.rpartition(',')[0]},running" for line in lines[1:])]))
    [found] = import_source(path, model())
    require(found, current=noise())
    with pytest.raises(WrongShape, match="line 2: 'running' in column 'state' is not a number"):
        import_source(path, model(), columns={"time": "state"})


def test_a_table_cut_off_in_the_middle_of_its_compression(tmp_path):
    path = table(tmp_path / "run.csv.gz", "t,q1,q2,i1,i2", motion(), noise())
    path.write_bytes(path.read_bytes()[:500])
    with pytest.raises(NotAFile, match="cannot be read as a table"):
        import_source(path, model())


def test_bad_maps_are_refused(tmp_path):
    path = table(tmp_path / "run.csv", "t,q1,q2,i1,i2", motion(), noise())
    with pytest.raises(WrongShape, match="columns.*: unknown amps. Valid: time, position"):
        import_source(path, model(), columns={"amps": "i{number}"})
    with pytest.raises(WrongShape, match="position has 1 columns, small 2 joints"):
        import_source(path, model(), columns={"position": ["q1"]})
    with pytest.raises(WrongShape, match="no column amps1, amps2 for current"):
        import_source(path, model(), columns={"current": "amps{number}"})
    with pytest.raises(RecordingError, match="give the robot too"):
        import_source(path)
