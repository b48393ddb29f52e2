"""Runs that follow each other in one file."""

import numpy as np
import pytest

from exidyn.identification.recordings.importers import import_source

from ...parts.runs.runs import TIME, model, motion, noise, table

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
        np.testing.assert_allclose(run.signals["position"].time, TIME, atol=1e-9)
        np.testing.assert_allclose(
            np.sort(run.signals["position"].values - number + 1, 0), np.sort(motion(), 0)
        )


def test_a_recorder_may_begin_several_times_or_once(tmp_path):
    runs = import_source(file(tmp_path, TIME, TIME, TIME), model())
    assert [run.name for run in runs] == ["log_1", "log_2", "log_3"]
    assert "time begins anew at line 202; time begins anew at line 402" in runs[0].warnings[0]
    [run] = import_source(table(tmp_path / "log.csv", HEADER, motion(), noise()), model())
    assert (run.name, run.warnings) == ("log", ())
