"""exidyn report: everything on one page, from files, and what is refused."""

import json
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.files.diagnosis_files import NAME, write_diagnosis
from exidyn.acquire.files.report_files import comparison_table, read_comparison, read_shown
from exidyn.acquire.terminal.json_output import json_text
from exidyn.identification.diagnosis.words.diagnosis_file import as_json
from exidyn.identification.diagnosis.words.importance import clearest_joint
from exidyn.identification.fit.fit_file import read_fit, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.pages.diagnosis_document import diagnosis_document
from exidyn.identification.pages.shown import Shown
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.simulation.comparison import compare
from exidyn.identification.simulation.predicted import as_nominal, predicted

from ...identify.simulation.test_compare import made
from ...parts.pages.browser import headless_browser, wait_for
from ...parts.pages.report_pages import Page, known_fit
from ...parts.small.small_diagnosis import nominal_model, recordings, with_remainder
from ...parts.small.two_joint_files import of_another_arm, write

pytestmark = pytest.mark.slow

RUNS = ("identify0.mcap", "identify1.mcap", "validate2.mcap")


@cache
def fit():
    """Of a model that lacks the spring."""
    first, second, other = recordings()
    return identify([first, second], validate=[other], model=nominal_model())


@cache
def comparison():
    return compare(made("sim", seed=1), made("real", 12.0, seed=2))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Recordings, a fit, a diagnosis in a folder of its own, and two comparisons."""
    folder = tmp_path_factory.mktemp("report")
    write(folder, *recordings())
    write_fit(fit(), folder / "fit.json")
    write_diagnosis(with_remainder(), fit(), folder / "diagnosis")
    good = compare(made("better", 12.0, seed=1), made("real", 12.0, seed=2))
    for name, found in (("worse", comparison()), ("better", good)):
        (folder / f"{name}.json").write_text(json_text(comparison_table(found, [])))
    return folder


def page_of(folder, tmp_path, *names):
    path = tmp_path / "report.html"
    assert main(["report", *(str(folder / name) for name in names), "--output", str(path)]) == 0
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def text(files, tmp_path_factory):
    names = (*RUNS, "fit.json", "diagnosis", "worse.json", "better.json")
    return page_of(files, tmp_path_factory.mktemp("page"), *names)


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def headings(page):
    return [attrs["id"] for tag, attrs in page.elements if tag == "section"]


def test_everything_is_on_the_page_in_its_order(page):
    found = headings(page)
    chapters = list(dict.fromkeys(anchor.partition("-")[0] for anchor in found))
    assert chapters == ["verdict", "robot", "runs", "fit", "diagnosis", "fit1", "gained"]
    gained = [anchor.removeprefix("gained-") for anchor in found if anchor.startswith("gained-")]
    assert gained == ["values", "pair", "compared", "compared1"]
    assert {"diagnosis-findings", "diagnosis-joints", "fit-parameters", "fit-runs"} <= set(found)
    assert "Results that this page lacks" not in page.words


def test_it_needs_nothing_from_elsewhere(page, text):
    assert not {tag for tag, _ in page.elements} & {"script", "link", "img", "iframe", "object", "use"}
    assert not re.search(r"https?:|//|url\(|@import|@font-face", text)


def test_links_lead_to_parts_that_are_there_once(page):
    names = [attrs["id"] for _, attrs in page.elements if "id" in attrs]
    links = [attrs["href"] for tag, attrs in page.elements if tag == "a"]
    assert len(names) == len(set(names))
    assert sorted(links) == sorted(f"#{name}" for name in names)


def test_the_verdict_reports_what_is_identified_missing_and_simulated(page):
    text = page.words.partition("Identified dynamics")[2].partition("Recorded runs")[0]
    assert "More than noise is left on elbow" in text
    assert "joint spring: " in text
    assert "unexplained, depends on position" in text
    assert "sim versus real: elbow: current differs by" in text
    assert "better versus real: No joint's current differs by more than noise" in text


def test_a_fit_predicts_the_runs_as_when_it_was_made(page):
    (held_out,) = fit().validation
    for joint, name in enumerate(("shoulder", "elbow")):
        [over, _] = page.row("fit-runs", held_out.run)[2 + joint][1]
        assert over == pytest.approx(held_out.over_noise[joint], rel=1e-9)
        first = next(row for row in page.rows["verdict"] if row and row[0][0] == name)
        assert first[2][1] == [pytest.approx(held_out.over_noise[joint], rel=1e-9)]


def test_robot_and_runs_are_listed_as_they_are(page):
    robot = nominal_model().robot
    row = page.row("robot-joints", "elbow")
    limits = robot.limits
    shown = [limits.position_lower[1], limits.position_upper[1], limits.velocity[1], limits.acceleration[1]]
    assert [cell[1] for cell in row[2:6]] == [[value] for value in shown]
    assert row[7][1] == [robot.gear_ratio[1]]
    assert page.row("robot-links", "shoulder")[1][1] == [robot.kinematics.inertias[1].mass]
    friction = next(row for row in page.rows["robot-effects"] if row and row[1][0] == "Fv")
    assert friction[3][1][0] == nominal_model().stated["Fv1"].value
    for recording in recordings():
        run = page.row("runs-table", recording.name)
        assert run[2][1] == [pytest.approx(recording.duration)]
    assert [page.row("runs-table", name)[1][0] for name in ("identify0", "validate2")] == [
        "identify",
        "held out",
    ]


def test_comparisons_are_shown_as_they_were_written(page, files):
    read = read_comparison(files / "worse.json")
    for joint, name in enumerate(read.joints):
        rows = [row for row in page.rows["gained-compared"] if row and row[0][0] == name]
        effort = comparison().effort
        assert rows[0][6][1] == [effort.rms[joint] / effort.noise[joint]]
        thirds = np.concatenate([regions.rms[joint] for regions in effort.regions.values()])
        assert [cell[1][0] for cell in rows[-1][1:]] == list(thirds)
    np.testing.assert_array_equal(
        read.effort.regions["load"].edges, comparison().effort.regions["load"].edges
    )


def test_a_diagnosis_reads_back(files):
    ours, theirs = (
        Shown.of(with_remainder(), str(files / "diagnosis")),
        read_shown(files / "diagnosis" / "diagnosis.json"),
    )
    assert diagnosis_document(theirs).sections[0] == diagnosis_document(ours).sections[0]
    assert as_json(theirs.diagnosis) == as_json(ours.diagnosis)
    assert clearest_joint(theirs.diagnosis, theirs.diagnosis.findings[0]) == 1
    assert [trace.name for trace in theirs.traces] == [trace.name for trace in ours.traces]
    for mine, read in zip(ours.traces, theirs.traces, strict=True):
        np.testing.assert_array_equal(read.time, mine.time)
        np.testing.assert_allclose(read.explained, mine.explained, rtol=1e-6, atol=1e-6)


def test_a_fit_alone_brings_its_scores_and_asks_for_the_rest(files, tmp_path):
    page = Page(page_of(files, tmp_path, "fit.json"))
    assert page.row("verdict", "elbow")[2][1] == [fit().validation[0].over_noise[1]]
    assert "More than noise is left on elbow" in page.words
    assert "give the recordings beside fit.json" in page.words
    assert "there is no diagnosis" in page.words
    assert not any(anchor.startswith("gained") for anchor in headings(page))


def test_a_diagnosis_alone_brings_runs_and_robot_and_one_without_samples_only_words(files, tmp_path):
    page = Page(page_of(files, tmp_path, "diagnosis/diagnosis.json"))
    assert {"robot-joints", "runs-motion", "diagnosis-budget"} <= set(headings(page))
    bare = tmp_path / "diagnosis.json"
    bare.write_bytes((files / "diagnosis" / "diagnosis.json").read_bytes())
    page = Page(page_of(tmp_path, tmp_path, "diagnosis.json"))
    assert "traces.npz is not beside diagnosis.json" in page.words
    assert "robot-joints" not in headings(page)
    assert "Joint 2 (elbow) has a spring that the model does not have" in page.words


def test_a_diagnosis_that_found_nothing_brings_no_fit_with_what_was_found(files, tmp_path):
    nothing = replace(with_remainder(), findings=(), budget=None, held_out=())
    nothing = replace(nothing, torque_rms_before=None)
    write_diagnosis(nothing, fit(), tmp_path / "diagnosis")
    (tmp_path / "diagnosis" / "traces.npz").unlink()  # of the spring that was found
    write_fit(fit(), tmp_path / "fit.json")
    page = Page(page_of(tmp_path, tmp_path, "fit.json", "diagnosis"))
    assert "Fit with findings" not in page.words
    assert not any(anchor.startswith("fit1") for anchor in headings(page))


def test_nominal_values_predict_as_the_nominal_model_does():
    run = recordings()[2]
    shown = predicted(as_nominal(fit()), [run])
    given = prepare(replace(run, model=fit().model), fit().filtering)
    torque = given.decimation.apply(fit().model.torque(given.motion, fit().model.nominal_values))
    [held_out] = shown.validation
    apart = np.sqrt(np.mean((held_out.predicted - torque) ** 2, axis=0))
    assert np.all(apart < 1e-2 * np.sqrt(np.mean(torque**2, axis=0)))
    assert np.all(held_out.residual_rms >= 0.99 * fit().validation[0].residual_rms)


def test_bodies_are_known_by_what_is_known_of_them():
    fit = known_fit()
    [known] = [body.known for body in fit.model.payloads.values()]
    loaded = replace(recordings()[0], payload=KnownPayload("other name", known))
    assert not any("unknown to the fit" in warning for warning in predicted(fit, [loaded]).warnings)
    strange = replace(loaded, payload=KnownPayload("tool", (("M", 77.0),)))
    warnings = predicted(fit, [strange]).warnings
    assert any("carries 'tool', which is unknown to the fit" in warning for warning in warnings)


def test_a_diagnosis_with_an_undecided_finding_has_a_report(files, tmp_path):
    table = json.loads((files / "diagnosis" / "diagnosis.json").read_text())
    table |= {"findings": [], "undecided": table["findings"]}
    (tmp_path / "diagnosis.json").write_text(json.dumps(table))
    (tmp_path / NAME).write_bytes((files / "diagnosis" / NAME).read_bytes())
    assert main(["report", str(tmp_path), "--output", str(tmp_path / "report.html")]) == 0
    read = read_shown(tmp_path / "diagnosis.json")
    assert len(read.diagnosis.undecided) == len(read.traces[0].explained) == 1


def test_scores_survive_the_file(tmp_path):
    write_fit(fit(), tmp_path / "fit.json")
    scores = read_fit(tmp_path / "fit.json").scores
    assert [(one.run, one.held_out) for one in scores] == [
        ("identify0", False),
        ("identify1", False),
        ("validate2", True),
    ]
    np.testing.assert_array_equal(scores[2].relative, fit().validation[0].relative)
    assert scores[0].noise_source == fit().agreement[0].noise_source


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["missing.json"], "missing.json does not exist"),
        (["half.json"], "is not JSON, or was cut off"),
        (["list.json"], "list.json is not a file for a report. Valid: fit.json"),
        (["other.json"], "other.json is not a file for a report. Valid: fit.json"),
        (["notes.md"], "notes.md is not a file for a report. Valid: fit.json"),
        (["empty"], "empty contains no files for a report. Valid: fit.json"),
        (["bare.json"], "bare.json: key 'name' is missing"),
        (["late.json"], "late.json has format 9; this version reads 1"),
        (["nofit.json"], "nofit.json: key 'method' is missing"),
        (["flat.json"], "flat.json: mismatch[...]: expected object, got int"),
        (["foreign.json"], "belongs to another diagnosis"),
        (["diagnosis", "again/diagnosis.json"], "give one diagnosis at a time"),
        (["fit.json", "hips.mcap"], "identify0 has hip, elbow: a report is about one arm"),
    ],
)
def test_what_is_no_part_of_a_report_is_reported_in_one_line(names, message, files, tmp_path, capsys):
    table = json.loads((files / "diagnosis" / "diagnosis.json").read_text())
    flat = json.loads((files / "worse.json").read_text()) | {"mismatch": {"position": 3}}
    texts = {
        "half.json": "{", "list.json": "[]", "other.json": '{"a": 1}', "notes.md": "words",
        "bare.json": '{"exidyn_diagnosis": 2}', "late.json": '{"exidyn_comparison": 9}',
        "nofit.json": '{"exidyn_fit": 1}', "flat.json": json.dumps(flat),
        "foreign.json": json.dumps(table | {"findings": [], "budget": None}),
        "again/diagnosis.json": json.dumps(table),
    }  # fmt: skip
    for folder in ("empty", "again"):
        (tmp_path / folder).mkdir()
    for name, words in texts.items():
        (tmp_path / name).write_text(words)
    if "foreign.json" in names:
        (tmp_path / NAME).write_bytes((files / "diagnosis" / NAME).read_bytes())
    if "hips.mcap" in names:
        kinematics = recordings()[0].model.robot.kinematics.copy()
        kinematics.names[1] = "hip"
        one = of_another_arm(recordings()[0])
        robot = replace(one.robot, kinematics=kinematics)
        write_recording(replace(one, model=replace(one.model, robot=robot)), tmp_path / "hips.mcap")
    given = [str((files if (files / name).exists() else tmp_path) / name) for name in names]
    assert main(["report", *given, "--output", str(tmp_path / "report.html")]) == REFUSED
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("exidyn: ")
    assert message in line
    assert not (tmp_path / "report.html").exists()


def test_where_the_page_cannot_be_written_is_reported_before_any_work(files, tmp_path, capsys):
    assert main(["report", str(files / "fit.json"), "--output", str(tmp_path)]) == REFUSED
    assert "--output needs a file" in capsys.readouterr().err
    before = (files / "fit.json").read_bytes()
    assert main(["report", str(files), "--output", str(files / "fit.json")]) == REFUSED
    assert (files / "fit.json").read_bytes() == before


@pytest.mark.parametrize("width", [1366, 390])
def test_nothing_is_wider_than_the_screen(width, text, tmp_path):
    (tmp_path / "report.html").write_text(text, encoding="utf-8")
    measured = (
        "document.readyState == 'complete' && [document.documentElement.scrollWidth, window.innerWidth, "
        "performance.getEntriesByType('resource').length].join()"
    )
    with headless_browser(tmp_path / "profile") as browser:
        browser.open((tmp_path / "report.html").as_uri(), width=width)
        found = wait_for(lambda: browser.call("Runtime.evaluate", expression=measured)["result"]["value"])
    wide, screen, loaded = map(int, found.split(","))
    assert wide <= screen == width
    assert loaded == 0
