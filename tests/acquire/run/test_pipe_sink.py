"""The pipe to a process of its own: never blocks, never tears, gives the reason of a failure."""

import fcntl
import os
import signal

import pytest

from exidyn.acquire.run.pipe import PipeSink, SinkFailed
from exidyn.acquire.run.realtime import realtime
from exidyn.acquire.run.recorder import part_of, start_recorder
from exidyn.identification.recordings.mcap.mcap_file import read_recording

from ...parts.runs.recorded import cycle, end, event, head
from ...parts.system_needs import REAL_TIME

pytestmark = pytest.mark.clocked

RECORDER = "exidyn.acquire.run.recorder_process"


def test_a_stalled_reader_fails_the_run_and_yet_loses_nothing(tmp_path):
    with start_recorder(tmp_path / "run.mcap") as sink:
        sink.put(head().frame())
        os.kill(sink.process_id, signal.SIGSTOP)
        count = 0
        while not sink.failure:
            sink.put(cycle(count))
            count += 1
            assert count < 20_000
        assert "is too slow" in sink.failure
        for number in range(count, count + 500):  # the arm brakes
            sink.put(cycle(number))
        os.kill(sink.process_id, signal.SIGCONT)
        sink.put(end())
    assert len(read_recording(tmp_path / "run.mcap").timing) == count + 500


def test_a_loop_that_is_not_in_real_time_waits_for_its_recorder(tmp_path):
    with start_recorder(tmp_path / "run.mcap", waits=True) as sink:
        sink.put(head().frame())
        for number in range(10_000):  # several times as fast as they are written
            sink.put(cycle(number))
        sink.put(end())
    assert not sink.failure
    assert len(read_recording(tmp_path / "run.mcap").timing) == 10_000


def test_a_view_that_stalls_misses_whole_frames_and_fails_nothing(tmp_path):
    with PipeSink("view", RECORDER, [str(tmp_path / "run.mcap")], lossy=True) as sink:
        sink.put(head().frame())
        os.kill(sink.process_id, signal.SIGSTOP)
        for number in range(4000):
            sink.put(cycle(number))
            if number % 100 == 0:  # longer than what a pipe takes whole
                sink.put(event(number, text="long " * 2000))
        os.kill(sink.process_id, signal.SIGCONT)
        assert not sink.failure
        assert sink.dropped > 500
    recording = read_recording(tmp_path / "run.mcap")
    assert len(recording.timing) + len(recording.events) == 4040 - sink.dropped + 1  # one reports: no end
    assert recording.outcome["unreadable_frames"] == "0"


def test_a_head_larger_than_a_small_pipe_and_all_behind_it_arrive(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(fcntl, "fcntl", refuse)
    text = "x = 1\n" * 60_000
    with start_recorder(tmp_path / "run.mcap") as sink:
        sink.put(head(trajectory=text).frame())
        for number in range(100):
            sink.put(cycle(number))
        sink.put(end())
        assert not sink.failure
    recording = read_recording(tmp_path / "run.mcap")
    assert recording.trajectory == text
    assert len(recording.timing) == 100


def test_a_process_that_cannot_start_gives_the_reason(tmp_path, capfd):
    with pytest.raises(SinkFailed, match="view: its process ended"):
        PipeSink("view", "exidyn.nothing")
    with pytest.raises(SinkFailed, match=r"recorder: /proc/run\.mcap\.part: No such file"):
        PipeSink("recorder", RECORDER, ["/proc/run.mcap"])


def test_a_process_that_is_never_ready_is_given_up(monkeypatch, tmp_path):
    (tmp_path / "sleeper.py").write_text("import time\ntime.sleep(100)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with pytest.raises(SinkFailed, match=r"view: is not ready after 0\.2 s"):
        PipeSink("view", "sleeper", patience=0.2)


def test_a_killed_process_is_noticed_without_an_exception(tmp_path):
    with start_recorder(tmp_path / "run.mcap") as sink:
        sink.put(head().frame())
        os.kill(sink.process_id, signal.SIGKILL)
        for number in range(100_000):
            sink.put(cycle(number))
            if sink.failure:
                break
        assert "ended" in sink.failure
        sink.put(cycle(0))
    sink.put(cycle(0))  # closed: nobody cares


def test_signals_that_ask_to_end_reach_the_process_neither_by_terminal_nor_otherwise(tmp_path):
    with start_recorder(tmp_path / "run.mcap") as sink:
        assert os.getsid(sink.process_id) == sink.process_id
        for asked in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            os.kill(sink.process_id, asked)
        for frame in (head().frame(), cycle(0), end()):
            sink.put(frame)
    assert not sink.failure
    assert (tmp_path / "run.mcap").exists()


def test_a_process_started_by_a_loop_in_real_time_is_scheduled_as_usual(tmp_path):
    REAL_TIME.require()
    with realtime():
        assert os.sched_getscheduler(0) == os.SCHED_FIFO
        with start_recorder(tmp_path / "run.mcap") as sink:
            assert os.sched_getscheduler(sink.process_id) == os.SCHED_OTHER


def test_a_run_that_never_began_leaves_no_file(tmp_path):
    with start_recorder(tmp_path / "run.mcap") as sink:
        assert part_of(tmp_path / "run.mcap").exists()
    assert sink.outcome == "nothing was recorded"
    assert not list(tmp_path.iterdir())
