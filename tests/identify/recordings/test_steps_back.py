"""What is said of time that does not go on."""

import numpy as np
import pytest

from exidyn.identification.errors import BadTime
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.time_order import Remedy, advice, steps_back

from ...parts.runs.runs import TIME as RUN_TIME
from ...parts.runs.runs import model, motion, noise

TIME = 0.004 * np.arange(1000)
MOTION = np.column_stack([np.sin(3 * TIME), np.cos(2 * TIME)])


def mixed(every):
    """Rows of zeros of another source behind each so many, at the time of the row before."""
    places = np.arange(every, 1000, every)
    return np.insert(TIME, places, TIME[places - 1]), np.insert(MOTION, places, 0.0, axis=0)


@pytest.mark.parametrize("every", [1, 2, 3, 10])
def test_two_sources_are_told_by_values_that_jump_away_and_back(every):
    assert advice(*mixed(every)).startswith("Rows of two sources seem mixed")


def test_advice_by_what_the_stamps_show():
    time, values = mixed(1)
    time[1::2] += 5.0
    assert advice(time, values).startswith("Rows of two sources")
    time = TIME.copy()
    time[7::7] = time[6::7][: len(time[7::7])]
    assert len(steps_back(time)) == 142
    assert advice(time, MOTION).startswith("Leave out the 142 rows")  # sorted, they would repeat too
    assert advice(np.tile(TIME, 2), np.concatenate([MOTION, MOTION[::-1]])) == Remedy.CUT.value
    assert (
        advice(np.tile(TIME, 5), np.tile(MOTION, (5, 1)) + np.repeat(np.arange(5), 1000)[:, None])
        == Remedy.CUT.value
    )
    time = TIME.copy()
    time[0] = 3.0
    assert advice(time[1:], MOTION[1:]) == Remedy.SORT.value
    time[:3] = 0.0
    assert advice(time, MOTION).startswith("Leave out the first 2 rows")
    assert advice(0.0 * TIME, MOTION) == Remedy.ALL_EQUAL.value


def test_import_says_so_of_a_table(tmp_path):
    """Rows of zeros without effort behind every second one, as of a publisher that knows no arm."""
    rows = []
    for k, row in enumerate(np.column_stack([RUN_TIME, motion(), noise()])):
        rows += [row, [row[0], 0.0, 0.0, np.nan, np.nan]] if k % 2 else [row]
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", header="t,q1,q2,i1,i2", comments="")
    with pytest.raises(BadTime, match="does not increase at 100 of 299 steps, .*two sources seem mixed"):
        import_source(tmp_path / "run.csv", model())
