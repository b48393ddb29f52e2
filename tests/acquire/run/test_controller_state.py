"""The controller's own state in recordings: as handed over, copied, printed, and absent from old files."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.terminal.recording_text import describe, recording_table
from exidyn.identification.errors import WrongShape
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import ControllerState

from ...parts.runs.recorded import cycle, end, head, record

WORDS = {"safety_mode": {1: "normal", 3: "protective stop"}, "override": {}}
STATE = np.array([[1.0, 1.0]] * 6 + [[np.nan, np.nan]] * 2 + [[3.0, 0.5]] * 4)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("state") / "run.mcap"
    frames = [cycle(number, state=state) for number, state in enumerate(STATE)]
    sink = record(path, [head(state=WORDS).frame(), *frames, end()])
    assert not sink.failure
    return path


def test_it_is_recorded_in_every_cycle_in_which_it_is_known(run):
    recording = read_recording(run)
    known = np.isfinite(STATE).all(axis=1)
    state = recording.controller
    assert state.words == WORDS
    assert np.array_equal(state.values, STATE[known])
    assert np.array_equal(state.time, recording.signals["position"].time[known])
    assert state.of("override").tolist() == [1.0] * 6 + [0.5] * 4


def test_a_copy_has_it_too(run, tmp_path):
    recording = read_recording(run)
    write_recording(recording, tmp_path / "copy.mcap")
    copy = read_recording(tmp_path / "copy.mcap").controller
    assert copy.words == WORDS
    assert np.array_equal(copy.values, recording.controller.values)
    assert np.array_equal(copy.time, recording.controller.time)


def test_it_is_printed_in_words(run):
    recording = read_recording(run)
    text = " ".join(describe(recording).split())
    assert "controller: safety mode normal, protective stop; override 0.5 .. 1" in text
    table = recording_table(recording)
    assert table["controller"] == {"safety_mode": "normal, protective stop", "override": "0.5 .. 1"}


def test_a_recording_without_it_is_read_as_before(tmp_path):
    sink = record(tmp_path / "run.mcap", [head().frame(), *(cycle(number) for number in range(5)), end()])
    assert not sink.failure
    recording = read_recording(tmp_path / "run.mcap")
    assert recording.controller is None
    assert recording_table(recording)["controller"] is None
    assert "controller:" not in describe(replace(recording, settings={}))


def test_a_cycle_with_another_number_of_them_is_refused(tmp_path):
    frames = [cycle(0, state=STATE[0]), cycle(1, state=np.zeros(3)), cycle(2, state=STATE[2])]
    sink = record(tmp_path / "run.mcap", [head(state=WORDS).frame(), *frames, end()])
    assert "3 state values, expected 2" in sink.failure
    assert len(read_recording(tmp_path / "run.mcap").controller) == 2


def test_columns_that_have_no_name_are_refused():
    with pytest.raises(WrongShape, match=r"\(4, 3\), expected \(4, 2\)"):
        ControllerState(np.arange(4.0), np.zeros((4, 3)), WORDS)
