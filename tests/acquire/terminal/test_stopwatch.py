"""How long a command will still take: foretold from its stages, and shown to people only."""

import io
import math
import time

import pytest

from exidyn.acquire.run.errors import CLEAR
from exidyn.acquire.terminal import stopwatch
from exidyn.acquire.terminal.stopwatch import NEARLY, Stopwatch
from exidyn.identification.progress import StageText

pytestmark = pytest.mark.clocked

SHARES = {"read": 0.25, "fit": 0.5, "draw": 0.25}


@pytest.fixture
def clock(monkeypatch):
    """A clock that stands where it is put."""
    now = [0.0]
    monkeypatch.setattr(stopwatch.time, "perf_counter", lambda: now[0])
    return now


def test_the_time_left_follows_from_the_stages_that_are_over(clock, capsys):
    watch = Stopwatch(SHARES)
    watch(StageText("read", "read the files"))
    assert math.isnan(watch.time_left(1.0)[1])
    clock[0] = 10.0
    watch(StageText("fit", "fit all joints"))
    assert watch.time_left(10.0) == pytest.approx((0.25, 30.0))
    assert watch.time_left(20.0) == pytest.approx((0.5, 20.0))
    clock[0] = 18.0
    watch("a sentence inside the stage")
    assert watch.time_left(20.0) == pytest.approx((0.5, 20.0))
    done, remaining = watch.time_left(1e4)  # the stage takes longer than expected, and is not over
    assert done == pytest.approx(0.25 + 0.5 * NEARLY)
    assert math.isnan(remaining)


def test_the_time_left_of_work_that_is_given_its_time(clock):
    watch = Stopwatch(seconds=40.0)
    assert watch.time_left(10.0) == pytest.approx((0.25, 30.0))
    done, left = watch.time_left(50.0)
    assert done == NEARLY
    assert math.isnan(left)  # what comes after it is unknown


def test_a_long_sentence_is_wrapped_below_its_beginning(clock, capsys):
    Stopwatch()("word " * 30)
    first, *others = capsys.readouterr().err.splitlines()
    assert first.startswith("   0.0 s  word")
    assert all(line.startswith(" " * 10 + "word") for line in others)
    assert max(map(len, [first, *others])) <= 80


def test_a_file_gets_the_sentences_alone(capsys):
    with Stopwatch(SHARES) as watch:
        watch(StageText("read", "read the files"))
        time.sleep(0.1)
    assert capsys.readouterr().err == "   0.0 s  read the files\n"


def test_items_have_a_time_left(clock):
    watch, seen = Stopwatch(), []
    for item in watch.over(range(4)):
        seen.append(item)
        clock[0] += 10.0
    assert seen == [0, 1, 2, 3]
    assert watch.time_left(30.0) == pytest.approx((0.75, 10.0))


def test_a_terminal_gets_one_line_that_is_rewritten_and_gone_in_the_end(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    terminal = Terminal()
    monkeypatch.setattr(stopwatch, "REDRAW", 0.01)
    monkeypatch.setattr(stopwatch.sys, "stderr", terminal)
    with Stopwatch(SHARES) as watch:
        for stage in SHARES:
            time.sleep(0.05)
            watch(StageText(stage, f"do {stage} " + "word " * 30))
        time.sleep(0.05)
    shown = terminal.getvalue()
    assert "\n" not in shown
    lines = shown.split(CLEAR)
    assert max(map(len, lines)) < 80
    assert [line for line in lines if " left, do draw" in line]
    assert lines[-1] == ""
