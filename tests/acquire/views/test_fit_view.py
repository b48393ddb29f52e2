"""The Rerun recording of a fit: read back, its values are the fit's own; a viewer takes all of it."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.views import viewers
from exidyn.acquire.views.fit_view import CAPPED, fit_view
from exidyn.acquire.views.live_view import Targets
from exidyn.identification.fit.verdict import verdict

from ...parts.pages.report_pages import known_fit
from ...parts.pages.rerun_viewer import numbers, require_drawn, require_poses, saved, seconds, text_of


@pytest.fixture(scope="module")
def fit():
    return known_fit()


@pytest.fixture(scope="module")
def chunks(fit, tmp_path_factory):
    return saved(fit_view(fit), tmp_path_factory.mktemp("view") / "fit.rrd")


def runs_of(fit):
    return [*fit.agreement, *fit.validation]


def test_torques_read_back_are_those_of_the_fit(chunks, fit):
    for run in runs_of(fit):
        for k, joint in enumerate(fit.model.robot.joints):
            for name in ("measured", "predicted", "residual"):
                entity = f"/runs/{run.run}/torque/{joint}/{name}"
                np.testing.assert_array_equal(numbers(chunks, entity), getattr(run, name)[:, k])
                np.testing.assert_allclose(seconds(chunks, entity), run.time, atol=2e-9)


def test_residual_over_noise_reads_back(chunks, fit):
    for run in runs_of(fit):
        found = numbers(chunks, f"/runs/{run.run}/over_noise").reshape(-1, 2)
        np.testing.assert_array_equal(found, run.residual / run.noise)


def test_arm_moves_as_in_the_run(chunks, fit):
    for run in runs_of(fit):
        require_poses(chunks, f"/arm in {run.run}/moves", fit.model.robot.kinematics, run.position)


def test_texts_hold_verdict_and_every_parameter(chunks, fit):
    assert all(line in text_of(chunks, "/verdict") for line in verdict(fit))
    lines = [line.split("|") for line in text_of(chunks, "/parameters/table").splitlines()]
    rows = {cells[1].strip(): cells for cells in lines if len(cells) > 7}
    for name, expected, std in zip(fit.names, fit.estimate.values, fit.estimate.std, strict=True):
        value, half = (float(cell.replace("\N{MINUS SIGN}", "-")) for cell in rows[name][2:4])
        assert value == pytest.approx(expected, rel=1e-3)
        assert half == pytest.approx(1.96 * std, rel=0.051)


def test_bars_are_the_intervals_in_per_cent(chunks, fit):
    (bars,) = chunks["/parameters/interval", "BarChart:values"][0].to_pylist()[0]
    percent = 196.0 * fit.estimate.std / np.abs(fit.estimate.values)
    buffer = bars["buffer"]
    found = np.array(buffer if isinstance(buffer, list) else next(iter(buffer.values())))
    np.testing.assert_allclose(found.ravel(), np.minimum(percent, CAPPED), rtol=1e-12)


def test_fit_without_samples_saves_what_it_has(fit, tmp_path):
    chunks = saved(fit_view(replace(fit, agreement=(), validation=())), tmp_path / "bare.rrd")
    entities = {entity for entity, _ in chunks}
    assert {"/verdict", "/parameters/table", "/parameters/interval", "/arm/moves"} <= entities
    assert not any(entity.startswith("/runs") for entity in entities)


def test_run_without_positions_has_no_arm(fit, tmp_path):
    still = replace(fit, agreement=(), validation=(replace(fit.validation[0], position=None),))
    entities = {entity for entity, _ in saved(fit_view(still), tmp_path / "still.rrd")}
    assert any(entity.startswith("/runs") for entity in entities)
    assert not any(entity.startswith("/arm") for entity in entities)


def test_viewer_shows_every_view_without_complaint(fit, monkeypatch):
    end = max(run.time[-1] for run in runs_of(fit))
    # a plot a joint, the ratio and the arm of each run, and three views beside them
    expected = len(runs_of(fit)) * 4 + 3
    view = fit_view(fit)
    picture = require_drawn(lambda: viewers.show(view, Targets(view=True)), end, expected, monkeypatch)
    width, height = struct.unpack(">II", picture[16:24])
    assert min(width, height) >= 600
