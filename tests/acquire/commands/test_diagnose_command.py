"""exidyn diagnose: what it reads, prints, writes and refuses."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.commands import diagnose_command
from exidyn.acquire.files.result_files import write_diagnosis
from exidyn.identification.diagnosis import Remainder
from exidyn.identification.diagnosis.findings.diagnosis import Moment
from exidyn.identification.diagnosis.runs.usable import usable
from exidyn.identification.errors import RobotWarning
from exidyn.identification.fit.fit_file import read_fit
from exidyn.identification.pages.diagnosis_document import report_html
from exidyn.identification.preparation.prepare import Filtering
from exidyn.identification.recordings.recording import Signal
from exidyn.identification.robot_files.effect_rows import parse_findings
from exidyn.identification.robot_files.robot_file import read_model, urdf_text
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
from ...parts.tutorial import PRINTED, STIFFNESS

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """The option of a nominal robot, and paths of its runs with their roles in them."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "robot.toml").write_text(model_text(nominal_model()))
    return ["--robot", str(folder / "robot.toml"), *write(folder, *recordings())]


def test_a_spring_that_the_model_lacks_is_named_and_fitted(tutorial):
    page = (tutorial / PRINTED).read_text()
    assert "- Joint 2 (elbow) has a spring that the model does not have" in page
    table = json.loads((tutorial / "diagnosis" / "diagnosis.json").read_text())
    assert [finding["effect"] for finding in table["findings"]] == ["joint_spring"]
    assert read_fit(tutorial / "diagnosis" / "fit.json").value("Ks2") == pytest.approx(STIFFNESS, rel=0.05)
    report = Page((tutorial / "diagnosis" / "report.html").read_text(encoding="utf-8"))
    assert {"verdict", "budget", "findings", "joints"} <= sections_of(report)


def sections_of(page):
    return {attributes["id"] for tag, attributes in page.elements if tag == "section"}


def answering(monkeypatch, answer):
    """Let the command answer with a diagnosis that needs no search."""
    monkeypatch.setattr(diagnose_command, "diagnose", answer)


def test_quick_json_has_no_fit(runs, tmp_path, monkeypatch, capsys):
    answering(monkeypatch, lambda *_, **__: diagnosis())
    assert main(["diagnose", *runs, "--quick", "--json", "-", "--output", str(tmp_path / "out")]) == 0
    table = json.loads(capsys.readouterr().out)
    assert table["held_out"] == ["validate2"]
    assert not (tmp_path / "out" / "fit.json").exists()


def test_models_to_distinguish_are_written_where_the_words_state(tmp_path, monkeypatch, capsys, runs):
    one = diagnosis().findings[0]
    open_ = replace(one, probability=0.6, alternatives=(instead("torque_ripple", 1),))
    both = replace(diagnosis(), findings=(), undecided=(open_,), suspicions=())
    answering(monkeypatch, lambda *_, **__: both)
    out = tmp_path / "out"
    assert main(["diagnose", *runs, "--quick", "--output", str(out)]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert f"exidyn excite {out}/found.toml --against {out}/instead-1.toml" in text
    assert "Ks2" in read_model(out / "found.toml").names
    assert "Ks2" not in read_model(out / "instead-1.toml").names


def test_the_model_found_is_written_without_alternatives_and_reports_what_it_cannot_hold(tmp_path):
    other = instead("current_crosstalk", None)
    leak = replace(diagnosis(), findings=(as_finding(other),), undecided=(), budget=None)
    [spring] = diagnosis().findings
    sure = replace(diagnosis(), findings=(replace(spring, alternatives=()),))
    for one, lacking in ((sure, False), (leak, True)):
        written = write_diagnosis(one, None, tmp_path)
        assert tmp_path / "found.toml" in written
        assert tmp_path / "instead-1.toml" not in written
        [row] = parse_findings(tomllib.loads((tmp_path / "found.toml").read_text()))
        assert row.effect == ("current_crosstalk" if lacking else "joint_spring")
        assert row.in_model != lacking
        assert ("Ks2" in read_model(tmp_path / "found.toml").names) != lacking


def test_a_bare_urdf_gets_its_model_too(tmp_path, capsys):
    """As a manufacturer gives it: no friction, no gains, no tolerances."""
    urdf = tmp_path / "two_joints.urdf"
    urdf.write_text(urdf_text(nominal_model()))
    for name, run in (("run", recording("identify", 0, length=8.0)), ("other", recordings()[2])):
        position, current = run.signals["position"], run.signals["current"]
        rows = np.column_stack([position.time, position.values, current.values])
        path, head = tmp_path / f"{name}.csv", "t,q1,q2,tau1,tau2"
        np.savetxt(path, rows, "%.9g", ",", header=head, comments="")
    given = [
        "--robot",
        str(urdf),
        str(tmp_path / "run.csv"),
        "--validate",
        str(tmp_path / "other.csv"),
        "--quick",
    ]
    assert main(["diagnose", *given, "--output", str(tmp_path / "out")]) == 0
    # Without priors the data do not determine each value: those below zero are warnings when it is read.
    with pytest.warns(RobotWarning, match="it is at least 0"):
        assert read_model(tmp_path / "out" / "found.toml").robot.joints == ("shoulder", "elbow")


def test_options_give_runs_their_roles_and_filters(runs, tmp_path, monkeypatch):
    seen = []
    answering(monkeypatch, lambda *given, filtering, **_: seen.append((*given, filtering)) or diagnosis())
    _, robot, one, two, three = runs
    arguments = [one, "--robot", robot, "--slow", two, "--validate", three, "--payload", one, "--mass", "3"]
    filters = ["--position-cutoff", "9", "--torque-cutoff", "6", "--standstill", "0.02"]
    for given in ([*arguments, *filters], runs[2:]):
        assert main(["diagnose", *given, "--quick", "--output", str(tmp_path / "out")]) == 0
    assert [role for role, _ in seen[0][1]] == ["identify", "slow", "validate", "payload"]
    assert dict(seen[0][1][3][1].payload.known) == {"M": 3.0}
    assert [given[-1] for given in seen] == [Filtering(None, 9.0, 6.0, 0.02), Filtering()]
    assert seen[1][0].names == nominal_model().names  # the recordings bring their robot


def test_what_cannot_be_asked_is_a_warning_and_the_rest_is_answered(tmp_path, capsys):
    first = recording("identify", 0, length=8.0)
    cut = {name: signal[signal.time < 1.0] for name, signal in first.signals.items()}
    paths = write(tmp_path, first, replace(first, name="short", signals=cut))
    assert main(["diagnose", *paths, "--quick", "--output", str(tmp_path / "out")]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "Short is left out: 1.00 s is too short for filters" in text
    assert "No run was held out, so an improved fit proves little" in text
    assert "Temperatures were not recorded" in text
    time = first.signals["position"].time
    warm = Signal(time, np.full((len(time), 2), 31.0) + 0.01 * time[:, None])
    _, warnings = usable(
        nominal_model(), [("identify", replace(first, signals={**first.signals, "temperature": warm}))]
    )
    assert not any("temperatures were not recorded" in warning for warning in warnings)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--robot", "{robot}", "{held_out}"], "no run is left to fit: all are held out"),
        (["--robot", "{robot}", "missing.mcap"], "missing.mcap does not exist"),
        (["{one}", "{other}"], "with other geometry"),
        (["{one}", "--output", "{one}"], "--output needs a folder"),
    ],
)
def test_what_is_wrong_is_reported_in_one_line(arguments, message, runs, tmp_path, capsys):
    [other] = write(tmp_path, of_another_arm(recordings()[0]))
    names = dict(zip(("robot", "one", "two", "held_out"), runs[1:], strict=True)) | {"other": other}
    given = [argument.format(**names) for argument in arguments]
    if "--output" not in given:
        given += ["--output", str(tmp_path / "out")]
    assert main(["diagnose", *given]) == REFUSED
    [line] = [line for line in capsys.readouterr().err.splitlines() if line.startswith("exidyn: ")]
    assert message in line


def test_a_robot_among_the_runs_is_refused_with_the_command_to_type(capsys):
    typed = "diagnose robot.toml a.mcap --slow s.mcap --payload b.mcap --mass 8 --com 0.1 0 0"
    with pytest.raises(SystemExit) as ended:
        main(typed.split())
    assert ended.value.code == REFUSED
    corrected = "diagnose a.mcap --slow s.mcap --payload b.mcap --mass 8 --com 0.1 0 0 --robot robot.toml"
    assert f"robot.toml is a robot, not a run; type: exidyn {corrected}" in capsys.readouterr().err


def test_the_page_opens_with_the_verdict_and_has_what_is_undecided_moments_and_candidates():
    plain = diagnosis()
    finding = replace(plain.findings[0], probability=0.65, alternatives=(instead("torque_ripple", 1, 0.3),))
    run = plain.evidence.traces[0]
    moment = Moment(run.name, float(run.time[5]), float(run.time[30]), (1,), np.array([0.0, 1.0, 0.0]), 7.0)
    full = replace(plain, findings=(), undecided=(finding,), moments=(moment,))
    html = report_html(full)
    page = Page(html)
    sections = [attributes["id"] for tag, attributes in page.elements if tag == "section"]
    assert sections[:2] == ["verdict", "budget"]
    assert "undecided" in sections
    assert "findings" not in sections
    shares = [value for row in page.rows["budget"] if len(row) > 1 for value in row[1][1]]
    assert np.sum(shares) == pytest.approx(200.0, abs=4.0)  # of two joints, without parts below 1 %
    assert 'class="moment"' in html
    assert 'class="moment"' not in report_html(replace(full, moments=()))
    assert "joint spring 65\N{NO-BREAK SPACE}%" in page.words


def test_the_page_reports_what_is_left_without_a_name():
    left = (Remainder(1, 2.14, 0.999, "position"),)
    nothing = replace(diagnosis(), findings=(), undecided=(), suspicions=(), budget=None, remainders=left)
    page = Page(report_html(nothing))
    assert "none of the effects that exidyn knows" in page.words
    assert "Joint 2 (elbow): part of it depends on position" in page.words
    bare = Page(report_html(replace(diagnosis(), evidence=None)))
    assert "loaded without the samples of its runs" in bare.words
