"""exidyn diagnose: what it reads, prints, writes and refuses."""

import json
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.commands import diagnose_command
from exidyn.acquire.files.diagnosis_files import add_answer, write_diagnosis
from exidyn.acquire.files.given_runs import COMPARISON_CUTOFF
from exidyn.acquire.files.report_files import read_shown
from exidyn.identification.diagnosis import Quantity, Remainder
from exidyn.identification.diagnosis.findings.diagnosis import Moment
from exidyn.identification.diagnosis.runs.usable import usable
from exidyn.identification.errors import RobotWarning
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.pages.diagnosis_document import report_html
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import Signal
from exidyn.identification.robot_files.effect_rows import parse_findings
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.robot_files.robot_text import model_text

from ...parts.pages.report_pages import Page
from ...parts.small.small_diagnosis import (
    as_finding,
    diagnosis,
    instead,
    nominal_model,
    recording,
    recordings,
)
from ...parts.small.two_joint_files import of_another_arm, write

pytestmark = pytest.mark.slow

LINK = """<link name="{name}"><inertial><origin xyz="0.2 0.01 0.03"/><mass value="5"/>
<inertia ixx="0.05" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{x} 0 0"/><axis xyz="0 1 0"/>
<limit lower="-2.5" upper="2.5" effort="200" velocity="3"/></joint>"""
URDF = "".join(
    [
        '<robot name="two joints"><link name="base"/>',
        LINK.format(name="upper"),
        LINK.format(name="lower"),
        JOINT.format(name="shoulder", parent="base", child="upper", x=0),
        JOINT.format(name="elbow", parent="upper", child="lower", x=0.4),
        "</robot>",
    ]
)
"""The small arm as a manufacturer gives it: no friction, no gains, no tolerances."""


@pytest.fixture
def runs(tmp_path):
    """Paths of a nominal robot, and of its runs with their roles in them."""
    robot = tmp_path / "robot.toml"
    robot.write_text(model_text(nominal_model()))
    return [str(robot), *write(tmp_path, *recordings())]


def test_a_spring_that_the_model_lacks_is_named_simulated_and_fitted(runs, tmp_path, capsys):
    out, answers = tmp_path / "out", tmp_path / "answers.json"
    answers.write_text('{"other": {"findings": []}}')
    assert main(["diagnose", *runs, "--output", str(out), "--answer", str(answers)]) == 0
    page = capsys.readouterr().out
    assert "- Joint 2 (elbow) has a spring that the model does not have" in page
    assert "simulated," in page
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


def answering(monkeypatch, answer):
    """Let the command answer with a diagnosis that needs no search."""
    monkeypatch.setattr(diagnose_command, "diagnose", answer)


def test_quick_json_has_neither_simulation_nor_fit(runs, tmp_path, monkeypatch, capsys):
    answering(monkeypatch, lambda *_, **__: diagnosis())
    assert main(["diagnose", *runs, "--quick", "--json", "-", "--output", str(tmp_path / "out")]) == 0
    table = json.loads(capsys.readouterr().out)
    assert table["held_out"] == ["validate2"]
    assert "simulated" not in table
    assert not (tmp_path / "out" / "fit.json").exists()


def test_models_to_distinguish_are_written_where_the_words_state(tmp_path, monkeypatch, capsys, runs):
    one = diagnosis().findings[0]
    both = replace(diagnosis(), findings=(replace(one, alternatives=(instead("torque_ripple", 1),)),))
    answering(monkeypatch, lambda *_, **__: both)
    out = tmp_path / "out"
    assert main(["diagnose", *runs, "--quick", "--output", str(out)]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert f"exidyn excite {out}/found.toml --against {out}/instead-1.toml" in text
    assert "Ks2" in read_model(out / "found.toml").names
    assert "Ks2" not in read_model(out / "instead-1.toml").names


def test_the_model_found_is_written_without_alternatives_and_reports_what_it_cannot_hold(tmp_path):
    other = instead("current_crosstalk", None)
    leak = replace(diagnosis(), findings=(as_finding(other),), undecided=(), budget=None, located=())
    [spring] = diagnosis().findings
    sure = replace(diagnosis(), findings=(replace(spring, alternatives=()),))
    for one, lacking in ((sure, False), (leak, True)):
        written = write_diagnosis(replace(one, changes=()), None, None, tmp_path)
        assert tmp_path / "found.toml" in written
        assert tmp_path / "instead-1.toml" not in written
        [row] = parse_findings(tomllib.loads((tmp_path / "found.toml").read_text()))
        assert row.effect == ("current_crosstalk" if lacking else "joint_spring")
        assert row.in_model != lacking
        assert ("Ks2" in read_model(tmp_path / "found.toml").names) != lacking


def test_a_bare_urdf_gets_its_model_too(tmp_path, capsys):
    urdf = tmp_path / "two_joints.urdf"
    urdf.write_text(URDF)
    paths = [tmp_path / f"{run.name}.csv" for run in recordings()[::2]]
    for path, run in zip(paths, recordings()[::2], strict=True):
        path.write_text(_table(run))
    given = [str(urdf), str(paths[0]), "--validate", str(paths[1]), "--quick"]
    assert main(["diagnose", *given, "--output", str(tmp_path / "out")]) == 0
    # Without priors the data do not determine each value: those below zero are warnings when it is read.
    with pytest.warns(RobotWarning, match="it is at least 0"):
        assert read_model(tmp_path / "out" / "found.toml").robot.joints == ("shoulder", "elbow")


def _table(run):
    position = run.signals["position"]
    current = run.signals["current"]
    rows = np.column_stack([position.time, position.values, current.values])
    return "t,q1,q2,tau1,tau2\n" + "\n".join(",".join(f"{one:.9g}" for one in row) for row in rows)


def test_a_simulation_that_diverges_does_not_lose_the_answer(runs, tmp_path, monkeypatch, capsys):
    pushed = replace(
        as_finding(instead("current_offset", 1)), parameters={"Off2": Quantity(1e160, np.nan, "N m")}
    )
    far = replace(diagnosis(), findings=(pushed,), undecided=(), budget=None, located=())
    answering(monkeypatch, lambda *_, **__: far)
    monkeypatch.setattr(diagnose_command, "refit", lambda *_, **__: None)
    out = tmp_path / "out"
    assert main(["diagnose", *runs, "--output", str(out)]) == 0
    table = json.loads((out / "diagnosis.json").read_text())
    assert table["simulated"]["torque_rms_after"][1] is None
    assert np.all(np.isfinite(table["simulated"]["torque_rms_before"]))
    assert "The simulation diverged" in " ".join(capsys.readouterr().out.split())
    assert "The simulation diverged" in Page((out / "report.html").read_text(encoding="utf-8")).words
    assert read_shown(out / "diagnosis.json").forward is not None


def test_filters_are_those_of_identify_and_a_case_has_that_of_its_format(tmp_path, runs, monkeypatch):
    seen = []
    keep = lambda *_, filtering, **__: seen.append(filtering) or diagnosis()  # noqa: E731
    answering(monkeypatch, keep)
    case = diagnose_command.Case("c", nominal_model(), [("identify", recordings()[0])])
    monkeypatch.setattr(diagnose_command, "read_case", lambda _: case)
    (tmp_path / "case").mkdir()
    (tmp_path / "case" / "case.toml").write_text("[case]\nformat = 1\n")
    options = ["--position-cutoff", "9", "--torque-cutoff", "6", "--standstill", "0.02"]
    out = ["--quick", "--output", str(tmp_path / "out")]
    for given in ([*runs, *options], runs, [str(tmp_path / "case")], [str(tmp_path / "case"), *options]):
        assert main(["diagnose", *given, *out]) == 0
    assert seen == [
        Filtering(None, 9.0, 6.0, 0.02),
        Filtering(),
        Filtering(torque_cutoff=COMPARISON_CUTOFF),
        Filtering(None, 9.0, 6.0, 0.02),
    ]


def test_options_give_runs_their_roles(runs, tmp_path, monkeypatch):
    seen = []
    answering(monkeypatch, lambda model, runs, *_, **__: seen.append(runs) or diagnosis())
    robot, one, two, three = runs
    arguments = [robot, one, "--slow", two, "--validate", three, "--payload", one, "--mass", "3"]
    assert main(["diagnose", *arguments, "--quick", "--output", str(tmp_path / "out")]) == 0
    assert [role for role, _ in seen[0]] == ["identify", "slow", "validate", "payload"]
    assert dict(seen[0][3][1].payload.known) == {"M": 3.0}


def test_without_a_robot_the_recordings_bring_theirs(runs, tmp_path, monkeypatch):
    seen = []
    answering(monkeypatch, lambda model, *_, **__: seen.append(model) or diagnosis())
    assert main(["diagnose", *runs[1:], "--quick", "--output", str(tmp_path / "out")]) == 0
    assert seen[0].names == nominal_model().names


def test_what_cannot_be_asked_is_a_warning_and_the_rest_is_answered(tmp_path, capsys):
    first, second, held_out = recordings()
    short = replace(recording("identify", 7), name="short", signals=_first(first, 1.0))
    paths = write(tmp_path, first, second, short)
    assert main(["diagnose", *paths, "--quick", "--output", str(tmp_path / "out")]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "Short is left out: 1.00 s is too short for filters" in text
    assert "No run was held out, so an improved fit proves nothing" in text
    assert "Temperatures were not recorded" in text


def _first(recording, seconds):
    kept = {name: signal.time < seconds for name, signal in recording.signals.items()}
    return {name: signal[kept[name]] for name, signal in recording.signals.items()}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["{robot}"], "a robot without runs"),
        (["{robot}", "{held_out}"], "no run is left to fit: all are held out"),
        (["{robot}", "missing.mcap"], "missing.mcap does not exist"),
        (["{one}", "{other}"], "with other geometry"),
        (["{case}", "{one}"], "not a case folder like the others"),
        (["{case}", "--validate", "{one}"], "--validate cannot be used with a case folder"),
        (["{robot}", "{one}", "--answer", "{robot}"], "is not JSON"),
        (["{robot}", "{one}", "--output", "{one}"], "--output needs a folder"),
    ],
)
def test_what_is_wrong_is_reported_in_one_line(arguments, message, runs, tmp_path, capsys):
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
    assert message in line


def test_a_case_that_fails_does_not_stop_the_others(tmp_path, monkeypatch, capsys):
    for name in ("c1", "c2"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "case.toml").write_text("[case]\nformat = 1\n")
    good = diagnose_command.Case("c2", nominal_model(), [("identify", recordings()[0])])
    read = diagnose_command.read_case
    monkeypatch.setattr(diagnose_command, "read_case", lambda path: good if path.name == "c2" else read(path))
    answering(monkeypatch, lambda *_, **__: replace(diagnosis(), name="c2"))
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
    add_answer(replace(diagnosis(), name="a", findings=(), budget=None), path)
    found = json.loads(path.read_text())
    assert found["a"]["findings"] == []
    assert found["b"]["findings"][0]["effect"] == "joint_spring"


def test_numbers_that_are_none_do_not_spoil_the_files(tmp_path):
    one = diagnosis().findings[0]
    path = tmp_path / "answers.json"
    add_answer(replace(diagnosis(), findings=(replace(one, held_out=np.nan),)), path)
    assert "NaN" not in path.read_text()


def test_temperatures_that_are_there_are_no_warning():
    one = recordings()[0]
    time = one.signals["position"].time
    warm = Signal(time, np.full((len(time), 2), 31.0) + 0.01 * time[:, None])
    for signals, warned in ((one.signals, True), ({**one.signals, "temperature": warm}, False)):
        _, warnings = usable(nominal_model(), [("identify", replace(one, signals=signals))])
        assert any("temperatures were not recorded" in warning for warning in warnings) == warned


def test_the_page_opens_with_the_budget_and_has_what_is_undecided_moments_and_candidates():
    one = diagnosis()
    found = replace(one.findings[0], probability=0.65, alternatives=(instead("torque_ripple", 1, 0.3),))
    run = one.evidence.traces[0]
    moment = Moment(run.name, float(run.time[5]), float(run.time[30]), (1,), np.array([0.0, 1.0, 0.0]), 7.0)
    full = replace(one, findings=(), undecided=(found,), moments=(moment,))
    html = report_html(full)
    page = Page(html)
    sections = [attributes["id"] for tag, attributes in page.elements if tag == "section"]
    assert sections[:3] == ["verdict", "located", "budget"]
    assert {"undecided", "moments", "candidates"} <= set(sections)
    assert "findings" not in sections
    bars = html.partition("residual by cause</title>")[2].partition("</svg>")[0]
    shares = [float(share) for share in re.findall(r": ([\d.e+-]+) %, [\d.e+-]+ N m</title>", bars)]
    assert sum(shares) == pytest.approx(200.0, abs=0.5)  # of two joints, three digits each
    assert 'class="moment"' in html
    assert 'class="moment"' not in report_html(replace(full, moments=()))
    assert "joint spring (65\N{NO-BREAK SPACE}%)" in page.words


def test_the_page_reports_what_is_left_without_a_name():
    left = (Remainder(1, 2.14, 0.999, "position"),)
    page = Page(
        report_html(replace(diagnosis(), findings=(), undecided=(), budget=None, located=(), remainders=left))
    )
    assert "none of the effects that exidyn knows" in page.words
    assert "unexplained" in [attributes.get("id") for tag, attributes in page.elements if tag == "section"]
    bare = Page(report_html(replace(diagnosis(), evidence=None)))
    assert "loaded without the samples of its runs" in bare.words
