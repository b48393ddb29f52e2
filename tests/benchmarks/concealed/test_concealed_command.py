"""The command line of the concealed cases: who answers, what is written."""

import json
import sys
from contextlib import nullcontext
from functools import partial
from types import SimpleNamespace

import concealed
import pytest


@pytest.fixture
def cases(tmp_path, monkeypatch):
    """A folder of two cases, answered in this process by who knows one of them."""
    truth = {
        "kind": "single", "robot": "small", "noise_floor": [1.0, 1.0],
        "noise_floor_filtered": [0.5, 0.5], "noise_filter_hz": 25.0,
    }  # fmt: skip
    (tmp_path / "truth").mkdir()
    for name, effect in (("c1", "payload"), ("c2", "backlash")):
        (tmp_path / "cases" / name).mkdir(parents=True)
        known = truth | {"name": name, "effects": [{"effect": effect, "joints": [1]}]}
        (tmp_path / "truth" / f"{name}.json").write_text(json.dumps(known))
    pool = SimpleNamespace(map=map)
    monkeypatch.setattr(concealed, "ProcessPoolExecutor", lambda *_, **__: nullcontext(pool))
    monkeypatch.setattr(concealed, "answerer", lambda who, truths: partial(answering, who))
    return tmp_path


def answering(who, folder):
    """Backlash, of every case, and of none without values."""
    return {"findings": [] if who == "bare" else [{"effect": "backlash", "joints": [1]}]}


def run(monkeypatch, *options):
    monkeypatch.setattr(sys, "argv", ["concealed.py", *map(str, options)])
    return concealed.main(concealed.arguments())


def test_bare_answers_every_case_a_second_time(cases, monkeypatch):
    found = run(monkeypatch, "--made", "--keep", cases, "--bare")
    assert (found["cases"], found["top1"]) == (2, 0.5)
    assert (found["bare"]["cases"], found["bare"]["top1"]) == (2, 0.0)
    text = json.loads((cases / "answers.json").read_text())
    bare = json.loads((cases / "answers-bare.json").read_text())
    assert text.keys() == bare.keys() == {"c1", "c2"}
    assert [len(one["c1"]["findings"]) for one in (text, bare)] == [1, 0]


def test_without_it_nobody_answers_twice(cases, monkeypatch):
    found = run(monkeypatch, "--made", "--keep", cases)
    assert "bare" not in found
    assert not (cases / "answers-bare.json").exists()
    assert run(monkeypatch, "--made", "--keep", cases, "--answer", "bare", "--bare")["top1"] == 0.0
    assert not (cases / "answers-bare.json").exists()


def test_a_sweep_has_no_cases_to_answer_twice(monkeypatch, capsys):
    with pytest.raises(SystemExit):
        run(monkeypatch, "--sweep", "--bare")
    assert "--answer bare" in capsys.readouterr().err
