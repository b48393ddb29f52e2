"""A row of a robot file without values believes nothing: no estimator draws its parameters anywhere."""

from dataclasses import replace

import numpy as np

from exidyn.identification.fit.estimators import consistent
from exidyn.identification.robot_files.robot_file import parse_model
from exidyn.identification.robot_files.robot_text import model_text

from ...parts.small import two_joints


def test_a_nominal_value_without_weight_changes_nothing():
    given, _ = two_joints.equations(payload=True)
    given = two_joints.white(given, np.array([0.01, 0.01]))
    own = np.array([parameter.name[:2] in ("Fv", "Fc", "Of") for parameter in given.base.parameters])
    tolerance = np.where(own, np.inf, 0.05 * np.maximum(np.abs(given.nominal), 0.1))
    estimates = [
        consistent(replace(given, nominal=np.where(own, value, given.nominal), tolerance=tolerance))
        for value in (0.0, 20.0)
    ]
    apart = np.abs(estimates[0].values - estimates[1].values)
    assert np.all(apart < 0.01 * estimates[0].std)


def test_a_row_without_values_reads_as_no_prior_and_back():
    text = model_text(two_joints.model())
    assert 'name = "viscous_friction"' in text
    priors = dict(zip(parse_model(text).names, parse_model(text).priors, strict=True))
    for name in ("Fv1", "Fv2", "Fc1", "Off2"):
        assert (priors[name].value, priors[name].std) == (0.0, np.inf)
