"""One damaged value in a signal that is not needed loses its column, and not the run."""

import numpy as np
import pytest

from exidyn.identification.errors import ExidynError
from exidyn.identification.recordings.importers import import_source

from ...parts.runs.runs import TIME, model, motion, noise

HEAD = "t,q1,q2,i1,i2,temp1,temp2,dq1,dq2"


def rows():
    heat = np.full_like(motion(), 30.0)
    return np.column_stack([TIME, motion(), noise(), heat, motion()]).astype(object)


def written(path, damaged, value):
    table = rows()
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
