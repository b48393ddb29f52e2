"""Runs that follow each other in one file, and what is said of time that does not go on."""

import numpy as np
import pytest

from exidyn.identification.errors import BadTime
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.time_order import Remedy, advice, steps_back

from ...parts.runs.runs import TIME, model, motion, noise, require, table

HEADER = "t,q1,q2,i1,i2"


def file(folder, *times, between=""):
    """A table of runs with these times, with a line between them, and its path."""
    lines = [HEADER]
    for number, time in enumerate(times):
        rows = np.column_stack([time, motion() + number, noise()])[:: 1 - 2 * (number % 2)]
        rows[:, 0] = time
        lines += [between] * bool(number and between) + [",".join(map(repr, row)) for row in rows.tolist()]
    path = folder / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("start", "between", "words"),
    [
        (0.0, "", "time begins anew at line 202"),
        (0.0, HEADER, "time begins anew at line 202"),
        (-1e6, "", "time begins anew at line 202"),
        (300.0, "", "299 s are missing at line 202"),
        (TIME[-1] + 0.004, HEADER, "the names of the columns stand again at line 202"),
    ],
)
def test_each_run_is_a_recording(tmp_path, start, between, words):
    runs = import_source(file(tmp_path, TIME, start + TIME, between=between), model())
    assert [run.name for run in runs] == ["log_1", "log_2"]
    for number, run in enumerate(runs, 1):
        assert f"{words}: this is run {number} of 2 in the file" in run.warnings
        require(run, time=TIME, atol=1e-9)
        np.testing.assert_allclose(
            np.sort(run.signals["position"].values - number + 1, 0), np.sort(motion(), 0)
        )


def test_a_recorder_may_begin_several_times_or_once(tmp_path):
    runs = import_source(file(tmp_path, TIME, TIME, TIME), model())
    assert [run.name for run in runs] == ["log_1", "log_2", "log_3"]
    assert "time begins anew at line 202; time begins anew at line 402" in runs[0].warnings[0]
    [run] = import_source(table(tmp_path / "log.csv", HEADER, motion(), noise()), model())
    assert (run.name, run.warnings) == ("log", ())


STAMPS = 0.004 * np.arange(1000)
MOTION = np.column_stack([np.sin(3 * STAMPS), np.cos(2 * STAMPS)])


def mixed(every):
    """Rows of zeros of another source behind each so many, at the time of the row before."""
    places = np.arange(every, 1000, every)
    return np.insert(STAMPS, places, STAMPS[places - 1]), np.insert(MOTION, places, 0.0, axis=0)


@pytest.mark.parametrize("every", [1, 2, 3, 10])
def test_two_sources_are_told_by_values_that_jump_away_and_back(every):
    assert advice(*mixed(every)).startswith("Rows of two sources seem mixed")


def test_advice_by_what_the_stamps_show():
    time, values = mixed(1)
    time[1::2] += 5.0
    assert advice(time, values).startswith("Rows of two sources")
    time = STAMPS.copy()
    time[7::7] = time[6::7][: len(time[7::7])]
    assert len(steps_back(time)) == 142
    assert advice(time, MOTION).startswith("Leave out the 142 rows")  # sorted, they would repeat too
    assert advice(np.tile(STAMPS, 2), np.concatenate([MOTION, MOTION[::-1]])) == Remedy.CUT.value
    assert (
        advice(np.tile(STAMPS, 5), np.tile(MOTION, (5, 1)) + np.repeat(np.arange(5), 1000)[:, None])
        == Remedy.CUT.value
    )
    time = STAMPS.copy()
    time[0] = 3.0
    assert advice(time[1:], MOTION[1:]) == Remedy.SORT.value
    time[:3] = 0.0
    assert advice(time, MOTION).startswith("Leave out the first 2 rows")
    assert advice(0.0 * STAMPS, MOTION) == Remedy.ALL_EQUAL.value


def test_import_says_so_of_a_table(tmp_path):
    """Rows of zeros without effort behind every second one, as of a publisher that knows no arm."""
    rows = []
    for k, row in enumerate(np.column_stack([TIME, motion(), noise()])):
        rows += [row, [row[0], 0.0, 0.0, np.nan, np.nan]] if k % 2 else [row]
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", header="t,q1,q2,i1,i2", comments="")
    with pytest.raises(BadTime, match="does not increase at 100 of 299 steps, .*two sources seem mixed"):
        import_source(tmp_path / "run.csv", model())
