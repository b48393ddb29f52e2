"""What is said of time that does not go on."""

import numpy as np
import pytest

from exidyn.identify.recordings.steps_back import SKIP, SORT, advice, steps_back

TIME = 0.004 * np.arange(1000)
MOTION = np.column_stack([np.sin(3 * TIME), np.cos(2 * TIME)])


def mixed(every):
    """Rows of zeros of another source behind each so many, at the time of the row before."""
    places = np.arange(every, 1000, every)
    return np.insert(TIME, places, TIME[places - 1]), np.insert(MOTION, places, 0.0, axis=0)


@pytest.mark.parametrize("every", [1, 2, 3, 10])
def test_two_sources_are_told_by_values_that_jump_away_and_back(every):
    assert advice(*mixed(every)).startswith("Rows of two sources seem mixed")


def test_the_second_source_may_be_of_another_clock():
    time, values = mixed(1)
    time[1::2] += 5.0
    assert advice(time, values).startswith("Rows of two sources")


def test_stamps_that_were_given_twice_are_of_one_source():
    time = TIME.copy()
    time[7::7] = time[6::7][: len(time[7::7])]
    assert len(steps_back(time)) == 142
    assert advice(time, MOTION) == SORT


def test_a_second_run_in_one_file_is_no_second_source():
    assert advice(np.tile(TIME, 5), np.tile(MOTION, (5, 1))) == SORT


def test_rows_before_the_recorder_settled_are_skipped():
    time = TIME.copy()
    time[0] = 3.0
    assert advice(time[1:], MOTION[1:]) == SORT
    time[:3] = 0.0
    assert advice(time, MOTION) == SKIP
