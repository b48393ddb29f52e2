"""The cell of a study: what is asked of a person, and what becomes of a run that was stopped."""

import pytest

from exidyn.acquire.run.errors import NotConfirmed, RunStopped
from exidyn.acquire.study.choice_file import Chosen
from exidyn.acquire.study.rounds import Round
from exidyn.acquire.study.sources import Cell
from exidyn.identification.effects import known_parameters
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.trajectories.planning.wishes import Wishes
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import write_plan

from ...parts.runs.run_parts import MODEL, motion

BODY = KnownPayload("L", known_parameters(3.0))
CHOSEN = Chosen("next.toml", True, "Hang the body of 3 kg on the flange")


class Recorder:
    """Writes empty files, and stops the first so many runs."""

    def __init__(self, stops=0):
        self.stops, self.carried = stops, []

    def __call__(self, plan, path, body):
        self.carried.append(body)
        path.write_text("")
        self.stops -= 1
        if self.stops >= 0:
            raise RunStopped(f"what was recorded is in {path}")


@pytest.fixture
def one(tmp_path):
    write_plan(Plan.of(motion(), MODEL), tmp_path / "next.toml")
    (tmp_path / "round-02").mkdir()
    return Round(2, tmp_path / "round-02")


def cell(recorder, folder, attended=True):
    return Cell(MODEL, recorder, Wishes(), 1.0, BODY, attended, folder / "offers")


def test_what_a_person_must_do_is_asked_in_a_sentence_and_waited_for(one, monkeypatch, capsys):
    answered = []
    monkeypatch.setattr("builtins.input", lambda: answered.append(one.run.exists()))
    recorder = Recorder()
    cell(recorder, one.folder).make(one, CHOSEN)
    assert capsys.readouterr().err.startswith("Hang the body of 3 kg on the flange, then press Enter")
    assert answered == [False]
    assert recorder.carried == [BODY]
    assert one.run.exists()


def test_without_anyone_to_answer_nothing_is_moved(one, monkeypatch):
    def nobody():
        raise EOFError

    monkeypatch.setattr("builtins.input", nobody)
    recorder = Recorder()
    with pytest.raises(NotConfirmed, match="nothing was moved"):
        cell(recorder, one.folder).make(one, CHOSEN)
    assert recorder.carried == []


def test_a_simulated_arm_needs_nobody(one):
    cell(Recorder(), one.folder, attended=False).make(one, CHOSEN)
    assert one.run.exists()


def test_a_run_that_was_stopped_is_kept_beside_and_made_again(one):
    recorder = Recorder(stops=1)
    there = cell(recorder, one.folder, attended=False)
    with pytest.raises(RunStopped, match=r"attempt-1\.mcap"):
        there.make(one, CHOSEN)
    assert not one.run.exists()
    there.make(one, CHOSEN)
    assert sorted(path.name for path in one.folder.glob("*.mcap")) == ["attempt-1.mcap", "run.mcap"]
