"""A fit that was read, beside recordings: which judge it, with which body, and by which noise level."""

import json
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.arm.rigid_regressor import INERTIAL
from exidyn.identification.fit.fit_file import fit_text, read_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.recording import JOG, SIMULATED, KnownPayload
from exidyn.identification.simulation.comparison import compare
from exidyn.identification.simulation.predicted import predicted

from ...parts.small import two_joints
from ...parts.small.small_fit import fit
from ...parts.small.two_joint_files import loaded, run


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    """The fit as its file has it: without samples."""
    path = tmp_path_factory.mktemp("fit") / "fit.json"
    path.write_text(fit_text(fit()), encoding="utf-8")
    return read_fit(path)


def by_model(recording):
    return replace(recording, settings={**recording.settings, SIMULATED: "two joints"})


def names(runs):
    return [one.run for one in runs]


def test_what_a_model_made_is_shown_and_judges_nothing(read):
    found = predicted(read, [by_model(run("sim", 2, 4)), run("other", 2, 3)])
    assert (names(found.validation), names(found.apart)) == (["other"], ["sim"])
    assert "sim: simulated by a model; it is shown, but does not judge the fit" in found.warnings
    jog = run("jog", 2, 4)
    jog = replace(jog, settings={**jog.settings, JOG: "joint2 by 0.03 rad and back"})
    assert names(predicted(read, [jog, run("other", 2, 3)]).apart) == ["jog"]


def test_a_fit_of_simulated_runs_is_judged_by_simulated_runs():
    made = identify([by_model(run("empty"))])
    assert made.simulations == ("empty",)
    found = predicted(made, [by_model(run("sim", 2, 4))])
    assert (names(found.validation), found.apart) == (["sim"], ())


def test_a_loaded_run_is_judged_only_with_a_body_of_which_all_is_known(read):
    bare = loaded()  # its file does not say what it carries
    assert bare.payload is None
    found = predicted(read, [bare])
    np.testing.assert_allclose(found.agreement[0].over_noise, fit().agreement[1].over_noise, rtol=1e-12)
    strange = replace(loaded(KnownPayload("tool", (("M", 77.0),))), name="new")
    found = predicted(read, [strange])
    assert (found.validation, names(found.apart)) == ((), ["new"])
    assert any("carries 'tool', which is unknown to the fit" in line for line in found.warnings)
    known = {"M": 3.0, "MX": 0.3, "MZ": 0.15, "YY": 0.06}
    body = KnownPayload("tool", tuple((name, known.get(name, 0.0)) for name in INERTIAL))
    found = predicted(read, [replace(loaded(body), name="new")])
    assert names(found.validation) == ["new"]
    assert np.all(found.validation[0].over_noise < 1.2 * fit().agreement[1].over_noise)
    assert list(found.model.payloads) == ["L", "tool"]
    heavier = replace(loaded(KnownPayload("L", (("M", 30.0),))), name="new")
    same = replace(loaded(KnownPayload("L", (*two_joints.MASS, ("MX", 0.3)))), name="new")
    assert names(predicted(read, [same]).validation) == ["new"]
    assert names(predicted(read, [heavier]).apart) == ["new"]


@pytest.mark.parametrize("given", [["other"], ["other", "empty"], ["other", "loaded", "empty"]])
def test_the_noise_level_does_not_hang_on_which_files_are_given(read, given):
    every = {"other": run("other", 2, 3), "loaded": loaded(), "empty": run("empty")}
    found = predicted(read, [every[name] for name in given])
    np.testing.assert_array_equal(found.validation[0].noise, fit().validation[0].noise)
    np.testing.assert_allclose(found.validation[0].over_noise, fit().validation[0].over_noise, rtol=1e-12)


def test_the_noise_level_is_in_the_file_and_in_a_comparison(read):
    table = json.loads(fit_text(fit()))
    assert table["noise_floor_from"] == "rest"
    np.testing.assert_array_equal(read.noise, fit().noise)
    sim, real = run("sim", 2, 4), run("other", 2, 3)
    found, own = compare(sim, real, fit=read), compare(sim, real)
    assert found.filter_hz == pytest.approx(read.filtering.torque_cutoff, rel=0.1)
    assert np.all(found.effort.noise >= read.noise)
    assert not np.array_equal(found.effort.noise, own.effort.noise)
