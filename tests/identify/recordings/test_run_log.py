"""Events and timing of a run survive writing and reading."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.errors import WrongShape
from exidyn.identification.recordings.mcap import cdr
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import Event, Timing

from ...parts.runs.full_run import recording

TIME = np.arange(100) * 0.002


def timing():
    random = np.random.default_rng(0)
    stage = np.repeat([0, 2, 3, 4], 25)
    return Timing(TIME, random.normal(size=100), random.integers(0, 9, 100), stage, ("listening", "running"))


def test_events_timing_and_outcome_are_read_as_they_were_written(tmp_path):
    events = (
        Event(-0.5, "driver", "it began", {}),
        Event(0.25, "stop", 'joint2: "ü" is 3 away', {"joint": "joint2", "value": 3.0, "limit": [1, 2]}),
    )
    written = replace(recording(), events=events, timing=timing(), outcome={"stop": "tracking"})
    write_recording(written, tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    assert read.events == events
    assert read.outcome == {"stop": "tracking"}
    assert read.timing.stages == timing().stages
    for name in ("time", "lateness", "skipped", "stage"):
        assert np.array_equal(getattr(read.timing, name), getattr(timing(), name))


def test_a_recording_without_events_has_none_and_timing_has_one_value_a_cycle(tmp_path):
    write_recording(recording(), tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    assert (read.events, read.timing, dict(read.outcome)) == ((), None, {})
    with pytest.raises(WrongShape, match=r"skipped has shape \(99,\)"):
        Timing(TIME, np.zeros(100), np.zeros(99), np.zeros(100))


@pytest.mark.parametrize("cut", [4, 25, 53])
def test_a_damaged_event_raises_nothing_but_value_errors(cut):
    whole = cdr.log_message(1_500_000_000, cdr.WARN, "name", "text", "{}")
    assert cdr.read_log(whole) == cdr.LogMessage(1_500_000_000, cdr.WARN, "name", "text", "{}")
    with pytest.raises(ValueError, match=r".+"):
        cdr.read_log(whole[: min(cut, len(whole) - 5)])
