"""What results can do in Python: values, torque, files, pages, models; and runs that are arrays or tables."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import exidyn as ex
from exidyn.identification.errors import ExidynError

from .parts.small.small_diagnosis import nominal_model, recordings

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def runs():
    return recordings()


@pytest.fixture(scope="module")
def fit(runs):
    return ex.identify(runs[:2], runs[2])


@pytest.fixture(scope="module")
def diagnosis(runs):
    return ex.diagnose(runs[:2], runs[2])


def arrays(run):
    signals = run.signals
    return {
        "t": signals["position"].time,
        "q": signals["position"].values,
        "current": signals["current"].values,
    }


def test_arrays_give_the_fit_of_the_recording(runs):
    given = ex.identify(**arrays(runs[0]), robot=nominal_model(), validate=arrays(runs[2]))
    recorded = ex.identify(runs[0], runs[2])
    np.testing.assert_allclose(given.estimate.values, recorded.estimate.values, rtol=1e-9)
    assert given.validation[0].run == "arrays"


def test_positions_may_be_in_degrees(runs):
    given = arrays(runs[0])
    given["q"] = np.degrees(given["q"])
    run = ex.Recording.from_arrays(nominal_model(), **given, degrees=True)
    np.testing.assert_allclose(run.signals["position"].values, runs[0].signals["position"].values)


def test_a_body_is_stated_with_the_arrays(runs):
    run = ex.Recording.from_arrays(nominal_model(), **arrays(runs[0]), mass=3.0, com=(0.1, 0.0, 0.0))
    assert dict(run.payload.known)["MX"] == pytest.approx(0.3)


def test_a_table_is_read_by_its_columns(runs):
    pandas = pytest.importorskip("pandas")
    given = arrays(runs[0])
    names = ["t", "q1", "q2", "i1", "i2"]
    table = pandas.DataFrame(np.column_stack(list(given.values())), columns=names)
    [run] = ex.read_all(table, nominal_model())
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


def test_a_parameter_has_value_deviation_interval_and_unit(fit):
    name = fit.names[0]
    one = fit[name]
    assert (one.value, one.std) == (fit.estimate.values[0], fit.estimate.std[0])
    assert one.interval == pytest.approx((one.value - 1.96 * one.std, one.value + 1.96 * one.std))
    assert fit["Fv1"].unit == "N m s/rad"
    assert repr(fit["Fv1"]).endswith("N m s/rad")
    with pytest.raises(KeyError, match="no base parameter 'Fv9'. Valid: "):
        fit["Fv9"]
    assert list(fit.gains) == ["shoulder", "elbow"]


def test_torque_is_that_of_an_arm_with_these_base_parameters(runs):
    """By Pinocchio for the bodies, and by hand for friction and offsets."""
    random = np.random.default_rng(0)
    fit = ex.identify(runs[:2], drop=False)
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
    assert fit.torque(q[0], dq[0], ddq[0]) == pytest.approx(fit.torque(q, dq, ddq)[:1])
    with pytest.raises(ExidynError, match="expected .50, 2. .samples, joints. for each"):
        fit.torque(q, dq[:, :1], ddq)


def test_a_fit_is_saved_read_exported_and_reported(fit, tmp_path):
    again = ex.load(fit.save(tmp_path / "fit.json"))
    np.testing.assert_allclose(again.estimate.values, fit.estimate.values, rtol=1e-12)
    assert again["Fv1"].interval == pytest.approx(fit["Fv1"].interval)
    assert fit.export("urdf", tmp_path / "arm.urdf") == (tmp_path / "arm.urdf").read_text()
    assert "<html" in fit.report(tmp_path / "fit.html").read_text()
    assert "base parameters were identified" in fit.verdict
    with pytest.raises(ExidynError, match="unknown key 'usd'. Valid keys: isaaclab"):
        fit.export("usd")


def test_a_model_shows_itself_in_a_line_and_takes_other_values():
    arm = nominal_model()
    assert "\n" not in repr(arm)
    assert len(repr(arm)) < 200
    other = arm.with_values(Fv2=30.0)
    assert other.nominal_values[other.names.index("Fv2")] == 30.0
    assert other.priors[other.names.index("Fv2")].std == arm.priors[arm.names.index("Fv2")].std
    with pytest.raises(ExidynError, match="has no parameter Fv9. Valid: "):
        arm.with_values(Fv9=1.0)


def test_a_diagnosis_gives_numbers_model_page_and_file(diagnosis, tmp_path):
    [finding] = diagnosis.findings
    low, high = finding.intervals["Ks2"]
    assert low < finding["Ks2"].value < high
    assert repr(finding).startswith("Finding joint_spring of joint 2, ")
    with pytest.raises(KeyError, match="has no parameter 'mass'"):
        finding["mass"]
    assert "JointSpring" in repr(diagnosis.model)
    assert "spring" in diagnosis.verdict
    assert diagnosis.save(tmp_path / "diagnosis.json").stat().st_size > 1000
    assert "<html" in diagnosis.report(tmp_path / "diagnosis.html").read_text()


def test_a_saved_diagnosis_is_loaded_with_its_findings(diagnosis, tmp_path):
    again = ex.load(diagnosis.save(tmp_path / "diagnosis.json"))
    assert again.verdict == diagnosis.verdict
    assert again.findings[0].intervals == pytest.approx(diagnosis.findings[0].intervals)
    with pytest.raises(ExidynError, match="does not contain its model"):
        assert again.model
    (tmp_path / "other.json").write_text("{}")
    with pytest.raises(ExidynError, match="no fit, diagnosis or comparison"):
        ex.load(tmp_path / "other.json")


def test_findings_are_a_table(diagnosis):
    table = diagnosis.to_dataframe()
    spring = table[table["effect"] == "joint_spring"].set_index("parameter")
    assert spring.loc["Ks2", "value"] == diagnosis.findings[0]["Ks2"].value
    assert set(table["named"]) <= {True, False}
