"""A fit reads back as it was."""

import json
from dataclasses import replace

import numpy as np
import pytest

from exidyn.identify.effects import CoulombFriction, RigidBody
from exidyn.identify.errors import NotAFile
from exidyn.identify.fit.estimators import consistent
from exidyn.identify.fit.fit_file import FORMAT, fit_text, read_fit, write_fit
from exidyn.identify.fit.identification import identify

from ...parts.small.small_fit import fit, other_run, plain_fit
from ...parts.small.two_joint_files import run


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
    assert (after.agreement, after.validation) == ((), ())


def test_older_names_of_prior_and_warnings_are_read(path):
    text = path.read_text()
    path.write_text(text.replace('"prior":', '"believed":').replace('"warnings":', '"doubts":'))
    after = read_fit(path)
    assert "believed" in path.read_text()
    assert all(np.array_equal(a, b) for a, b in zip(after.prior, fit().prior, strict=True))
    assert after.warnings == fit().warnings


def test_a_fit_that_dropped_nothing_reads_back(tmp_path):
    write_fit(plain_fit(), tmp_path / "fit.json")
    after = read_fit(tmp_path / "fit.json")
    assert after.structure is None
    assert after.dropped == {}
    assert np.array_equal(after.estimate.values, plain_fit().estimate.values)


def test_standard_parameters_read_back(tmp_path):
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


def test_other_programs_can_read_it(path):
    def refuse(constant):
        raise AssertionError(f"{constant} is not JSON")

    table = json.loads(path.read_text(), parse_constant=refuse)
    first = table["base_parameters"][0]
    assert first["value"] == fit().estimate.values[0]
    assert first["unit"] == fit().base.units[0]
    scores = table["validation"][0]["over_noise"]
    assert scores == fit().validation[0].over_noise.tolist()


@pytest.mark.parametrize("share", [0.0, 0.3, 0.99])
def test_a_cut_file_is_refused(path, share):
    text = path.read_text()
    path.write_text(text[: int(share * len(text))])
    with pytest.raises(NotAFile, match="fit.json is not JSON, or was cut off"):
        read_fit(path)


@pytest.mark.parametrize("text", ["[1, 2]", '{"robot": "kr270"}', "3"])
def test_other_json_is_refused(path, text):
    path.write_text(text)
    with pytest.raises(NotAFile, match="no fit of exidyn: it has no key 'exidyn_fit'"):
        read_fit(path)


def test_a_later_format_is_refused(path):
    table = json.loads(path.read_text()) | {"exidyn_fit": FORMAT + 1}
    path.write_text(json.dumps(table))
    with pytest.raises(NotAFile, match=f"has format {FORMAT + 1}; this version reads {FORMAT}"):
        read_fit(path)


@pytest.mark.parametrize("key", ["model", "covariance", "base_parameters", "filtering", "drive_gain"])
def test_a_missing_key_is_named(path, key):
    table = json.loads(path.read_text())
    del table[key]
    path.write_text(json.dumps(table))
    with pytest.raises(NotAFile, match=f"key '{key}' is missing"):
        read_fit(path)


@pytest.mark.parametrize(
    ("key", "value"),
    [("filtering", {"speed": 3}), ("covariance", ["a"]), ("base_parameters", [1]), ("rows", None)],
)
def test_damage_is_refused(path, key, value):
    path.write_text(json.dumps(json.loads(path.read_text()) | {key: value}))
    with pytest.raises(NotAFile, match="fit.json is damaged"):
        read_fit(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(NotAFile, match="none.json cannot be read"):
        read_fit(tmp_path / "none.json")


def test_shapes_and_joints_of_effects_read_back(tmp_path):
    model = replace(
        plain_fit().model, effects=(RigidBody(), CoulombFriction(("elbow",), reversal=0.017)), stated={}
    )
    write_fit(identify([run("empty")], model=model, drop=False), tmp_path / "fit.json")
    assert read_fit(tmp_path / "fit.json").model.effects == model.effects
