"""A fit reads back as it was."""

import json
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import CoulombFriction, RigidBody
from exidyn.identification.errors import NotAFile
from exidyn.identification.fit.estimators import consistent
from exidyn.identification.fit.fit_file import FORMAT, fit_text, read_fit, write_fit
from exidyn.identification.fit.identification import identify

from ...parts.small.small_fit import fit, other_run, plain_fit
from ...parts.small.two_joint_files import run

pytestmark = pytest.mark.numerical


@pytest.fixture
def path(tmp_path):
    write_fit(fit(), tmp_path / "fit.json")
    return tmp_path / "fit.json"


def test_what_was_read_predicts_the_same_bit_for_bit(path):
    before, after = fit().agree(other_run()), read_fit(path).agree(other_run())
    for name in ("measured", "predicted", "noise", "weight", "relative", "over_noise"):
        assert np.array_equal(getattr(before, name), getattr(after, name))
    assert np.linalg.norm(after.predicted) > 0


def test_everything_but_the_samples_reads_back(path):
    before, after = fit(), read_fit(path)
    for name in ("runs", "filtering", "condition", "rows", "dropped", "unclear", "warnings", "names"):
        assert getattr(after, name) == getattr(before, name)
    assert before.dropped
    assert list(after.dropped) == list(before.dropped)
    assert before.warnings
    for name in ("values", "gain", "covariance", "noise"):
        assert np.array_equal(getattr(after.estimate, name), getattr(before.estimate, name))
    assert after.estimate.method == before.estimate.method
    assert all(np.array_equal(a, b) for a, b in zip(after.prior, before.prior, strict=True))
    assert np.isinf(before.prior[1]).any()
    assert after.base.expressions == before.base.expressions
    assert after.base.gap == before.base.gap
    assert after.structure.expressions == before.structure.expressions
    assert np.array_equal(after.structure.kept, before.structure.kept)
    assert after.model.priors == before.model.priors
    for name in ("values", "gain", "covariance", "noise"):
        assert np.array_equal(getattr(after.full_estimate, name), getattr(before.full_estimate, name))
    assert (after.agreement, after.validation) == ((), ())


def test_a_fit_has_all_parameters_from_before_some_were_dropped(path):
    all_kept = plain_fit()
    assert all_kept.undropped is all_kept
    for undropped in (fit().undropped, read_fit(path).undropped):
        assert undropped.names == list(fit().structure.names)
        values = dict(zip(undropped.names, undropped.estimate.values, strict=True))
        assert values.items() >= fit().dropped.items()
        assert len(undropped.prior[0]) == len(undropped.names)
        assert (undropped.dropped, undropped.undropped) == ({}, undropped)


def test_a_fit_that_dropped_nothing_and_standard_parameters_read_back(tmp_path):
    write_fit(plain_fit(), tmp_path / "fit.json")
    after = read_fit(tmp_path / "fit.json")
    assert after.structure is None
    assert after.dropped == {}
    assert np.array_equal(after.estimate.values, plain_fit().estimate.values)
    before = identify([run("empty")], estimator=consistent, drop=False)
    write_fit(before, tmp_path / "fit.json")
    assert before.estimate.standard is not None
    assert np.array_equal(read_fit(tmp_path / "fit.json").estimate.standard, before.estimate.standard)


def test_writing_what_was_read_changes_nothing_but_the_agreement(path):
    before, after = json.loads(fit_text(fit())), json.loads(fit_text(read_fit(path)))
    assert [entry["run"] for entry in before["agreement"]] == ["empty", "loaded"]
    assert [entry["run"] for entry in before["validation"]] == ["other"]
    without = {"agreement": [], "validation": []}
    assert after == before | without


@pytest.mark.parametrize("share", [0.0, 0.3, 0.99])
def test_a_cut_file_is_refused(path, share):
    text = path.read_text()
    path.write_text(text[: int(share * len(text))])
    with pytest.raises(NotAFile, match="fit.json is not JSON, or was cut off"):
        read_fit(path)


@pytest.mark.parametrize("text", ["[1, 2]", '{"robot": "kr270"}', "3"])
def test_other_json_is_refused(path, text):
    path.write_text(text)
    with pytest.raises(NotAFile, match="not a fit of exidyn: it has no key 'exidyn_fit'"):
        read_fit(path)


@pytest.mark.parametrize("key", ["model", "covariance", "base_parameters", "filtering", "drive_gain"])
def test_a_missing_key_is_named(path, key):
    table = json.loads(path.read_text())
    del table[key]
    path.write_text(json.dumps(table))
    with pytest.raises(NotAFile, match=f"key '{key}' is missing"):
        read_fit(path)


def changed(path, *places, value):
    """The file with one entry replaced."""
    table = json.loads(path.read_text())
    *before, last = places
    holder = table
    for place in before:
        holder = holder[place]
    holder[last] = value
    path.write_text(json.dumps(table))


@pytest.mark.parametrize(
    ("places", "value", "told"),
    [
        (["rows"], None, "rows: expected int, got null; found None"),
        (["rows"], 10**400, "rows: expected int <= 9007199254740992; found a number of many digits"),
        (["filtering", "rate"], -3.0, "filtering.rate: expected a number above zero; found -3.0"),
        (["covariance"], [[1.0]], "covariance: expected 17 values, the kept base "),
        (["covariance", 1, 1], -1.0, "covariance[1][1]: expected a variance of zero or above; found -1.0"),
        (["covariance", 1, 2], 1e9, "covariance[1][2]: expected "),
        (["covariance", 1, 2], float("nan"), "covariance[1][2]: expected float >= -1e+100; found nan"),
        (["base_parameters"], [], "base_parameters: expected at least one with kept = true; found 0"),
        (["base_parameters", 3, "column"], 999, "[3].column: expected a parameter of the model, from 0 to "),
        (["base_parameters", 3, "std"], -1.0, "base_parameters[3].std: expected float >= 0.0; found -1.0"),
        (["base_parameters", 3, "unit"], "furlong", "base_parameters[3].unit: expected '"),
        (["base_parameters", 3, "name"], "XX9", "base_parameters[3].name: expected 'YY2', by its column"),
        (["base_parameters", 0, "sum_of"], {"XX9": 1.0}, ".sum_of[0]: expected a parameter of the model"),
        (["base_parameters", 0, "prior"], [0.0, -1.0], "[0].prior[1]: expected float >= 0.0; found -1.0"),
        (["drive_gain"], [1.0], "joints: expected 1 values, one per joint, as drive_gain has; found 2"),
        (["drive_gain", 1], 0.0, "drive_gain[1]: expected a number other than zero; found 0.0"),
        (["joints"], ["a", "b"], "joints: expected those of the model"),
        (["measures"], "volts", "measures: invalid enum value 'volts'; found 'volts'"),
        (["simulations"], ["nowhere"], "simulations[0]: expected one of runs; found 'nowhere'"),
        (["dropped"], [], "dropped: expected those with kept = false, ["),
        (["condition"], 0.0, "condition: expected a condition number, at least 1; found 0.0"),
        (["exidyn_fit"], FORMAT + 1, f"has format {FORMAT + 1}; this version reads {FORMAT}"),
        (["warnings"], ["\ud800"], "is not JSON"),
        (["full_estimate", "values"], [1.0], "full_estimate.values"),
        (["full_estimate", "covariance"], [[1.0]], "full_estimate.covariance"),
        (["full_estimate", "drive_gain"], [0.0, 1.0], "full_estimate.drive_gain"),
    ],
)  # fmt: skip
def test_a_wrong_field_is_named_with_its_value_and_what_is_expected(path, places, value, told):
    changed(path, *places, value=value)
    with pytest.raises(NotAFile) as error:
        read_fit(path)
    text = str(error.value)
    assert text.startswith(str(path))
    assert told in text
    assert "\n" not in text


def test_shapes_and_joints_of_effects_read_back(tmp_path):
    model = replace(
        plain_fit().model, effects=(RigidBody(), CoulombFriction(("elbow",), reversal=0.017)), stated={}
    )
    write_fit(identify([run("empty")], model=model, drop=False), tmp_path / "fit.json")
    assert read_fit(tmp_path / "fit.json").model.effects == model.effects
