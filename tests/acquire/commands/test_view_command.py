"""exidyn view: what recordings, fits and diagnoses become in Rerun, and what is refused."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from exidyn.acquire.command_line import REFUSED, main
from exidyn.acquire.commands.view_command import view_of
from exidyn.acquire.files.result_files import NAME, read_shown, write_diagnosis
from exidyn.acquire.views.diagnosis_view import BEFORE
from exidyn.acquire.views.parts import COLORS
from exidyn.acquire.views.suspects import MAX_MOMENTS, moments, windowed_rms
from exidyn.identification.fit.fit_file import read_fit, write_fit
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.recordings.mcap.mcap_file import read_recording
from exidyn.identification.recordings.recording import Event

from ...parts.pages.browser import free_port, headless_browser, wait_for
from ...parts.pages.report_pages import known_fit
from ...parts.pages.rerun_viewer import numbers, read, require_drawn, require_poses, seconds
from ...parts.small.small_diagnosis import nominal_model, recordings, with_remainder
from ...parts.small.two_joint_files import run, write
from ..views.test_live_view import coloured

pytestmark = pytest.mark.clocked(patient=True)

NAMED = "Joint spring of joint 2 (elbow)"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder with run.mcap, fit.json and a diagnosis."""
    folder = tmp_path_factory.mktemp("view")
    happened = (Event(1.5, "stop", "shoulder is too fast"),)
    write(folder, replace(run("run"), events=happened))
    write_fit(known_fit(), folder / "fit.json")
    write_diagnosis(with_remainder(), None, folder)
    return folder


def saved(folder, tmp_path, *names):
    """Chunks of the view of some files."""
    path = tmp_path / "view.rrd"
    assert main(["view", *(str(folder / name) for name in names), "--save", str(path)]) == 0
    return read(path)


@pytest.fixture(scope="module")
def diagnosed(files, tmp_path_factory):
    return saved(files, tmp_path_factory.mktemp("rrd"), "diagnosis.json")


@pytest.fixture(scope="module")
def recorded(files):
    return read_recording(files / "run.mcap")


@pytest.fixture(scope="module")
def chunks(files, tmp_path_factory):
    """What is shown of the recording."""
    return saved(files, tmp_path_factory.mktemp("rrd"), "run.mcap")


def test_a_recording_is_what_was_measured(chunks, recorded):
    for name in ("position", "current"):
        signal, entity = recorded.signals[name], f"/run/{name}/measured"
        np.testing.assert_array_equal(numbers(chunks, entity).reshape(-1, 2), signal.values)
        np.testing.assert_allclose(seconds(chunks, entity), signal.time, atol=2e-9)
    (text,) = chunks["/run/inside", "TextDocument:text"][0].to_pylist()[0]
    assert "two joints: shoulder, elbow" in text
    (words,) = chunks["/run/events/stop", "TextLog:text"][0].to_pylist()[0]
    assert words == "1.50 s  stop: shoulder is too fast"


def test_velocity_that_was_not_recorded_is_that_of_the_positions(chunks, recorded):
    assert "velocity" not in recorded.signals
    motion = prepare(recorded).motion
    time = seconds(chunks, "/run/velocity/measured")
    inside = (time > motion.time[0]) & (time < motion.time[-1])
    found = numbers(chunks, "/run/velocity/measured").reshape(-1, 2)[inside]
    expected = np.stack([np.interp(time[inside], motion.time, v) for v in motion.velocity.T], axis=1)
    np.testing.assert_allclose(found, expected, atol=0.02 * np.abs(expected).max())


def test_the_arm_moves_as_measured(chunks, recorded):
    signal = recorded.signals["position"]
    at = np.searchsorted(signal.time, seconds(chunks, "/arm in run/moves")[::2] - 1e-6)
    require_poses(chunks, "/arm in run/moves", recorded.robot.kinematics, signal.values[at])


def test_runs_of_one_name_are_distinguished(files, tmp_path, capsys):
    chunks = saved(files, tmp_path, "run.mcap", "run.mcap")
    assert capsys.readouterr().err == f"written: {tmp_path / 'view.rrd'}\n"
    assert ("/run/position/measured", "Scalars:scalars") in chunks
    assert ("/run #2/position/measured", "Scalars:scalars") in chunks


def test_a_fit_predicts_the_recordings_given_with_it(files, tmp_path):
    chunks, fit = saved(files, tmp_path, "fit.json", "run.mcap"), read_fit(files / "fit.json")
    expected = fit.agree(prepare(read_recording(files / "run.mcap"), fit.filtering))
    for joint, name in enumerate(("shoulder", "elbow")):
        found = numbers(chunks, f"/runs/run/torque/{name}/residual")
        np.testing.assert_array_equal(found, expected.residual[:, joint])


def test_a_fit_alone_has_its_parameters_and_the_arm(files, tmp_path):
    chunks = saved(files, tmp_path, "fit.json")
    assert {"/parameters/table", "/parameters/interval", "/arm/moves"} <= {entity for entity, _ in chunks}
    assert not any(entity.startswith("/runs") for entity, _ in chunks)


def test_a_finding_has_its_residual_without_and_with_it(diagnosed, files):
    for trace in with_remainder().evidence.traces:
        slides = trace.weight[:, 1] > 0
        entity = f"/runs/{trace.name}/residuals/{NAMED}"
        before, after = (numbers(diagnosed, f"{entity}/{name}") for name in ("1 before", "2 after"))
        np.testing.assert_allclose(after[slides], trace.after[slides, 1], atol=1e-5)
        np.testing.assert_allclose((before - after)[slides], trace.explained[0, slides, 1], atol=1e-5)
        assert np.all(np.isnan(before[~slides]))
        noise = numbers(diagnosed, f"{entity}/3 noise")[0]
        assert noise == pytest.approx(with_remainder().evidence.noise[1])


def test_a_finding_shows_where_its_torque_is_large(diagnosed):
    for trace in with_remainder().evidence.traces:
        bar = np.isfinite(numbers(diagnosed, f"/runs/{trace.name}/residuals/{NAMED}/4 moments"))
        torque = trace.explained[0, :, 1] * trace.weight[:, 1]
        assert 0.0 < np.mean(bar) < 0.8
        assert np.mean(torque[bar] ** 2) > 2.0 * np.mean(torque[~bar] ** 2)
        begins = seconds(diagnosed, f"/runs/{trace.name}/moments/{NAMED}")
        rising = trace.time[np.flatnonzero(np.diff(bar.astype(int), prepend=0) == 1)]
        np.testing.assert_allclose(begins, rising, atol=2e-9)
        assert len(begins) <= MAX_MOMENTS


def test_a_ball_is_on_the_joint_while_its_finding_shows(diagnosed):
    trace = with_remainder().evidence.traces[0]
    entity = f"/arm in {trace.name}/marks/{NAMED}"
    sizes, times = numbers(diagnosed, entity, "Points3D:radii"), seconds(diagnosed, entity)
    order = np.argsort(times)
    begins = seconds(diagnosed, f"/runs/{trace.name}/moments/{NAMED}")
    np.testing.assert_allclose(times[order][sizes[order] > 0.0], begins, atol=2e-9)
    assert sizes[order][0] == 0.0
    assert sizes[order][-1] == 0.0


def test_what_has_no_name_is_shown_on_its_joint(diagnosed):
    trace = with_remainder().evidence.traces[0]
    slides = trace.weight[:, 0] > 0
    found = numbers(
        diagnosed, f"/runs/{trace.name}/residuals/Unexplained torque of joint 1 (shoulder)/1 before"
    )
    np.testing.assert_allclose(found[slides], trace.before[slides, 0], atol=1e-5)


def test_words_have_the_numbers_of_the_diagnosis(diagnosed, files):
    texts = {
        name: diagnosed[f"/texts/{name}", "TextDocument:text"][0].to_pylist()[0][0]
        for name in ("verdict", "findings", "parameters")
    }
    table = json.loads((files / "diagnosis.json").read_text())
    assert all(line in texts["verdict"] for line in table["verdict"])
    spring = with_remainder().findings[0].parameters["Ks2"]
    match = re.search(r"\| +Ks2 \| ([\d.]+) \| ([\d.]+) \| N m/rad \|", texts["parameters"])
    assert match is not None
    assert float(match[1]) == pytest.approx(spring.value, abs=0.5 * spring.std)
    assert float(match[2]) == pytest.approx(1.96 * spring.std, rel=0.3)
    assert NAMED in texts["findings"]


def test_a_diagnosis_without_traces_has_words(files, tmp_path):
    shutil.copy(files / "diagnosis.json", tmp_path / "moved.json")
    assert main(["view", str(tmp_path / "moved.json"), "--save", str(tmp_path / "view.rrd")]) == 0
    entities = {entity for entity, _ in read(tmp_path / "view.rrd")}
    assert {"/texts/verdict", "/texts/findings", "/texts/budget"} <= entities
    assert not any(entity.startswith("/runs") for entity in entities)


def test_moments_are_few_and_where_a_torque_is_spent():
    time = np.arange(0.0, 100.0, 0.05)
    torque = np.where((time > 20.0) & (time < 23.0), 8.0, np.where(time > 60.0, 1.0, 0.0))
    (one,) = moments(time, torque)
    assert one.begin == pytest.approx(20.0, abs=0.3)
    assert one.end == pytest.approx(23.0, abs=0.3)
    assert one.over_noise == pytest.approx(8.0, rel=0.1)
    spikes = np.where(np.arange(len(time)) % 80 < 4, 5.0, 0.0)
    found = moments(time, spikes)
    assert len(found) == MAX_MOMENTS
    assert found == sorted(found)
    assert moments(time, np.zeros_like(time)) == []


def test_lasting_residuals_are_means_of_what_slides():
    time = np.arange(0.0, 10.0, 0.05)
    weight = np.stack([time > 5.0, np.zeros(len(time))], axis=1).astype(float)
    found = windowed_rms(time, np.full((len(time), 2), 3.0), weight)
    np.testing.assert_allclose(found[time > 5.5, 0], 3.0)
    assert np.all(np.isnan(found[time < 4.5, 0]))
    assert np.all(np.isnan(found[:, 1]))


def test_traces_that_were_cut_off_are_refused(files, tmp_path, capsys):
    shutil.copy(files / "diagnosis.json", tmp_path)
    (tmp_path / NAME).write_bytes((files / NAME).read_bytes()[:2000])
    assert main(["view", str(tmp_path / "diagnosis.json"), "--save", str(tmp_path / "view.rrd")]) == REFUSED
    assert "is not a file of traces, or was cut off" in capsys.readouterr().err


def test_traces_are_those_of_the_evidence(files):
    found = read_shown(files / "diagnosis.json")
    assert found.model.names == nominal_model().names
    assert [trace.role for trace in found.traces] == ["validate", "identify", "identify"]
    for ours, theirs in zip(found.traces, with_remainder().evidence.traces, strict=True):
        assert ours.name == theirs.name
        np.testing.assert_array_equal(ours.time, theirs.time)
        np.testing.assert_allclose(ours.explained, theirs.explained, rtol=1e-6)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["missing.mcap"], "missing.mcap does not exist"),
        (["fit.json", "diagnosis.json"], "give one fit or one diagnosis at a time"),
        (["diagnosis.json", "run.mcap"], "contains its runs"),
        (["list.json"], "neither a fit nor a diagnosis"),
        (["other.json"], "has format 9; this version reads 2; update exidyn"),
        (["older.json"], "has format 1; this version reads 2; write it anew with exidyn diagnose RUN"),
        (["half.json"], "is not JSON, or was cut off"),
        (["bare.json"], "key 'name' is missing"),
        (["run.mcap", "--serve", "nowhere"], "--serve nowhere"),
        (["run.mcap", "--save", "no/folder.rrd"], "there is no folder"),
    ],
)
def test_what_cannot_be_shown_is_reported_in_one_line(names, message, files, tmp_path, capsys):
    texts = {name: f'{{"exidyn_diagnosis": {n}}}' for name, n in (("older", 1), ("bare", 2), ("other", 9))}
    texts |= {"list": "[]", "half": "{"}
    for name, text in texts.items():
        (files / f"{name}.json").write_text(text)
    given = [str(files / name) if "." in name and "/" not in name else name for name in names]
    if len({"--serve", "--save"} & set(given)) == 0:
        given += ["--save", str(tmp_path / "view.rrd")]
    assert main(["view", *given]) == REFUSED
    [line] = capsys.readouterr().err.splitlines()
    assert message in line


@pytest.mark.parametrize(
    ("name", "count"),
    [
        # position, tracking error, velocity, current, residual, arm, events, what is inside
        ("run.mcap", 8),
        # of each of three runs: two findings, every joint before and after, arm, moments; and four texts
        ("diagnosis.json", 3 * 6 + 4),
    ],
)
def test_window_shows_every_view_without_complaint(name, count, files, monkeypatch):
    position = read_recording(files / "run.mcap").signals["position"]
    runs = with_remainder().evidence.traces if "diagnosis" in name else [position]
    end = max(run.time[-1] for run in runs)
    require_drawn(lambda: main(["view", str(files / name)]), end, count, monkeypatch)


def gone(group):
    """Whether no process of a group is left."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return True
    return False


def test_browser_shows_a_diagnosis_until_it_is_ended(files, tmp_path):
    port, pictures = free_port(), []
    command = [sys.executable, "-m", "exidyn.acquire.command_line", "view", str(files / "diagnosis.json")]
    process = subprocess.Popen(
        [*command, "--serve", f"127.0.0.1:{port}"],
        stderr=subprocess.PIPE,
        start_new_session=True,
        # Where tests run in the background, Ctrl-C is ignored, and children inherit that.
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )
    try:
        with headless_browser(tmp_path / "profile") as browser:
            line = process.stderr.readline().decode()
            browser.open(line.split()[1] + "&renderer=webgl", width=1000, height=640)

            def drawn():
                try:
                    pictures.append(browser.picture())
                except AssertionError:  # as long as the page is being exchanged for the one asked for
                    return False
                return coloured(pictures[-1])[COLORS.index(BEFORE)] > 100

            found = wait_for(drawn, 150.0)
            (tmp_path / "browser.png").write_bytes(pictures[-1])
            assert found
        os.kill(process.pid, signal.SIGINT)
        assert process.wait(60.0) == 0
        assert wait_for(lambda: gone(process.pid), 20.0)
    finally:
        process.kill()
        process.wait()
        process.stderr.close()


def test_colours_of_joints_are_those_of_the_live_view(chunks):
    ((first, second),) = chunks["/run/position/measured", "SeriesLines:colors"][0].to_pylist()
    expected = [int.from_bytes(bytes([*colour, 255])) for colour in COLORS[:2]]
    assert [first, second] == expected


def test_recordings_of_a_case_are_shown_together(files):
    paths = write(files, *recordings()[:2])
    assert view_of([files / path for path in paths]).kind == "recording"


def test_a_viewer_that_takes_too_long_is_reported_in_one_line(files, monkeypatch, capsys, tmp_path):
    def late(self, *, timeout_sec):
        raise RuntimeError("Flush timed out")

    monkeypatch.setattr("rerun.RecordingStream.flush", late)
    assert main(["view", str(files / "run.mcap"), "--save", str(tmp_path / "run.rrd")]) == REFUSED
    [line] = capsys.readouterr().err.splitlines()
    assert line.startswith("exidyn: the viewer did not receive all data within 60 s: Flush timed out.")
