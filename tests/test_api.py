"""import exidyn as ex: what a notebook user guesses, and what results can do."""

import inspect
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import exidyn as ex
from exidyn.identification.diagnosis import Diagnosis
from exidyn.identification.effects import JointSpring, Prior
from exidyn.identification.errors import ExidynError, MissingPackage
from exidyn.trajectories.plans.plan import Plan
from exidyn.trajectories.plans.plan_file import read_plan

from .parts.plans.plans import fourier
from .parts.runs.parser_files import write_two_traces
from .parts.small.small_diagnosis import nominal_model, recordings

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def runs():
    """Two runs to fit and one held out."""
    return recordings()


@pytest.fixture(scope="module")
def fit(runs):
    return ex.identify(runs[:2], runs[2])


@pytest.fixture(scope="module")
def diagnosis(runs):
    return ex.diagnose(runs[:2], runs[2])


def small_plan():
    return Plan.of(fourier(harmonics=2), nominal_model())


def arrays(run):
    position, current = run.signals["position"], run.signals["current"]
    return {"t": position.time, "q": position.values, "current": current.values}


def test_every_name_is_there_and_an_unknown_one_is_refused_with_the_list():
    for name in dir(ex):
        assert getattr(ex, name) is not None
    with pytest.raises(AttributeError, match="It has: .*identify.*__version__"):
        _ = ex.recognise


def test_importing_it_loads_no_arithmetic():
    loaded = "import sys, exidyn; sys.exit('pinocchio' in sys.modules or 'numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", loaded], check=False).returncode == 0


def test_a_robot_is_a_name_a_file_or_a_model(tutorial):
    cobot = ex.robot("cobot")
    assert ex.robot(cobot) is cobot
    assert ex.robot(tutorial / "robot.toml").names == nominal_model().names
    with pytest.raises(ExidynError, match="no robot or file called 'robbie'"):
        ex.robot("robbie")


def test_a_run_is_a_recording_its_file_or_arrays(tutorial, runs):
    file = tutorial / "run.mcap"
    first, second = ex.identify(ex.read(file)), ex.identify([str(file)])
    np.testing.assert_allclose(first.estimate.values, second.estimate.values, rtol=1e-9)
    first = ex.identify(runs[0])
    second = ex.identify(**arrays(runs[0]), robot=nominal_model(), validate=arrays(runs[2]))
    np.testing.assert_allclose(first.estimate.values, second.estimate.values, rtol=1e-9)
    assert second.validation[0].run == "arrays"


def test_several_runs_are_read_together(tmp_path):
    write_two_traces(tmp_path)
    assert len(ex.read_all(tmp_path, nominal_model())) == 2
    with pytest.raises(ExidynError, match="read_all gives them all"):
        ex.read(tmp_path, nominal_model())


def test_arrays_may_be_in_degrees_and_state_a_body(runs):
    given = arrays(runs[0])
    degrees = given | {"q": np.degrees(given["q"])}
    body = {"mass": 3.0, "com": (0.1, 0.0, 0.0)}
    run = ex.Recording.from_arrays(nominal_model(), **degrees, degrees=True, **body)
    np.testing.assert_allclose(run.signals["position"].values, given["q"])
    assert dict(run.payload.known)["MX"] == pytest.approx(0.3)


def test_a_table_is_read_by_its_columns(runs):
    pandas = pytest.importorskip("pandas")
    given = arrays(runs[0])
    names = ["t", "q1", "q2", "i1", "i2"]
    [run] = ex.read_all(
        pandas.DataFrame(np.column_stack(list(given.values())), columns=names), nominal_model()
    )
    np.testing.assert_allclose(run.signals["current"].values, given["current"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q": np.zeros((5, 2))}, r"position has shape \(5, 2\) and t \(\d+,\)"),
        ({"robot": None}, "give robot= or urdf="),
        ({"current": None}, "a recording needs position and one of current, torque"),
    ],
)
def test_arrays_that_are_no_run_are_refused(runs, change, message):
    with pytest.raises(ExidynError, match=message):
        ex.identify(**{"robot": nominal_model(), **arrays(runs[0]), **change})


def test_an_estimator_is_given_by_its_name(runs):
    assert ex.identify(runs[0], estimator="weighted").estimate.method == "weighted"
    with pytest.raises(ExidynError, match="unknown key 'best'. Valid keys: .*weighted"):
        ex.identify(runs[0], estimator="best")


def test_values_show_themselves_in_at_most_ten_lines(runs, fit, diagnosis):
    for value in (runs[0], fit, small_plan(), diagnosis):
        assert 1 <= len(repr(value).splitlines()) <= 10
        assert "array(" not in repr(value)
        assert value._repr_html_().startswith("<pre")
    assert "\n" not in repr(nominal_model())
    assert len(repr(nominal_model())) < 200


def test_tables_hold_what_was_measured_and_what_was_fitted(runs, fit, diagnosis):
    pytest.importorskip("pandas")
    table = runs[0].to_dataframe()
    assert table["position", "elbow"].to_numpy() == pytest.approx(runs[0].signals["position"].values[:, 1])
    assert list(fit.to_dataframe().index) == fit.names
    assert fit.to_dataframe().loc[fit.names[0], "value"] == fit.value(fit.names[0])
    table = diagnosis.to_dataframe()
    spring = table[table["effect"] == "joint_spring"].set_index("parameter")
    assert spring.loc["Ks2", "value"] == diagnosis.findings[0]["Ks2"].value
    assert set(table["named"]) <= {True, False}


def test_a_plot_has_an_axis_for_each_joint(fit):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    drawn = fit.plot()
    assert len(drawn.axes) == 2
    assert drawn.axes[0].get_title() == fit.validation[0].run
    with pytest.raises(ExidynError, match="no samples of run 'nobody'"):
        fit.plot("nobody")


def test_a_package_that_is_missing_is_named_with_the_extra(runs, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingPackage, match=r"pandas, which is not installed: pip install .*notebook"):
        runs[0].to_dataframe()


def test_a_planned_motion_is_simulated_in_closed_loop_and_compared():
    plan = small_plan()
    first, second = ex.simulate(nominal_model(), plan), ex.simulate(nominal_model(), plan, seed=1)
    assert first.duration > plan.trajectory.duration
    assert not np.array_equal(first.signals["current"].values, second.signals["current"].values)
    assert set(ex.compare(first, second).mismatch) >= {"position"}
    sprung = nominal_model() + JointSpring(("elbow",))
    sprung = replace(sprung, stated={**sprung.stated, "Ks2": Prior(40.0)})
    with_spring, without = (ex.simulate(arm, plan, exact=True) for arm in (sprung, nominal_model()))
    with_spring, without = (run.signals["current"].values for run in (with_spring, without))
    assert np.ptp(with_spring) > 1.2 * np.ptp(without)
    with pytest.raises(ExidynError):
        ex.simulate("cobot", plan)


def test_a_plan_is_saved_and_given_as_arrays(tmp_path):
    plan = small_plan()
    again = read_plan(plan.save(tmp_path / "plan.toml"))
    time, position, *_ = again.to_arrays(0.5)
    np.testing.assert_allclose(position, plan.trajectory.at(time).position, atol=1e-12)
    assert len(plan.to_arrays().time) == pytest.approx(plan.trajectory.duration / plan.tick, abs=2)


def test_a_pinocchio_model_is_an_arm(runs):
    kinematics, limits = runs[0].robot.kinematics.copy(), runs[0].robot.limits
    kinematics.lowerPositionLimit, kinematics.upperPositionLimit = (
        limits.position_lower,
        limits.position_upper,
    )
    kinematics.effortLimit = np.array([5.0, 0.0])
    robot = ex.robot(kinematics).robot
    np.testing.assert_array_equal(robot.limits.position_upper, limits.position_upper)
    np.testing.assert_array_equal(robot.limits.torque, [5.0, np.inf])
    assert ex.Recording.from_arrays(kinematics, **arrays(runs[0])).robot.joints == robot.joints


def test_help_lists_each_function_with_the_first_line_of_its_docstring():
    for name in ex.__all__:
        if inspect.isfunction(function := getattr(ex, name)):
            assert f"    {name:<13}{function.__doc__.partition(chr(10))[0]}\n" in ex.__doc__


def test_a_parameter_has_value_deviation_interval_and_unit(fit):
    name = fit.names[0]
    parameter = fit[name]
    value, std = parameter.value, parameter.std
    assert (value, std) == (fit.estimate.values[0], fit.estimate.std[0])
    assert parameter.interval == pytest.approx((value - 1.96 * std, value + 1.96 * std))
    assert fit["Fv1"].unit == "N m s/rad"
    assert repr(fit["Fv1"]).endswith("N m s/rad")
    with pytest.raises(KeyError, match="no base parameter 'Fv9'. Valid: "):
        fit["Fv9"]
    with pytest.raises(KeyError, match="was dropped"):
        replace(fit, dropped={"Fs1": 0.2}).value("Fs1")
    assert list(fit.gains) == ["shoulder", "elbow"]


def test_torque_is_that_of_an_arm_with_these_base_parameters(runs):
    """By Pinocchio for the bodies, and by hand for friction and offsets."""
    random = np.random.default_rng(0)
    fit = ex.identify(runs[0], drop=False)
    arm = fit.model
    values = arm.nominal_values + 0.1 * random.normal(size=len(arm.names))
    fit = replace(fit, estimate=replace(fit.estimate, values=fit.base.regrouping @ values))
    q, dq, ddq = random.normal(size=(3, 50, 2))
    kinematics, _ = arm.bodies_apart(values, "")
    data = kinematics.createData()
    expected = np.array([pin.rnea(kinematics, data, *state) for state in zip(q, dq, ddq, strict=True)])
    for joint in range(2):
        viscous, dry, offset = (values[arm.names.index(f"{name}{joint + 1}")] for name in ("Fv", "Fc", "Off"))
        expected[:, joint] += viscous * dq[:, joint] + dry * np.sign(dq[:, joint]) + offset
    moving = np.abs(dq).min(axis=1) > 0.1
    np.testing.assert_allclose(fit.torque(q, dq, ddq)[moving], expected[moving], atol=1e-6)
    assert fit.torque(q[0], dq[0], ddq[0]) == pytest.approx(fit.torque(q, dq, ddq)[0])
    with pytest.raises(ExidynError, match="expected .50, 2. .samples, joints. for each"):
        fit.torque(q, dq[:, :1], ddq)


def test_a_fit_is_saved_read_exported_and_reported(fit, tmp_path):
    again = ex.load(fit.save(tmp_path / "fit.json"))
    np.testing.assert_allclose(again.estimate.values, fit.estimate.values, rtol=1e-12)
    assert again["Fv1"].interval == pytest.approx(fit["Fv1"].interval)
    assert fit.export("urdf", tmp_path / "arm.urdf") == (tmp_path / "arm.urdf").read_text()
    assert "<html" in fit.report(tmp_path / "fit.html").read_text()
    assert "base parameters were identified" in fit.verdict
    with pytest.raises(ExidynError, match="unknown key 'usd'. Valid keys: .*mjcf"):
        fit.export("usd")
    with pytest.raises(ExidynError, match="expected a Fit or a Diagnosis"):
        ex.report("fit", tmp_path / "no.html")


def test_a_model_takes_other_values():
    arm = nominal_model()
    other = arm.with_values(Fv2=30.0)
    assert other.nominal_values[other.names.index("Fv2")] == 30.0
    assert other.priors[other.names.index("Fv2")].std == arm.priors[arm.names.index("Fv2")].std
    with pytest.raises(ExidynError, match="has no parameter Fv9. Valid: "):
        arm.with_values(Fv9=1.0)


def test_a_diagnosis_gives_numbers_model_page_and_file(runs, diagnosis, tmp_path):
    assert isinstance(diagnosis, Diagnosis)
    [finding] = diagnosis.findings
    low, high = finding.intervals["Ks2"]
    assert low < finding["Ks2"].value < high
    assert repr(finding).startswith("Finding joint_spring of joint 2, ")
    assert repr(diagnosis).splitlines()[0].startswith("Diagnosis of two joints: 1 finding,")
    assert "joint_spring (elbow): probability" in repr(diagnosis)
    with pytest.raises(KeyError, match="has no parameter 'mass'"):
        finding["mass"]
    assert "JointSpring" in repr(diagnosis.model)
    assert "<html" in diagnosis.report(tmp_path / "diagnosis.html").read_text()
    with pytest.raises(ExidynError, match="nothing to diagnose"):
        ex.diagnose([], runs[2])
    again = ex.load(diagnosis.save(tmp_path / "diagnosis.json"))
    assert again.verdict == diagnosis.verdict
    assert again.findings[0].intervals == pytest.approx(diagnosis.findings[0].intervals)
    with pytest.raises(ExidynError, match="does not contain its model"):
        assert again.model
    (tmp_path / "other.json").write_text("{}")
    with pytest.raises(ExidynError, match="no fit, diagnosis or comparison"):
        ex.load(tmp_path / "other.json")
