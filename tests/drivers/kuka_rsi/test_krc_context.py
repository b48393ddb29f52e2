"""What the controller of the tests does with answers, as a real one does."""

import numpy as np
import pytest

from exidyn.drivers.kuka_rsi.config import AXES, standard_config
from exidyn.drivers.kuka_rsi.telegram import Answer

from ...peers.krc_context import Context

TAGS = tuple(f"AK.{axis}" for axis in AXES)
ANSWER = Answer("ImFree", standard_config("127.0.0.1").receive, TAGS, "Stop")


def context(**changes):
    six = np.ones(6)
    given = {"hold": True, "limit": 5 * six, "overall": 6 * six, "timeout": 3, "speed": 1e6 * six} | changes
    return Context("ImFree", TAGS, given.pop("hold"), "Stop", 0.004, **given)


def answer(stamp, *corrections, stop=False):
    padded = [*corrections, *[0.0] * (6 - len(corrections))]
    return ANSWER.complete(ANSWER.head(padded, stop), str(stamp).encode())


def test_an_answer_counts_from_the_next_cycle_on():
    one = context()
    assert one.answer(answer(4, 1.5, -2.0), 4)
    np.testing.assert_array_equal(one.step(), [1.5, -2.0, 0, 0, 0, 0])


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (answer(0, 1.0), "late"),
        (answer(8, 1.0), "ipoc"),
        (answer(4, 1.0).replace(b"ImFree", b"Other"), "sentype"),
        (answer(4, 1.0).replace(b"AK", b"AKorr"), "unreadable"),
        (b"<Sen", "unreadable"),
    ],
)
def test_answers_that_are_none_are_rejected_and_the_last_is_held(data, why):
    one = context()
    one.answer(answer(0, 0.5), 0)
    one.step()
    assert not one.answer(data, 4)
    assert one.step()[0] == 0.5
    assert one.rejected == {why: 1}
    assert one.delay == 1


def test_without_holdon_a_late_answer_sends_the_arm_back():
    one = context(hold=False, speed=np.full(6, 100.0))
    for stamp in range(0, 40, 4):
        one.answer(answer(stamp, 0.01 * stamp), stamp)
        one.step()
    assert one.correction[0] == pytest.approx(0.36)
    one.correction = np.full(6, 2.0)
    one.step()
    assert one.stopped == "KSS1102 command velocity"


def test_too_many_missing_answers_stop_it():
    one = context()
    for _ in range(10):  # before the first answer nobody counts
        one.step()
    one.answer(answer(0), 0)
    for _ in range(4):
        assert one.stopped == ""
        one.step()
    assert one.delay == 3
    one.step()
    assert one.stopped == "KSS29002 ETHERNET1 RSITimeout"


def test_corrections_are_cut_off_without_a_word_and_stop_beyond_the_overall_limit():
    one = context()
    one.answer(answer(0, 5.5), 0)
    assert one.step()[0] == 5.0
    assert (one.clamped, one.stopped) == (1, "")
    wide = context(limit=np.full(6, 90.0))
    wide.answer(answer(0, 6.5), 0)
    wide.step()
    assert wide.stopped == "KSS29000 permissible overall correction exceeded"


def test_the_stop_channel_stops():
    one = context()
    one.answer(answer(0, stop=True), 0)
    one.step()
    assert one.stopped == "stopped by the Stop channel"
