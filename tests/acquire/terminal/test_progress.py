"""The line about a run that goes on: right, in time, and without delay to the run."""

import os
import pty
import signal
from contextlib import contextmanager

from exidyn.acquire.run.errors import CLEAR
from exidyn.acquire.run.frames import END, SAMPLE, text_frame
from exidyn.acquire.run.player import APPROACHING, HOLDING, RUNNING
from exidyn.acquire.terminal import progress
from exidyn.acquire.terminal.progress import Line, Progress, start_progress

from ...parts.runs.recorded import cycle, end, head
from ...parts.system_needs import TERMINALS


def body(frame):
    """Of a frame, behind its kind and length."""
    return frame[5:]


def line(*stages, skipped=0):
    found = Line(10.0)
    for number, stage in enumerate(stages):
        found.add(SAMPLE, body(cycle(number, stage=stage, skipped=skipped)))
    return str(found)


def test_it_states_how_far_the_motion_has_got_and_how_to_stop_it():
    assert line(APPROACHING) == "approaching; cycles missed: 0; Ctrl-C stops the arm"
    running = line(*[RUNNING] * 751, skipped=1)
    assert running == "running 1.5 of 10.0 s; cycles missed: 751; Ctrl-C stops the arm"
    assert line(RUNNING, HOLDING) == "holding 0.0 of 10.0 s; cycles missed: 0"  # nothing is left to stop


def test_the_time_left_follows_from_the_speed_until_now():
    found = Line(10.0)
    assert found.time_left(100.0) == ""
    for number in range(1251):  # of 2 ms
        found.add(SAMPLE, body(cycle(number, stage=RUNNING)))
    assert found.time_left(100.0) == ""
    assert found.time_left(105.0) == "; about 15 s left"
    found.add(END, body(text_frame(END, {})))
    assert found.over


@contextmanager
def terminal():
    """File number of what is seen of a terminal that takes the place of standard error.

    No fixture: pytest captures anew between those and a test.
    """
    TERMINALS.require()
    seen, own = pty.openpty()
    os.set_blocking(seen, False)
    before = os.dup(2)
    os.dup2(own, 2)
    try:
        yield seen
    finally:
        os.dup2(before, 2)
        for number in (seen, own, before):
            os.close(number)


def test_what_is_left_in_the_terminal_is_an_empty_line():
    with terminal() as seen:
        with Progress(10.0) as shown:
            shown.put(head().frame())
            for number in range(10):
                shown.put(cycle(number))
            shown.put(end())
        text = os.read(seen, 10_000).decode()
    assert not shown.failure
    assert "running 0.0 of 10.0 s" in text
    assert text.endswith(CLEAR)


def test_one_that_hangs_is_not_waited_for():
    with terminal(), Progress(10.0) as shown:
        os.kill(shown.process_id, signal.SIGSTOP)
        for number in range(10_000):
            shown.put(cycle(number))
        shown.close(patience=0.1)
    assert shown.dropped
    assert "was killed" in shown.failure


def test_without_a_terminal_there_is_no_line(monkeypatch):
    monkeypatch.setattr(progress.sys.stderr, "isatty", lambda: False, raising=False)
    assert start_progress(10.0) == []
