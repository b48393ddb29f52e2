"""exidyn diagnose: what it reads, prints, writes and refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest
from exidyn.acquire import diagnose_command
from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.diagnosis_files import add_answer
from exidyn.identify.diagnosis import Remainder
from exidyn.identify.diagnosis.report import report_html
from exidyn.identify.diagnosis.runs import usable
from exidyn.identify.fit_file import read_fit
from exidyn.identify.mcap_file import write_recording
from exidyn.identify.recording import Signal
from exidyn.identify.robot_file import read_model
from exidyn.identify.robot_text import model_text

from .report_pages import Page
from .small_diagnosis import believed, diagnosis, recording, recordings
from .two_joint_files import of_another_arm, write


@pytest.fixture
def runs(tmp_path):
    """Paths of a robot as believed, and of its runs with their roles in them."""
    robot = tmp_path / "robot.toml"
    robot.write_text(model_text(believed()))
    return [str(robot), *write(tmp_path, *recordings())]


def test_a_spring_that_nobody_told_of_is_named_simulated_and_fitted(runs, tmp_path, capsys):
    out, answers = tmp_path / "out", tmp_path / "answers.json"
    answers.write_text('{"other": {"findings": []}}')
    assert main(["diagnose", *runs, "--output", str(out), "--answer", str(answers)]) == 0
    page = capsys.readouterr().out
    assert "- Joint 2 (elbow) is held by a spring" in page
    assert "simulated after" in page
    table = json.loads((out / "diagnosis.json").read_text())
    assert table["findings"][0]["effect"] == "joint_spring"
    assert table["simulated"]["torque_rms_before"][1] > 10 * table["simulated"]["torque_rms_after"][1]
    assert read_fit(out / "fit.json").value("Ks2") == pytest.approx(12.0, rel=0.02)
    found = json.loads(answers.read_text())
    assert list(found) == ["other", "two joints"]
    assert found["two joints"]["findings"][0]["joints"] == [2]
    report = Page((out / "report.html").read_text(encoding="utf-8"))
    assert {"verdict", "findings", "simulation", "joints", "data"} <= {
        attributes["id"] for tag, attributes in report.elements if tag == "section"
    }


def test_quick_json_has_neither_simulation_nor_fit(runs, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(diagnose_command, "diagnose", lambda *_: diagnosis())
    assert main(["diagnose", *runs, "--quick", "--json", "-", "--output", str(tmp_path / "out")]) == 0
    table = json.loads(capsys.readouterr().out)
    assert table["held_out"] == ["validate2"]
    assert "simulated" not in table
    assert not (tmp_path / "out" / "fit.json").exists()


def test_models_to_tell_apart_are_written_where_the_words_say(tmp_path, monkeypatch, capsys, runs):
    monkeypatch.setattr(diagnose_command, "diagnose", lambda *_: diagnosis())
    out = tmp_path / "out"
    assert main(["diagnose", *runs, "--quick", "--output", str(out)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    if not diagnosis().findings[0].alternatives:
        assert not (out / "found.toml").exists()
        return
    assert f"exidyn excite {out}/found.toml --against {out}/instead-1.toml" in said
    assert "Ks2" in read_model(out / "found.toml").names
    assert "Ks2" not in read_model(out / "instead-1.toml").names


def test_options_give_runs_their_roles(runs, tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(
        diagnose_command, "diagnose", lambda model, runs, name: seen.append(runs) or diagnosis()
    )
    robot, one, two, three = runs
    arguments = [robot, one, "--slow", two, "--validate", three, "--payload", one, "--mass", "3"]
    assert main(["diagnose", *arguments, "--quick", "--output", str(tmp_path / "out")]) == 0
    assert [role for role, _ in seen[0]] == ["identify", "slow", "validate", "payload"]
    assert dict(seen[0][3][1].payload.known) == {"M": 3.0}


def test_without_a_robot_the_recordings_bring_theirs(runs, tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(diagnose_command, "diagnose", lambda model, *_: seen.append(model) or diagnosis())
    assert main(["diagnose", *runs[1:], "--quick", "--output", str(tmp_path / "out")]) == 0
    assert seen[0].names == believed().names


def test_what_cannot_be_asked_is_a_doubt_and_the_rest_is_answered(tmp_path, capsys):
    first, second, held_out = recordings()
    short = replace(recording("identify", 7), name="short", signals=_first(first, 1.0))
    paths = write(tmp_path, first, second, short)
    assert main(["diagnose", *paths, "--quick", "--output", str(tmp_path / "out")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "Short is left out: 1.00 s is too short for filters" in said
    assert "No run was held out: that the fit improves is no proof" in said
    assert "Temperatures were not recorded" in said


def _first(recording, seconds):
    kept = {name: signal.time < seconds for name, signal in recording.signals.items()}
    return {name: signal[kept[name]] for name, signal in recording.signals.items()}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["{robot}"], "a robot and no run"),
        (["{robot}", "{held_out}"], "no run is left to fit: all are held out"),
        (["{robot}", "missing.mcap"], "missing.mcap does not exist"),
        (["{one}", "{other}"], "with other geometry"),
        (["{case}", "{one}"], "no case folder, as the others are"),
        (["{case}", "--validate", "{one}"], "--validate beside a case folder"),
        (["{robot}", "{one}", "--answer", "{robot}"], "exists and is not JSON"),
        (["{robot}", "{one}", "--output", "{one}"], "--output needs a folder"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(arguments, said, runs, tmp_path, capsys):
    case = tmp_path / "case"
    case.mkdir()
    (case / "case.toml").write_text("[case]\nformat = 1\n")
    other = tmp_path / "other.mcap"
    write_recording(of_another_arm(recordings()[0]), other)
    names = dict(zip(("robot", "one", "two", "held_out"), runs, strict=True)) | {"case": case, "other": other}
    given = [argument.format(**names) for argument in arguments]
    if "--output" not in given:
        given += ["--output", str(tmp_path / "out")]
    assert main(["diagnose", *given]) == REFUSED
    [line] = [line for line in capsys.readouterr().err.splitlines() if line.startswith("exidyn: ")]
    assert said in line


def test_a_case_that_fails_does_not_stop_the_others(tmp_path, monkeypatch, capsys):
    for name in ("c1", "c2"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "case.toml").write_text("[case]\nformat = 1\n")
    good = diagnose_command.Case("c2", believed(), [("identify", recordings()[0])])
    read = diagnose_command.read_case
    monkeypatch.setattr(diagnose_command, "read_case", lambda path: good if path.name == "c2" else read(path))
    monkeypatch.setattr(diagnose_command, "diagnose", lambda *_: replace(diagnosis(), name="c2"))
    paths, answers = [str(tmp_path / name) for name in ("c1", "c2")], tmp_path / "answers.json"
    given = ["--quick", "--answer", str(answers), "--output", str(tmp_path / "out")]
    assert main(["diagnose", *paths, *given]) == REFUSED
    assert "c1: " in capsys.readouterr().err
    assert list(json.loads(answers.read_text())) == ["c2"]
    assert (tmp_path / "out" / "c2" / "diagnosis.json").exists()


def test_an_answer_replaces_that_of_its_own_case_only(tmp_path):
    path = tmp_path / "deep" / "answers.json"
    add_answer(replace(diagnosis(), name="a"), path)
    add_answer(replace(diagnosis(), name="b"), path)
    add_answer(replace(diagnosis(), name="a", findings=()), path)
    found = json.loads(path.read_text())
    assert found["a"]["findings"] == []
    assert found["b"]["findings"][0]["effect"] == "joint_spring"


def test_numbers_that_are_none_do_not_spoil_the_files(tmp_path):
    one = diagnosis().findings[0]
    path = tmp_path / "answers.json"
    add_answer(replace(diagnosis(), findings=(replace(one, held_out=np.nan),)), path)
    assert "NaN" not in path.read_text()


def test_temperatures_that_are_there_are_no_doubt():
    one = recordings()[0]
    time = one.signals["position"].time
    warm = Signal(time, np.full((len(time), 2), 31.0) + 0.01 * time[:, None])
    for signals, doubted in ((one.signals, True), ({**one.signals, "temperature": warm}, False)):
        _, doubts = usable(believed(), [("identify", replace(one, signals=signals))])
        assert any("temperatures were not recorded" in doubt for doubt in doubts) == doubted


def test_the_page_says_what_is_left_without_a_name():
    left = (Remainder(1, 2.14, 0.999, "position"),)
    page = Page(report_html(replace(diagnosis(), findings=(), remainders=left)))
    assert "none of what exidyn knows" in page.words
    assert "unexplained" in [attributes.get("id") for tag, attributes in page.elements if tag == "section"]
    bare = Page(report_html(replace(diagnosis(), evidence=None)))
    assert "came without the samples of its runs" in bare.words
