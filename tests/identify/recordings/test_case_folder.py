"""Cases: runs, roles, and the model that is believed."""

import numpy as np
import pinocchio as pin
import pytest

from exidyn.identification.arm.motion import Motion
from exidyn.identification.errors import NotAFile, RecordingError
from exidyn.identification.recordings.importers import import_source
from exidyn.identification.recordings.importers.case_folder import nominal_model
from exidyn.identification.recordings.mcap.mcap_file import read_recording, write_recording

from ...parts.runs.runs import CASES, needs_cases


@needs_cases
def test_a_case_brings_its_runs_roles_and_payload():
    runs = import_source(CASES / "s1")
    assert [run.settings["role"] for run in runs] == ["identify", "identify", "validate", "payload", "slow"]
    assert [run.name for run in runs][:2] == ["s1/identify_a", "s1/identify_b"]
    assert all(run.signals["position"].values.shape == (12000, 6) for run in runs)
    assert [run.payload is not None for run in runs] == [False, False, False, True, False]
    known = dict(runs[3].payload.known)
    assert known["M"] == 62.0
    assert known["MZ"] == pytest.approx(62.0 * -0.18)
    assert known["XX"] == pytest.approx(1.0979166666666664 + 62.0 * (0.06**2 + 0.18**2))
    assert len(import_source(CASES / "s1" / "case.toml", role="validate")) == 1


@needs_cases
def test_a_case_states_its_model():
    believed = nominal_model(CASES / "s1")
    values = dict(zip(believed.names, believed.priors, strict=True))
    assert "Fc5" not in believed.names
    assert [name for name in believed.names if name.startswith("Off")] == ["Off2", "Off4", "Off5", "Off6"]
    assert values["Ia1"].value == 1113.29
    assert values["Ia1"].std == pytest.approx(111.329 / np.sqrt(3))  # true within the tolerance
    assert values["Fv2"].std == pytest.approx(0.2 * 2518.72)
    assert values["Off2"].std == np.inf
    assert values["Kr"].value == 50400.0
    assert values["K0"].std == pytest.approx(7850.0 / np.sqrt(3))
    assert believed.robot.drive_gain[5] == 212.587
    assert believed.robot.limits.acceleration[0] == 2.56


@needs_cases
@pytest.mark.parametrize("case", ["s1", "s4"])
def test_the_stated_model_balances_as_the_case_states(case):
    """Against the formulas at the top of case.toml, written out once more."""
    believed = nominal_model(CASES / case)
    random = np.random.default_rng(0)
    limits = believed.robot.limits
    q = random.uniform(limits.position_lower, limits.position_upper, (20, 6))
    dq, ddq = random.normal(size=(2, 20, 6))
    kinematics, data = believed.robot.kinematics, believed.robot.kinematics.createData()
    expected = np.array([pin.rnea(kinematics, data, *row) for row in zip(q, dq, ddq, strict=True)])
    values = dict(zip(believed.names, believed.nominal_values, strict=True))
    for joint in range(6):
        expected[:, joint] += values.get(f"Ia{joint + 1}", 0.0) * ddq[:, joint]
        expected[:, joint] += values.get(f"Fv{joint + 1}", 0.0) * dq[:, joint]
        expected[:, joint] += values.get(f"Fc{joint + 1}", 0.0) * np.tanh(dq[:, joint] / 0.003)
    q21 = -1.6148 + q[:, 1]
    length = np.sqrt(0.6964**2 + 0.1847**2 + 2 * 0.6964 * 0.1847 * np.cos(q21))
    force = 50400.0 * length - 78500.0
    expected[:, 1] -= -force * 0.6964 * 0.1847 * np.sin(q21) / length
    torque = believed.torque(Motion.of(np.arange(20.0), q, dq, ddq), believed.nominal_values)
    np.testing.assert_allclose(torque, expected, rtol=1e-9, atol=1e-6)


@needs_cases
def test_a_case_survives_its_own_file(tmp_path):
    [run] = import_source(CASES / "s1", role="payload")
    write_recording(run, tmp_path / "run.mcap")
    read = read_recording(tmp_path / "run.mcap")
    assert read.payload == run.payload
    assert read.settings == run.settings
    assert read.model.names == run.model.names
    np.testing.assert_allclose(read.model.nominal_values, run.model.nominal_values, rtol=1e-12)
    np.testing.assert_allclose(
        [b.std for b in read.model.priors], [b.std for b in run.model.priors], rtol=1e-9
    )
    assert np.array_equal(read.signals["current"].values, run.signals["current"].values)


def test_a_case_that_is_none(tmp_path):
    (tmp_path / "case.toml").write_text("[case]\nformat = 7\n")
    with pytest.raises(NotAFile, match="format is 7; this version reads 1"):
        import_source(tmp_path)
    (tmp_path / "case.toml").write_text("[case\n")
    with pytest.raises(NotAFile, match="case.toml: not TOML"):
        import_source(tmp_path)
    (tmp_path / "case.toml").write_text("[case]\nformat = 1\n")
    with pytest.raises(RecordingError, match="key 'robot' is missing"):
        import_source(tmp_path)


@needs_cases
def test_tolerances_of_rotors_and_gains_are_bounds_and_friction_is_a_guess():
    model = nominal_model(CASES / "s1")
    priors = dict(zip(model.names, model.priors, strict=True))
    assert {"Ia1", "Ia2"} <= model.bounded
    assert priors["Ia2"].std == pytest.approx(0.1 * priors["Ia2"].value / np.sqrt(3.0))
    assert "Fv2" not in model.bounded
    assert model.robot.drive_gain_bounded
