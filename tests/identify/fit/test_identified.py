"""What is exported of a fit: within its own 95 %, or named by the fit beside what is taken instead."""

import json
from dataclasses import replace

import numpy as np
import pytest

from exidyn.acquire.command_line import main
from exidyn.identify.fit.fit import NORMAL_95
from exidyn.identify.fit.fit_file import fit_text, read_fit
from exidyn.identify.fit.identified import exported
from exidyn.identify.fit.warnings.verdict import verdict
from exidyn.identify.pages.fit.fit_summary import summary
from exidyn.identify.pages.fit.report import report_html

from ...parts.small.small_fit import fit, plain_fit


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


@pytest.mark.parametrize("tolerance", [1e-4, 1e-3, 1e-2])
def test_nominal_values_that_are_off_do_not_overrule_the_data(tolerance):
    found = plain_fit()
    sure = replace(found.model, robot=replace(found.model.robot, inertial_tolerance=tolerance))
    assert exporting(replace(found, model=sure)).moved == ()


def test_what_no_arm_can_have_is_named_with_what_is_taken(impossible):
    [friction] = [one for one in impossible.moved if one.name == "Fv1"]
    std = impossible.estimate.std[impossible.names.index("Fv1")]
    assert (friction.value, friction.exported) == (-5.0, 0.0)
    assert friction.deviations == pytest.approx(5.0 / std)
    assert any(
        "No arm can have the values of" in line and "Fv1 0 for -5.000" in line for line in verdict(impossible)
    )
    assert "Exported otherwise\n" in summary(impossible)
    assert "Exported otherwise" in report_html(impossible)


def test_export_states_what_it_moved(impossible, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fit.json").write_text(fit_text(impossible))
    back = read_fit("fit.json")
    assert back.moved == impossible.moved
    assert main(["export", "fit.json", "--to", "toml", "--json", "export.json"]) == 0
    assert "  - Fv1 from -5.000 to 0, " in capsys.readouterr().out
    moved = json.loads((tmp_path / "export.json").read_text())["moved"]
    assert [one["name"] for one in moved] == json.loads((tmp_path / "fit.json").read_text())["moved"]
