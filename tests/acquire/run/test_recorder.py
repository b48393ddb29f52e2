"""What is handed over is what is in the file, whatever becomes of the processes and the disk."""

import resource
import struct
import subprocess

import numpy as np
import pytest
from mcap.reader import make_reader

from exidyn.acquire.run.errors import RunError
from exidyn.acquire.run.frames import EVENT, SAMPLE, STAGES, sample_frame, text_frame
from exidyn.acquire.run.recorder import part_of, start_recorder
from exidyn.acquire.terminal.recording_text import describe
from exidyn.drivers import Sample
from exidyn.identification.recordings.mcap.mcap_file import read_recording

from ...parts.runs.recorded import (
    CONTROLLER,
    HOST,
    MODEL,
    NOTHING,
    NUMBERS,
    STEP,
    cycle,
    end,
    event,
    head,
    record,
    record_until_failure,
)
from ...parts.system_needs import SMALL_DISK
from ...peers.recorder_kills import kill

pytestmark = pytest.mark.clocked

CYCLES = 1000
LISTENED = 100


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "run.mcap"
    frames = [cycle(number, commanded=number >= LISTENED) for number in range(CYCLES)]
    frames.insert(500, event(499, "stop", "joint2 is 3 degrees away", joint="joint2", value=3.0))
    sink = record(path, [head().frame(), *frames, end(stop="tracking", joint="joint2")])
    assert not sink.failure
    return path


def test_what_is_read_is_what_was_handed_over(run):
    recording = read_recording(run)
    numbers = np.arange(CYCLES)
    position, current, temperature, velocity = NUMBERS[:CYCLES].transpose(1, 0, 2)
    signals = recording.signals
    assert set(signals) == {"position", "current", "temperature", "command", "command_velocity"}
    assert np.array_equal(signals["position"].values, position)
    assert np.array_equal(signals["current"].values, current)
    assert np.array_equal(signals["temperature"].values, 40.0 + temperature[::10])
    assert np.array_equal(signals["command"].values, position[LISTENED:] + 1e-3)
    assert np.array_equal(signals["command_velocity"].values, velocity[LISTENED:])
    assert np.array_equal(signals["position"].time, np.rint(numbers * STEP) / 1e9)
    assert np.array_equal(recording.host_time, HOST + numbers * STEP + 1000 * (numbers % 3))
    assert recording.payload == head().payload
    assert recording.trajectory == head().trajectory
    assert recording.settings == {"driver": "mock", "controller_zero_ns": str(CONTROLLER)}
    assert recording.warnings[0] == "suspicious"
    assert recording.model.names == MODEL.names


def test_timing_events_and_outcome_are_kept(run):
    recording = read_recording(run)
    timing, numbers = recording.timing, np.arange(CYCLES)
    assert timing.stages == STAGES
    assert np.array_equal(timing.lateness, 1e-6 * (numbers % 7))
    assert np.array_equal(timing.skipped, 2 * (numbers % 100 == 99))
    assert np.array_equal(timing.stage, np.full(CYCLES, 2))
    [happened] = recording.events
    assert (happened.kind, happened.text) == ("stop", "joint2 is 3 degrees away")
    assert happened.time == pytest.approx(499 * STEP * 1e-9)
    assert happened.details == {"joint": "joint2", "value": 3.0}
    assert recording.outcome["stop"] == "tracking"
    assert recording.outcome["cycles"] == str(CYCLES)
    assert recording.outcome["skipped"] == "20"
    assert recording.outcome["lateness_max_s"] == "0.000006"


def test_info_states_how_the_run_went(run):
    text = describe(read_recording(run))
    assert "1000 cycles (running 1000), 20 skipped" in text
    assert "lateness median 0.003, 99 % 0.006, largest 0.006 ms" in text
    assert "0.998 s  stop      joint2 is 3 degrees away" in text
    assert "ended:  STOPPED (brake): tracking joint2" in text


def test_other_tools_read_events_and_timing(run):
    highlevel = pytest.importorskip("rosbags.highlevel")
    found: dict[str, list] = {}
    with highlevel.AnyReader([run]) as reader:
        for connection, stamp, raw in reader.messages():
            found.setdefault(connection.topic, []).append(
                (stamp, reader.deserialize(raw, connection.msgtype))
            )
    [(stamp, log)] = found["/events"]
    assert stamp == HOST + 499 * STEP
    assert (log.level, log.ERROR) == (40, 40)
    assert (log.name, log.msg) == ("exidyn.stop", "joint2 is 3 degrees away")
    assert log.stamp.nanosec == 499 * STEP
    assert len(found["/timing"]) == CYCLES
    assert np.array_equal(
        [message.data[1] for _, message in found["/timing"]], 2 * (np.arange(CYCLES) % 100 == 99)
    )
    assert [stamp for stamp, _ in found["/joint_states"]] == read_recording(run).host_time.tolist()
    assert 95 <= len(found["/tf"]) <= 105  # 50 a second


def test_a_recording_is_a_part_until_it_is_whole(tmp_path):
    path = tmp_path / "run.mcap"
    with start_recorder(path) as sink:
        sink.put(head().frame())
        sink.put(cycle(0))
        assert part_of(path).exists()
        assert not path.exists()
        sink.put(end())
    assert [file.name for file in tmp_path.iterdir()] == ["run.mcap"]
    with open(path, "rb") as stream:
        assert make_reader(stream).get_summary().statistics.message_count > 3


@pytest.mark.parametrize("name", ["run.mcap", "run.mcap.part"])
def test_nothing_is_written_over(tmp_path, name):
    (tmp_path / name).write_text("precious")
    with pytest.raises(RunError, match=f"{name} exists"):
        start_recorder(tmp_path / "run.mcap")
    assert (tmp_path / name).read_text() == "precious"


def test_a_file_that_appears_during_the_run_is_not_written_over_either(tmp_path):
    path = tmp_path / "run.mcap"
    with start_recorder(path) as sink:
        sink.put(head().frame())
        sink.put(cycle(0))
        path.write_text("precious")
        sink.put(end())
    assert "File exists" in sink.failure
    assert path.read_text() == "precious"
    assert len(read_recording(part_of(path)).timing) == 1


def test_frames_that_make_no_sense_are_counted_and_the_rest_is_kept(tmp_path):
    bad = [
        text_frame(EVENT, {"kind": "no times"}),
        text_frame(EVENT, {"host_time": "x", "controller_time": 0, "kind": "", "text": "", "details": {}}),
        struct.pack("<cI", SAMPLE, 3) + b"abc",
        sample_frame(Sample(HOST, CONTROLLER, *[NOTHING[:3]] * 5), None, 0),
        cycle(2, host_time=-1),
        head().frame(),
    ]
    frames = [cycle(0), *bad, cycle(1), end()]
    sink = record(tmp_path / "run.mcap", [cycle(0), head().frame(), *frames])
    assert "a frame could not be read" in sink.failure
    recording = read_recording(tmp_path / "run.mcap")
    assert np.array_equal(recording.signals["position"].values, NUMBERS[:2, 0])
    assert recording.outcome["unreadable_frames"] == str(len(bad) + 1)
    [warning] = recording.events
    assert warning.text.startswith("a frame could not be read: the first frame is not a head")
    assert warning.time >= 0.0


def test_bytes_that_are_no_frames_end_the_file_and_not_what_came_before(tmp_path):
    frames = [head().frame(), *(cycle(number) for number in range(100)), b"\x00" * 5000]
    sink = record(tmp_path / "run.mcap", frames)
    assert "a frame could not be read" in sink.failure
    assert len(read_recording(tmp_path / "run.mcap").timing) == 100


def test_silent_cycles_leave_rows_out_and_their_timing_in(tmp_path):
    silent = {name: NOTHING for name in ("position", "current", "temperature")}
    partly = NUMBERS[4, 0].copy()
    partly[1] = np.nan
    frames = [
        cycle(0),
        cycle(1),
        cycle(2, **silent),
        cycle(3),
        cycle(4, position=partly),
        *map(cycle, range(5, 9)),
    ]
    record(tmp_path / "run.mcap", [head().frame(), *frames, end()])
    recording = read_recording(tmp_path / "run.mcap")
    assert len(recording.timing) == 9
    assert recording.signals["position"].time.tolist() == [0.0, 0.002, 0.006, 0.010, 0.012, 0.014, 0.016]
    assert len(recording.host_time) == 7
    assert len(recording.signals["current"]) == 8
    assert any(
        "joint was silent in 1 of 8 samples (joint2 in 1)" in warning for warning in recording.warnings
    )


@pytest.mark.parametrize(("victims", "after"), [(("recorder", "loop"), 0.37), (("recorder",), 0.61)])
def test_a_killed_recorder_leaves_a_readable_file_up_to_just_before(tmp_path, victims, after):
    left = kill(tmp_path, victims, after)
    assert left.file.name == "run.mcap.part"
    assert left.recording.trajectory == "x = 1\n"
    assert left.recording.warnings[0].startswith("file ends abruptly")
    assert left.lost_ms < 500.0
    if "loop" not in victims:
        assert left.printed.startswith("failure its process ended")


def test_a_killed_loop_loses_nothing(tmp_path):
    left = kill(tmp_path, ("loop",), 0.45)
    assert left.file.name == "run.mcap"
    assert left.lost_ms == 0.0
    assert "ended without a reason" in left.recording.events[-1].text
    assert left.recording.outcome["stop"] == "unknown"
    assert not any("abruptly" in warning for warning in left.recording.warnings)


def test_a_file_that_may_not_grow_stops_the_run_and_stays_readable(tmp_path):
    path = tmp_path / "run.mcap"
    with start_recorder(path) as sink:
        sink.put(head().frame())
        resource.prlimit(sink.process_id, resource.RLIMIT_FSIZE, (300_000, 300_000))
        record_until_failure(sink, 20_000)
        assert "run.mcap.part: File too large" in sink.failure
    assert sink.outcome.startswith("what was written is in ")
    recording = read_recording(part_of(path))
    known = len(recording.signals["position"])
    assert known > 300
    assert np.array_equal(recording.signals["position"].values, NUMBERS[:known, 0])


@pytest.fixture
def small_disk(tmp_path):
    """A disk of five MiB, one of which is free behind what a recorder keeps back."""
    disk = tmp_path / "disk"
    disk.mkdir()
    SMALL_DISK.require()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=5m", "none", disk], check=True)
    yield disk
    subprocess.run(["umount", "-l", disk], check=True)


def test_a_full_disk_stops_the_run_and_still_takes_how_it_ended(small_disk):
    path = small_disk / "run.mcap"
    with start_recorder(path) as sink:
        sink.put(head().frame())
        count = record_until_failure(sink, 20_000, after=500)
        assert "disk error: No space left on device" in sink.failure
        sink.put(event(count, "stop", "the recording cannot continue"))
        sink.put(end(stop="recorder"))
    assert sink.outcome.endswith(f"cycles in {path}")
    recording = read_recording(path)
    assert len(recording.timing) == count
    assert [happened.kind for happened in recording.events] == ["warning", "stop"]
    assert recording.events[0].text == "disk error: No space left on device"
    assert recording.outcome["stop"] == "recorder"


def test_a_disk_that_is_fuller_still_leaves_what_was_written(small_disk):
    path = small_disk / "run.mcap"
    with start_recorder(path) as sink:
        sink.put(head().frame())
        count = record_until_failure(sink, 20_000, after=20_000)
    recording = read_recording(part_of(path))
    assert 5_000 < len(recording.timing) < count
    assert "No space left on device" in sink.failure


def test_a_disk_without_room_for_the_end_is_refused_at_the_beginning(small_disk):
    (small_disk / "other").write_bytes(bytes(2 << 20))
    with pytest.raises(RunError, match=r"recorder: .*No space left on device"):
        start_recorder(small_disk / "run.mcap")
    assert [file.name for file in small_disk.iterdir()] == ["other"]
