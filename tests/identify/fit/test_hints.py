import numpy as np
import pytest

from exidyn.identification.effects import RigidBody, RotorInertia, ViscousFriction
from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.fit.estimators import Estimate
from exidyn.identification.fit.fit_warnings import OPEN, unclear
from exidyn.identification.model import Model

from ...parts.small.two_joints import GAIN, arm

MODEL = Model(arm(), (RigidBody(), RotorInertia(), ViscousFriction()))
BASE = base_parameters(MODEL)


def estimate(open_names, std=10.0):
    """All parameters are one and known to a per cent, but for the named."""
    names = BASE.names
    deviation = np.array([std if name in open_names else 0.01 for name in names])
    covariance = np.pad(np.diag(deviation**2), (0, 2))
    return Estimate("test", np.ones(len(names)), GAIN, covariance, np.ones(2))


def test_only_what_is_open_has_a_hint():
    assert unclear(MODEL, BASE, estimate([])) == ()
    assert unclear(MODEL, BASE, estimate(["Fv1"], std=0.99 * OPEN / 100)) == ()
    found = unclear(MODEL, BASE, estimate(["Fv2", "Fv1"]))
    assert [entry.name for entry in found] == ["Fv1", "Fv2"]
    given = estimate([])
    values = -given.values
    values[0] = 0.0
    found = unclear(MODEL, BASE, Estimate("test", values, GAIN, given.covariance, given.noise))
    assert [entry.name for entry in found] == [BASE.names[0]]
    assert np.isfinite(found[0].std_percent)


@pytest.mark.parametrize(("name", "hint"), [("Fv1", "move shoulder fast"), ("Ia2", "accelerate elbow hard")])
def test_the_motion_that_moves_the_column_is_named(name, hint):
    if name not in BASE.names:
        name = f"{name}R"
    found = unclear(MODEL, BASE, estimate([name]))
    assert [entry.name for entry in found] == [name]
    assert found[0].std_percent == pytest.approx(1000.0)
    assert found[0].hint == hint
