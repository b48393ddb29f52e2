"""Edit test: a run whose body no run used carries is reported beside the other runs held out."""

from functools import cache

import numpy as np
import pytest

from exidyn.identification.fit.edit_test import edit_sentences, edit_tests
from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.fit_file import read_fit, write_fit
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.verdict import verdict
from exidyn.identification.recordings.recording import KnownPayload

from ...parts.small import two_joints
from ...parts.small.two_joint_files import WRONG, loaded, run

pytestmark = pytest.mark.numerical

BODY = (*two_joints.MASS, ("MX", 0.3), ("MZ", 0.15), ("YY", 0.06))
"""The payload as the simulated runs carry it."""


@cache
def put_on(mass: float = 3.0, gain: float = 1.0) -> Fit:
    """A fit without payload that predicts a run with one whose mass is stated, and a run without.

    Nominal gains are off by a factor.
    """
    known, model = KnownPayload("L", (("M", mass), *BODY[1:])), two_joints.model(gain=gain * two_joints.GAIN)
    return identify([run("empty")], [run("other", 2, 3), loaded(known)], model=model, as_recorded=True)


def test_a_payload_that_is_put_on_is_predicted_as_well_as_another_motion():
    [test] = edit_tests(put_on())
    assert (test.body, test.held_out) == ("L", True)
    assert np.all(test.residual < 3.0 * test.beside)  # noise is in proportion to current, which doubles


@pytest.mark.parametrize("wrong", [{"mass": 4.0}, {"gain": WRONG}])
def test_a_wrong_mass_or_gain_shows_in_the_edit_test_and_nowhere_else(wrong):
    [test], fit = edit_tests(put_on(**wrong)), put_on(**wrong)
    assert np.max(test.residual / test.beside) > 5.0
    assert np.all(test.beside < 0.2)
    [other] = [one for one in fit.validation if one.run not in fit.edits]
    np.testing.assert_allclose(other.residual_rms, test.beside)
    first, *_ = edit_sentences(fit)
    assert first.startswith("Edit test with payload 'L' attached and no refit (loaded): the residual of")
    assert "on the other held-out runs" in first
    assert first in verdict(fit)


def test_a_payload_that_is_taken_off_is_reported_too():
    model = two_joints.model()
    fit = identify([loaded(KnownPayload("L", BODY))], [run("other", 2, 3)], model=model, as_recorded=True)
    [test] = edit_tests(fit)
    assert (test.body, test.held_out) == ("", False)
    assert np.all(test.residual < 2.0 * test.beside)
    first, *_ = edit_sentences(fit)
    assert "the payload removed" in first
    assert "on the runs used" in first


def test_what_runs_do_not_determine_is_named_and_no_other_body_is_no_test():
    *_, last = edit_sentences(put_on())
    assert last.startswith("The runs used do not determine: ")
    assert "since drive gains are nominal" in last
    fit = identify([run("empty")], [run("other", 2, 3)], as_recorded=True)
    assert not edit_tests(fit)
    assert not edit_sentences(fit)


def test_a_file_keeps_the_edit_test(tmp_path):
    write_fit(put_on(gain=WRONG), tmp_path / "fit.json")
    [kept], [made] = edit_tests(read_fit(tmp_path / "fit.json")), edit_tests(put_on(gain=WRONG))
    assert (kept.run, kept.body) == (made.run, made.body)
    np.testing.assert_allclose(kept.residual, made.residual)
