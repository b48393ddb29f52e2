"""What is exported of a fit: within its own 95 %, or named by the fit beside what is taken instead."""

import json
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from exidyn.acquire.command_line import main
from exidyn.identification.fit.fit_file import fit_text, read_fit
from exidyn.identification.fit.identified import exported, identified
from exidyn.identification.fit.verdict import verdict
from exidyn.identification.pages.fit_document import report_html
from exidyn.identification.text_table import NORMAL_95

from ...parts.small.small_fit import fit, plain_fit, summary


def exporting(found):
    return replace(found, exported=exported(found))


@pytest.fixture(scope="module")
def impossible():
    """A fit whose friction of the first joint is negative, which no arm can have."""
    found, values = plain_fit(), np.array(plain_fit().estimate.values)
    values[found.names.index("Fv1")] = -5.0
    return exporting(replace(found, estimate=replace(found.estimate, values=values)))


def test_a_fit_that_an_arm_can_have_is_exported_within_its_95_percent():
    for found in (fit(), plain_fit()):
        assert np.all(np.abs(found.exported - found.estimate.values) <= NORMAL_95 * found.estimate.std)
        assert found.moved == ()
        assert "Exported otherwise" not in summary(found)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-2])
def test_nominal_values_that_are_off_do_not_overrule_the_data(tolerance):
    found = plain_fit()
    sure = replace(found.model, robot=replace(found.model.robot, inertial_tolerance=tolerance))
    assert exporting(replace(found, model=sure)).moved == ()


@pytest.mark.parametrize("masses", [(1.0, 1e-4), (1e-4, 1.0), (0.02, 0.02), (1e-5, 1e-5), (1e3, 1e3)])
@pytest.mark.parametrize("inertia", [1.0, 1e6])
@pytest.mark.parametrize("tolerance", [1e-3, 0.1])
def test_bodies_in_wrong_units_and_placeholders_do_not_move_the_fit(masses, inertia, tolerance):
    fitted = plain_fit()
    robot = fitted.model.robot
    kinematics = robot.kinematics.copy()
    for joint, mass in enumerate(masses, 1):
        body = kinematics.inertias[joint]
        kinematics.inertias[joint] = pin.Inertia(mass * body.mass, body.lever, mass * inertia * body.inertia)
    other = replace(robot, kinematics=kinematics, inertial_tolerance=tolerance)
    assert exporting(replace(fitted, model=replace(fitted.model, robot=other))).moved == ()


def test_what_no_arm_can_have_is_named_with_what_is_taken(impossible):
    [friction] = [one for one in impossible.moved if one.name == "Fv1"]
    std = impossible.estimate.std[impossible.names.index("Fv1")]
    assert (friction.value, friction.exported) == (-5.0, 0.0)
    assert friction.deviations == pytest.approx(5.0 / std)
    assert any(
        "physically inconsistent" in line and "Fv1 0 instead of -5.000" in line
        for line in verdict(impossible)
    )
    assert "Exported otherwise\n" in summary(impossible)
    assert "Exported otherwise" in report_html(impossible)


@pytest.mark.parametrize(
    ("share", "words"), [(1.0, "no residual shows"), (0.1, "the runs contain an effect")]
)
def test_inconsistent_values_are_a_missing_effect_only_if_a_residual_shows_it(impossible, share, words):
    runs = tuple(replace(run, noise=share * run.residual_rms) for run in impossible.agreement)
    [sentence] = [line for line in verdict(replace(impossible, agreement=runs)) if "inconsistent" in line]
    assert words in sentence


@pytest.mark.parametrize(("rows", "value"), [([0], 0.0), ([0, 1, 2], None), (slice(None), 0.0)])
def test_what_is_known_exactly_is_exported_as_it_is(rows, value):
    """Rows of zeros in a covariance: nothing is known better than to a millionth, and nothing overflows."""
    found = plain_fit()
    covariance, values = np.array(found.estimate.covariance), np.array(found.estimate.values)
    covariance[rows], covariance[:, rows] = 0.0, 0.0
    if value is not None:
        values[found.names.index("Fv1")] = value
        covariance[found.names.index("Fv1")] = covariance[:, found.names.index("Fv1")] = 0.0
    taken = exported(replace(found, estimate=replace(found.estimate, covariance=covariance, values=values)))
    assert taken == pytest.approx(values, rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("share", [0.0, 1e-18, 1e-12])
def test_values_that_are_known_together_only_do_not_end_the_export(share):
    """Covariances of rank one, and nearly so."""
    found = plain_fit()
    std = found.estimate.std
    covariance = np.array(found.estimate.covariance)
    covariance[: len(std), : len(std)] = np.outer(std, std) + share * np.diag(std**2)
    model = identified(replace(found, estimate=replace(found.estimate, covariance=covariance)))
    assert np.all(np.isfinite(model.nominal_values))
    assert np.all(np.array([prior.std for prior in model.priors]) >= 0.0)


@pytest.mark.parametrize("size", [1e-150, 1e140])
def test_deviations_of_any_size_do_not_end_the_export(size):
    found = plain_fit()
    estimate = replace(found.estimate, covariance=size**2 * found.estimate.covariance)
    assert np.all(np.isfinite(exported(replace(found, estimate=estimate))))


def test_export_states_what_it_moved(impossible, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fit.json").write_text(fit_text(impossible))
    back = read_fit("fit.json")
    assert back.moved == impossible.moved
    assert main(["export", "fit.json", "--to", "toml", "--json", "export.json"]) == 0
    assert "  - Fv1 from -5.000 to 0, " in capsys.readouterr().out
    moved = json.loads((tmp_path / "export.json").read_text())["moved"]
    assert [one["name"] for one in moved] == json.loads((tmp_path / "fit.json").read_text())["moved"]
