"""Dry friction that changes its sign over a wide range of velocity is named as that, and nothing else is."""

import pytest

from exidyn.identification.diagnosis import diagnose
from exidyn.identification.diagnosis.refit import model_to_fit
from exidyn.identification.diagnosis.words.sentences import sentence
from exidyn.identification.effects import CoulombFriction, Hysteresis
from exidyn.identification.robot_files.robot_file import parse_model
from exidyn.identification.robot_files.robot_text import model_text

from ...parts.small.small_diagnosis import nominal_model
from ...parts.small.small_search import names, record, searched

GRADUAL = "coulomb_friction", (1,)


def gradual(velocity, share=1.0):
    """Runs of an arm in which so much of the elbow's dry friction, 2 N m, changes its sign gradually."""
    effect = CoulombFriction(("elbow",), velocity, gradual=True)
    return record([effect], {"Fc2": 2.0 * (1.0 - share), "Fg2": 2.0 * share})


@pytest.mark.parametrize("velocity", [0.05, pytest.param(0.28, marks=pytest.mark.long)])
def test_dry_friction_that_turns_over_a_wide_velocity_is_named_with_it(velocity):
    [finding] = diagnose(nominal_model(), gradual(velocity), "gradual").findings
    assert (finding.effect, finding.joints) == GRADUAL
    size, reversal = finding.parameters["Fg2"], finding.parameters["reversal"]
    # The narrower, the more of it may be how dry friction changes its sign on any joint, or by how much the
    # formula is wrong.
    assert abs(size.value - 2.0) < 3.0 * size.std < 1.4
    assert reversal.value == pytest.approx(velocity, rel=0.15)
    assert 0.0 < reversal.std < 0.2 * velocity
    assert "changes its sign gradually, over" in sentence(finding, ("shoulder", "elbow"))


@pytest.mark.long
def test_with_it_in_the_robots_file_nothing_is_named_again():
    runs = gradual(0.1, 0.6)
    found = model_to_fit(diagnose(nominal_model(), runs, "gradual"))
    again = parse_model(model_text(found))
    assert "Fg2" in again.names
    assert diagnose(again, runs, "again").findings == ()


def test_other_friction_that_is_unusual_after_a_reversal_is_still_named_as_itself():
    hysteresis = Hysteresis(("elbow",), presliding=8e-3)
    assert names(searched(record([hysteresis], {"Fh2": 2.0, "Fc2": 0.0}))) == [("hysteresis", (1,))]
