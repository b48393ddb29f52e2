"""What explains a run, as a frame."""

from dataclasses import replace

import pytest

from exidyn.acquire.run import recorder
from exidyn.acquire.run.frames import HEAD, Unframed
from exidyn.acquire.run.recorder import RunHead

from ...parts.runs.recorded import head

pytestmark = pytest.mark.clocked(patient=True)


def read(frame):
    ((kind, body),) = Unframed().add(frame)
    assert kind == HEAD
    return RunHead.read(body)


def test_only_two_numbers_are_left_to_write_when_the_first_sample_is_there(monkeypatch):
    written, real = [], recorder.model_text
    monkeypatch.setattr(recorder, "model_text", lambda model: written.append(model) or real(model))
    begun = replace(head(), epoch=0, zero=0).prepare_frame()
    assert len(written) == 1
    frames = [begun(10**18 + number, -number) for number in range(3)]
    assert len(written) == 1
    assert [(read(frame).epoch, read(frame).zero) for frame in frames] == [(10**18 + k, -k) for k in range(3)]


def test_what_is_read_is_what_was_written():
    ours = head(name='100 % of "it"', settings={"note": "%d"})
    theirs = read(ours.frame())
    assert theirs == replace(ours, model=theirs.model)
