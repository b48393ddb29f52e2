"""A joint that is silent now and then costs samples, and a damaged value that is not needed its column."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.errors import ExidynError, NotFinite
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.incomplete_samples import without_stale
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import Signal
from exidyn.identification.recordings.recording_checks import check
from exidyn.identification.simulation.simulate import simulate

from ...parts.runs.runs import TIME, model, motion, noise
from ...parts.small import two_joints

SHARE = 0.005
"""Of samples in which a joint is silent."""


@pytest.fixture(scope="module")
def run():
    of = two_joints.model()
    motion = two_joints.trajectory(20.0).at(np.arange(0.0, 20.0, 0.002))
    return simulate(of, two_joints.true_values(of), two_joints.GAIN, motion, of)


def stale(run, seed=0):
    """The same run with holes in position and current of one joint at a time."""
    random = np.random.default_rng(seed)
    length = len(run.signals["position"])
    rows, joints = random.choice(length, int(SHARE * length), replace=False), random.integers(0, 2, length)
    signals = dict(run.signals)
    for name in ("position", "current"):
        values = np.array(signals[name].values)
        values[rows, joints[rows]] = np.nan
        signals[name] = Signal(signals[name].time, values)
    return replace(run, signals=signals), rows


def test_half_a_per_cent_of_stale_samples_does_not_change_what_is_identified(run, tmp_path):
    broken, rows = stale(run)
    write_recording(broken, tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    assert len(read.signals["position"]) == len(run.signals["position"]) - len(rows)
    assert np.isnan(broken.signals["position"].values).any()
    assert any("a joint was silent in 50 of 10000 samples (shoulder in " in d for d in read.warnings)
    whole, holed = identify([run]), identify([read])
    assert holed.base.names == whole.base.names
    apart = np.abs(holed.estimate.values - whole.estimate.values) / whole.estimate.std
    assert apart.max() < 0.5
    assert np.abs(holed.estimate.std / whole.estimate.std - 1.0).max() < 0.1


def test_temperatures_that_come_in_turn_are_joined(run):
    time = np.arange(0.0, 20.0, 0.1)
    values = np.full((len(time), 2), np.nan)
    values[::2, 0], values[1::2, 1] = 40.0 + time[::2], 50.0
    found = without_stale(replace(run, signals={**run.signals, "temperature": Signal(time, values)}))
    assert np.allclose(found.signals["temperature"].values[:-1, 0], 40.0 + time[:-1])
    assert np.array_equal(found.signals["temperature"].values[:, 1], np.full(len(time), 50.0))
    assert found.warnings == ()


def test_a_joint_that_never_answers_gives_a_warning_and_is_not_identified_from(run, tmp_path):
    values = np.array(run.signals["current"].values)
    values[:, 1] = np.nan
    write_recording(
        replace(run, signals={**run.signals, "current": Signal(run.signals["current"].time, values)}),
        tmp_path / "run.mcap",
    )
    found = read_recording(tmp_path / "run.mcap")
    assert any("current of elbow is empty" in warning for warning in found.warnings)
    with pytest.raises(NotFinite, match="current of elbow"):
        check(found)


HEAD = "t,q1,q2,i1,i2,temp1,temp2,dq1,dq2"


def usual_rows():
    heat = np.full_like(motion(), 30.0)
    return np.column_stack([TIME, motion(), noise(), heat, motion()]).astype(object)


def written(path, damaged, value):
    table = usual_rows()
    table[20, HEAD.split(",").index(damaged)] = value
    path.write_text("\n".join([HEAD, *(",".join(map(str, row)) for row in table)]) + "\n")
    return path


@pytest.mark.parametrize("value", ["err", "inf", "nan", "", "1e300"])
@pytest.mark.parametrize(("column", "signal"), [("temp2", "temperature"), ("dq2", "velocity")])
def test_a_damaged_value_loses_the_column(tmp_path, value, column, signal):
    [found] = import_source(written(tmp_path / "run.csv", column, value), model())
    values = found.signals[signal].values
    assert np.isfinite(values[:, 0]).all()
    assert np.isnan(values[:, 1]).all()
    assert len(found.signals["position"]) == len(TIME)
    [warning] = [one for one in found.warnings if "left out" in one]
    assert warning.startswith(f"{signal} of axis2 is left out: ")


def test_columns_that_were_named_are_left_out_too(tmp_path):
    path = written(tmp_path / "run.csv", "temp2", "err")
    [found] = import_source(path, model(), columns={"temperature": "temp"})
    assert any("line 22: 'err' in column 'temp2'" in one for one in found.warnings)


def test_a_signal_of_which_nothing_is_left_is_gone(tmp_path):
    path = written(tmp_path / "run.csv", "temp1", "err")
    head, *lines = path.read_text().splitlines()
    cut = [",".join(line.split(",")[:6]) for line in lines]
    path.write_text("\n".join([",".join(head.split(",")[:6]), *cut]) + "\n")
    [found] = import_source(path, model())
    assert "temperature" not in found.signals


@pytest.mark.parametrize("column", ["q2", "i1"])
def test_what_is_needed_is_refused_as_before(tmp_path, column):
    with pytest.raises(ExidynError, match=r"line 22|position of axis2|current of axis1"):
        import_source(written(tmp_path / "run.csv", column, "err"), model())


@pytest.mark.parametrize("column", ["q2", "i1"])
def test_a_row_without_a_needed_number_is_left_out(tmp_path, column):
    [run] = import_source(written(tmp_path / "run.csv", column, "inf"), model())
    assert any("left out" in warning for warning in run.warnings)
