"""Two recordings of one run, aligned, and by how much positions are behind commands."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.errors import DifferentRobot, RecordingError
from exidyn.identification.recordings.align import align, aligned, follows_by
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording
from exidyn.identification.recordings.recording import KnownPayload, Recording, Signal

from ...parts.runs.runs import model
from .test_kuka_trace import trace

pytestmark = pytest.mark.numerical

STEP = np.radians(1e-4)
"""What RSI resolves with four decimals."""


def motion(time):
    """From rest to rest within 12 s, nowhere like anywhere else, shape (t, 2)."""
    envelope = np.sin(np.pi * np.clip(time / 12.0, 0, 1)) ** 2
    return envelope[:, None] * np.stack(
        [np.sin(1.3 * time + 0.1 * time**2), 0.6 * np.cos(2.1 * time)], axis=1
    )


def recorded(begin, end, period, zero, noise=0.0, seed=0, **given):
    """What a recorder whose zero lies at `zero` of the motion's time has of it."""
    time = np.arange(begin, end, period)
    values = np.round(motion(time) / STEP) * STEP + np.random.default_rng(seed).normal(
        0, noise, (len(time), 2)
    )
    signals = {"position": Signal(time - zero, values), "current": Signal(time - zero, values)}
    return Recording(given.pop("name", "run"), model(), signals, **given)


def run(**given):
    return recorded(-0.5, 12.5, 0.004, -0.5, payload=KnownPayload("L", (("M", 5.0),)), **given)


@pytest.mark.parametrize(
    ("period", "begin", "end"),
    [(0.001, 2.00137, 8.0), (0.004, -3.0, 5.0), (0.012, 6.0, 16.0), (0.012, -4.0, 20.0)],
)
def test_the_offset_is_found_between_samples(period, begin, end):
    found = align(recorded(begin, end, period, zero=begin, noise=1e-5), run())
    true = begin + 0.5
    assert abs(found.offset - true) < 5 * found.std
    assert 1e-8 < found.std < 2e-5
    assert found.difference.max() < 3e-5
    assert found.overlap == pytest.approx(min(end, 12.5) - max(begin, -0.5), abs=0.03)


def test_the_uncertainty_is_what_repetition_shows():
    errors, stds = [], []
    for seed in range(20):
        found = align(recorded(3.0, 7.0, 0.004, 3.0, noise=1e-4, seed=seed), run())
        errors.append(found.offset - 3.5)
        stds.append(found.std)
    assert 0.6 < np.std(errors) / np.mean(stds) < 1.6


def test_a_recording_on_the_clock_of_a_run_has_what_is_known_of_it():
    one = run(settings={"controller": "KRC"}, trajectory="[plan]", warnings=("old",))
    time = one.signals["position"].time
    host = 1_800_000_000_000_000_000 + np.rint(1e9 * (1 + 1e-5) * time).astype(np.int64)
    one = replace(one, host_time=host)
    one = replace(one, signals={**one.signals, "command": one.signals["position"]})
    other = recorded(-2.0, 14.0, 0.002, -2.0, name="trace", settings={"source": "a.dat"}, warnings=("new",))
    found = aligned(other, one)
    assert found.name == "trace"
    assert (found.payload, found.trajectory, found.warnings) == (one.payload, "[plan]", ("old", "new"))
    assert found.settings["controller"] == "KRC"
    assert found.settings["source"] == "a.dat"
    assert found.settings["aligned to"] == "run"
    assert found.settings["clock offset"].startswith("-1.5000")
    assert len(found.signals["command"]) == len(time)
    place = np.searchsorted(found.signals["position"].time, 6.0)
    assert found.host_time[place] - 1_800_000_000_000_000_000 == pytest.approx(6.00006e9, abs=3e6)
    assert found.host_time[0] < host[0]
    assert np.all(np.diff(found.host_time) > 0)
    np.testing.assert_allclose(
        found.signals["position"].values[place],
        motion(found.signals["position"].time[[place]] - 0.5)[0],
        atol=1e-4,
    )


def test_motions_that_cannot_be_distinguished_are_reported():
    one = run()
    time = np.arange(0, 12, 0.004)
    again = np.stack([np.sin(2 * np.pi * time), np.cos(2 * np.pi * time)], axis=1)

    def periodic(begin, end):
        inside = (time >= begin) & (time < end)
        signals = {"position": Signal(time[inside] - begin, again[inside])}
        return Recording("periodic", model(), signals | {"current": signals["position"]})

    with pytest.raises(RecordingError, match="agree equally well 1.00 s further: the motion repeats itself"):
        align(periodic(3, 8), periodic(0, 12))
    still = replace(one, signals={n: Signal(s.time, np.zeros_like(s.values)) for n, s in one.signals.items()})
    with pytest.raises(RecordingError, match="have no motion in common"):
        align(still, still)
    moved = {n: Signal(s.time, -s.values) for n, s in one.signals.items()}
    with pytest.raises(
        RecordingError, match="limit 0.001: they are different runs, or their joints differ in"
    ):
        align(replace(one, signals=moved), one)
    third = {n: Signal(s.time, np.zeros((len(s), 3))) for n, s in one.signals.items()}
    other = Recording("three", model(3), third)
    with pytest.raises(DifferentRobot, match="is of axis1, axis2, axis3, run of axis1, axis2"):
        align(other, one)
    few = {n: s[:30] for n, s in one.signals.items()}
    with pytest.raises(RecordingError, match="has 30 positions and run 3250; to align them each needs 40"):
        align(replace(one, signals=few), one)


def test_a_trace_is_imported_onto_the_clock_of_its_run(tmp_path, capsys):
    time = np.arange(1.0, 9.0, 0.002)
    axes = np.degrees((motion(time) - [0, 0.2]) * [1, -1])
    for axis in range(2):
        channels = [("Istposition", "°", axes[:, axis], 1.0, 0.0), ("Iststrom", "A", axes[:, axis], 1.0, 0.0)]
        trace(tmp_path / f"Lauf_NextGenDrive#{axis + 1}.dat", 0.002, channels)
    one = run(settings={"driver sign": "1 -1", "driver zero": "0 0.2 rad"})
    write_recording(one, tmp_path / "rsi.mcap")
    given = ["import", str(tmp_path / "Lauf_NextGenDrive#1.dat"), "--output", str(tmp_path)]
    assert main([*given, "--align", str(tmp_path / "rsi.mcap")]) == 0
    assert "payload" in capsys.readouterr().out
    found = read_recording(tmp_path / "Lauf.mcap")
    assert found.payload == one.payload
    assert found.signals["position"].time[0] == pytest.approx(1.5, abs=1e-4)
    assert found.signals["position"].rate == pytest.approx(500.0)
    wrong = run(settings={"driver sign": "1 1"})
    write_recording(wrong, tmp_path / "wrong.mcap")
    assert main([*given, "--align", str(tmp_path / "wrong.mcap")]) == 2
    assert "they are different runs" in capsys.readouterr().err


TIME = np.arange(0.0, 8.0, 0.002)


def way(time):
    return np.column_stack([np.sin(2.0 * time), 0.3 * np.cos(5.0 * time) - 1.0])


@pytest.mark.parametrize("latency", [0.004, 0.0343, 0.21])
def test_it_is_found_beside_noise_a_steady_distance_and_gaps(latency):
    noise = 1e-4 * np.random.default_rng(0).standard_normal((len(TIME), 2))
    position = way(TIME - latency) + noise + [0.02, -0.01]
    position[500:520] = np.nan
    rows = np.delete(np.arange(len(TIME)), slice(1000, 1400))
    found = follows_by(Signal(TIME, way(TIME)), Signal(TIME[rows], position[rows]))
    assert found == pytest.approx(latency, abs=2e-4)


def test_it_is_unknown_at_rest_and_without_commands():
    rest = Signal(TIME, np.ones((len(TIME), 2)))
    assert np.isnan(follows_by(rest, rest))
    assert np.isnan(follows_by(Signal(TIME[:1], way(TIME[:1])), rest))
    assert np.isnan(follows_by(Signal(TIME, way(TIME)), Signal(TIME, np.full((len(TIME), 2), np.nan))))
    assert np.isnan(follows_by(Signal(TIME, way(TIME)), Signal(TIME, way(TIME - 0.5))))
