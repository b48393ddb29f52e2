"""External torques live: what is drawn is what the observer estimates, and the view never delays reading."""

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.acquire.run.frames import ContactRows
from exidyn.acquire.terminal.live_contact import LiveContact
from exidyn.acquire.views.contact_view import EVENTS, EXTERNAL, FORCE, LEAST, LONGEST, weight
from exidyn.acquire.views.live_view import CONTACT_PROCESS, Targets, start_view
from exidyn.acquire.views.parts import ARM, reach
from exidyn.drivers import Sample
from exidyn.identification.contact.contact import contact
from exidyn.identification.fit.fit_file import write_fit

from ...parts.pages.rerun_viewer import numbers, numbers_nested, read, seconds
from ...parts.small import small_fit, two_joint_files

pytestmark = pytest.mark.clocked(patient=True)

PIECE = 37


@pytest.fixture(scope="module")
def free():
    return [two_joint_files.run(f"free{k}", 3 + k, 9 + k) for k in range(2)]


def samples(recording):
    """Samples of a driver that measures what a run has."""
    position, current = recording.signals["position"], recording.signals["current"]
    unknown = np.full(2, np.nan)
    return [
        Sample(10**9, round(1e9 * (t + 7.0)), q, unknown, i, unknown, unknown)
        for t, q, i in zip(position.time, position.values, current.values, strict=True)
    ]


class Sink(list):
    """A sink that collects its frames."""

    put = list.append


def watch(free, shown):
    """A watched arm that lifts 3 kg after 8 s and puts them down 4 s later."""
    before, loaded = (samples(run) for run in (two_joint_files.run("loaded", 1, 2), two_joint_files.loaded()))
    received = [*before[:2000], *loaded[2000:3000], *before[3000:]]
    live = LiveContact(small_fit.fit(), free, "", 1.0)
    live.show([shown])
    for start in range(0, len(received), PIECE):
        live.add(received[start : start + PIECE])
    return live


@pytest.fixture(scope="module")
def chunks(free, tmp_path_factory):
    path = tmp_path_factory.mktemp("live") / "contact.rrd"
    (view,) = start_view(Targets(save=path), CONTACT_PROCESS)
    with view:
        watch(free, view)
    assert not view.failure
    assert not view.dropped
    return read(path)


def test_torques_and_thresholds_are_those_of_the_recording(chunks, free):
    offline = contact(small_fit.fit(), two_joint_files.run("loaded", 1, 2), free)
    shown = seconds(chunks, f"/{EXTERNAL}/elbow/torque")
    np.testing.assert_allclose(np.diff(shown), 0.02, atol=0.0041)  # 50 a second of 250 are drawn
    early = (shown > 0.3) & (shown < 7.9)
    at = np.searchsorted(offline.estimates.time, shown[early] - 1e-4)
    torque = numbers(chunks, f"/{EXTERNAL}/elbow/torque")[early]
    np.testing.assert_allclose(torque, offline.estimates.torque[at, 1], atol=1e-4)
    limits = numbers(chunks, f"/{EXTERNAL}/elbow/threshold").reshape(-1, 2)
    expected = offline.threshold.torque(offline.estimates)[at, 1]
    np.testing.assert_allclose(limits[early], np.column_stack([expected, -expected]), rtol=1e-4)


def test_force_and_its_arrow_appear_with_the_weight(chunks):
    time, force = seconds(chunks, f"/{FORCE}"), numbers(chunks, f"/{FORCE}").reshape(-1, 3)
    size = np.linalg.norm(force, axis=1)
    held = (time > 9.0) & (time < 11.9)
    assert np.median(size[held]) > 10.0 * np.nanmedian(size[time < 7.9])
    arrows = numbers_nested(chunks, f"/{ARM}/{FORCE}", "Arrows3D:vectors", 3)
    length = np.linalg.norm(arrows, axis=1) / reach(small_fit.fit().model)
    assert length.max() == pytest.approx(LONGEST)
    drawn = seconds(chunks, f"/{ARM}/{FORCE}")
    usual = size[np.searchsorted(time, drawn[0] - 1e-6)]
    assert length[0] == pytest.approx(LONGEST * usual / (LEAST * weight(small_fit.fit().model)), rel=1e-5)


def test_contacts_are_events_with_begin_and_end(chunks):
    texts = {kind: chunks[f"/{EVENTS}/{kind}", "TextLog:text"] for kind in ("contact", "end of contact")}
    begun, ended = (
        " ".join(str(row) for part in parts for row in part.to_pylist()) for parts in texts.values()
    )
    assert "contact: " in begun
    assert "elbow, peak 23.0 N m" in ended
    begin, end = (seconds(chunks, f"/{EVENTS}/{kind}") for kind in texts)
    assert 8.0 < begin[0] < 8.3
    assert 12.0 < end[-1] < 12.5


def test_without_a_threshold_there_are_torques_only():
    shown = Sink()
    live = LiveContact(small_fit.fit(), [], "", 1.0)
    live.show([shown])
    live.add(samples(two_joint_files.run("loaded", 1, 2))[:500])
    rows = ContactRows.read([frame[5:] for frame in shown[1:]])
    assert len(rows.time) == 100
    assert np.isnan(rows.limit).all()
    assert np.isfinite(rows.torque[-50:]).all()
    assert np.isfinite(rows.force[-50:]).all()


def test_watch_saves_the_view_of_the_mock(tmp_path, monkeypatch, capsys):
    write_fit(small_fit.fit(), tmp_path / "fit.json")
    monkeypatch.chdir(tmp_path)
    arguments = ["--fit", "fit.json", "--driver", "mock", "--length", "2"]
    assert main(["watch", *arguments, "--save", "live.rrd"]) == 0
    assert "written: live.rrd" in capsys.readouterr().err
    chunks = read(tmp_path / "live.rrd")
    shown = seconds(chunks, f"/{EXTERNAL}/shoulder/torque")
    assert len(shown) > 50
    assert np.isfinite(numbers(chunks, f"/{EXTERNAL}/shoulder/torque")[-10:]).all()
    assert (f"/{EXTERNAL}/shoulder/threshold", "time") not in chunks


def test_watch_saves_a_view_of_the_measurements_without_a_fit(tmp_path, capsys):
    file = str(tmp_path / "live.rrd")
    assert main(["watch", "--robot", "cobot", "--driver", "mock", "--length", "2", "--save", file]) == 0
    assert f"written: {file}" in capsys.readouterr().err
    chunks = read(tmp_path / "live.rrd")
    assert len(seconds(chunks, "/position/measured")) > 50
    position = numbers(chunks, "/position/measured").reshape(-1, 6)
    assert np.ptp(position, axis=0) == pytest.approx(np.zeros(6), abs=1e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--view"], "--view, --serve and --save draw the arm; name it with --robot"),
        (["--fit", "fit.json", "--save", "fit.json"], "--save would overwrite a file that is read"),
        (["--fit", "fit.json", "--save", "no/live.rrd"], "there is no folder"),
        (["--fit", "fit.json", "--serve", "here"], r"--serve here: "),
    ],
)
def test_a_view_that_cannot_be_is_refused_before_the_controller_is_opened(
    tmp_path, monkeypatch, arguments, message, capsys
):
    write_fit(small_fit.fit(), tmp_path / "fit.json")
    monkeypatch.chdir(tmp_path)
    assert main(["watch", "--driver", "mock", *arguments]) == 2
    assert message in capsys.readouterr().err
