"""The verdict: what is missing, flattering or surprising is reported, and only that."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.fit.fit import Fit
from exidyn.identification.fit.verdict import joint_verdicts, surprises, verdict
from exidyn.identification.preparation.prepare import SMOOTHED

from ...parts.pages.report_pages import known_fit

pytestmark = pytest.mark.numerical


@pytest.fixture(scope="module")
def fit():
    return known_fit()


def with_noise(fit: Fit, *share: float):
    """The fit with the residual of its validation at so many noises, one number a joint."""
    run = fit.validation[0]
    return replace(fit, validation=(replace(run, noise=run.residual_rms / np.array(share)),))


def test_verdict_names_the_joint_that_is_not_explained(fit):
    first = verdict(with_noise(fit, 1.0, 4.2))[0]
    assert "1 of 2 joints" in first
    assert "The residual of 1 of 2 joints is at the noise floor on the held-out runs. " in first
    assert "More than noise is left on elbow (4.2 x noise). exidyn diagnose tells whether" in first
    assert [v.words for v in joint_verdicts(with_noise(fit, 1.4, 1.29))] == [
        "a little above noise",
        "at the noise floor",
    ]


def test_the_worst_run_of_each_joint_counts_and_smoothed_runs_judge_nothing(fit):
    [run] = fit.validation
    first = verdict(replace(fit, validation=(replace(run, noise_source=SMOOTHED),)))[0]
    assert first.startswith("Whether the residual of any joint is at the noise floor is not judged: ")
    assert "x noise" not in first
    worse = with_noise(fit, 3.0, 0.5).validation[0]
    better = replace(with_noise(fit, 0.5, 2.0).validation[0], run="other")
    found = joint_verdicts(replace(fit, validation=(worse, better)))
    assert [(v.run, round(v.over_noise, 6)) for v in found] == [(worse.run, 3.0), ("other", 2.0)]


def test_errors_of_nominal_gains_are_named_where_none_was_found(fit):
    words = "Errors of the nominal drive gains alone could cause this"
    bad = with_noise(fit, 1.0, 4.2)
    count = len(bad.names)
    covariance = np.array(bad.estimate.covariance)
    covariance[count:], covariance[:, count:] = 0.0, 0.0
    nominal = replace(bad, estimate=replace(bad.estimate, covariance=covariance))
    assert words in verdict(nominal)[0]
    assert words not in verdict(bad)[0]
    assert words not in verdict(replace(nominal, measures="torque"))[0]


def test_surprise_is_a_value_far_from_its_prior(fit):
    deviation = np.full(len(fit.names), np.inf)
    deviation[2] = 1.0
    nominal = np.array(fit.estimate.values)
    nominal[2] += 3.5 * np.hypot(1.0, fit.estimate.std[2])
    assert surprises(replace(fit, prior=(nominal, deviation))) == [fit.names[2]]
