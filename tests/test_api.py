"""import exidyn as ex: what a notebook user guesses."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import exidyn as ex
from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.effects import JointSpring, Prior
from exidyn.identification.errors import MissingPackage
from exidyn.identification.recordings.mcap.mcap_file import write_recording
from exidyn.trajectories.plans.plan import Plan

from .parts.plans.plans import fourier
from .parts.runs.parser_files import write_two_traces
from .parts.small import two_joints
from .parts.small.small_diagnosis import nominal_model, recordings

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def runs():
    """Two runs to fit and one held out."""
    return recordings()


@pytest.fixture(scope="module")
def fit(runs):
    return ex.identify(runs[:2], runs[2])


def small_plan():
    return Plan.of(fourier(harmonics=2), nominal_model())


def test_every_name_is_there_and_an_unknown_one_is_refused_with_the_list():
    for name in dir(ex):
        assert getattr(ex, name) is not None
    with pytest.raises(AttributeError, match="It has: .*identify.*__version__"):
        _ = ex.recognise


def test_importing_it_loads_no_arithmetic():
    loaded = "import sys, exidyn; sys.exit('pinocchio' in sys.modules or 'numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", loaded], check=False).returncode == 0


def test_a_robot_is_a_name_a_file_or_a_model(tmp_path):
    cobot = ex.robot("cobot")
    assert ex.robot(cobot) is cobot
    with pytest.raises(ex.api.ExidynError, match="no robot or file called 'robbie'"):
        ex.robot("robbie")


def test_a_run_is_a_recording_or_its_file(runs, tmp_path):
    file = tmp_path / "log.mcap"
    write_recording(runs[0], file)
    assert ex.read(file).duration == runs[0].duration
    first, second = ex.identify(runs[0]), ex.identify([str(file)])
    np.testing.assert_allclose(first.estimate.values, second.estimate.values, rtol=1e-6)


def test_several_runs_are_read_together(tmp_path):
    write_two_traces(tmp_path)
    assert len(ex.read_all(tmp_path, nominal_model())) == 2
    with pytest.raises(ex.api.ExidynError, match="read_all gives them all"):
        ex.read(tmp_path, nominal_model())


def test_an_estimator_is_given_by_its_name(runs):
    assert ex.identify(runs[:2], estimator="weighted").estimate.method == "weighted"
    with pytest.raises(ex.api.ExidynError, match="unknown key 'best'. Valid keys: .*weighted"):
        ex.identify(runs[:2], estimator="best")


def test_a_diagnosis_finds_the_spring_and_shows_itself_in_a_few_lines(runs):
    found = ex.diagnose(runs[:2], runs[2])
    assert isinstance(found, Diagnosis)
    assert [one.effect for one in found.findings] == ["joint_spring"]
    assert repr(found).splitlines()[0].startswith("Diagnosis of two joints: 1 finding,")
    assert "joint_spring (elbow): probability" in repr(found)
    assert found._repr_html_().startswith("<pre")
    with pytest.raises(ex.api.ExidynError, match="nothing to diagnose"):
        ex.diagnose([], runs[2])


def test_values_show_themselves_in_at_most_ten_lines(runs, fit):
    for value in (runs[0], fit, small_plan()):
        assert 1 <= len(repr(value).splitlines()) <= 10
        assert "array(" not in repr(value)
        assert value._repr_html_().startswith("<pre")


def test_tables_hold_what_was_measured_and_what_was_fitted(runs, fit):
    pytest.importorskip("pandas")
    table = runs[0].to_dataframe()
    assert table["position", "elbow"].to_numpy() == pytest.approx(runs[0].signals["position"].values[:, 1])
    assert list(fit.to_dataframe().index) == fit.names
    assert fit.to_dataframe().loc[fit.names[0], "value"] == fit.value(fit.names[0])


def test_a_plot_has_an_axis_for_each_joint(fit):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    drawn = fit.plot()
    assert len(drawn.axes) == 2
    assert drawn.axes[0].get_title() == fit.validation[0].run
    with pytest.raises(ex.api.ExidynError, match="no samples of run 'nobody'"):
        fit.plot("nobody")


def test_a_package_that_is_missing_is_named_with_the_extra(runs, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingPackage, match=r"pandas, which is not installed: pip install .*notebook"):
        runs[0].to_dataframe()


def test_a_dropped_parameter_is_reported(fit):
    with pytest.raises(KeyError, match="was dropped"):
        replace(fit, dropped={"Fs1": 0.2}).value("Fs1")


def test_a_planned_motion_is_simulated_in_closed_loop_and_compared():
    plan = small_plan()
    first, second = ex.simulate(nominal_model(), plan), ex.simulate(nominal_model(), plan, seed=1)
    assert first.duration > plan.trajectory.duration
    assert not np.array_equal(first.signals["current"].values, second.signals["current"].values)
    mismatch = ex.compare(first, second)
    assert set(mismatch.mismatch) >= {"position"}
    sprung = nominal_model() + JointSpring(("elbow",))
    sprung = replace(sprung, stated={**sprung.stated, "Ks2": Prior(40.0)})
    assert np.ptp(ex.simulate(sprung, plan, exact=True).signals["current"].values) > 1.2 * np.ptp(
        ex.simulate(nominal_model(), plan, exact=True).signals["current"].values
    )
    with pytest.raises(ex.api.ExidynError):
        ex.simulate("cobot", plan)


def test_a_wish_that_there_is_not_is_refused():
    with pytest.raises(ex.api.ExidynError, match="plan: wish: unknown key 'length'. Valid keys: .*seconds"):
        ex.plan(two_joints.model(), length=3.0)


def test_a_report_is_a_page_of_a_fit_or_a_diagnosis(fit, tmp_path):
    page = ex.report(fit, tmp_path / "fit.html").read_text()
    assert "<html" in page
    with pytest.raises(ex.api.ExidynError, match="expected a Fit or a Diagnosis"):
        ex.report("fit", tmp_path / "no.html")
