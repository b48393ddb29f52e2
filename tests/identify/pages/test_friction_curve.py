"""Friction over velocity: what sliding adds, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import Hysteresis, LoadDependentFriction, StribeckFriction
from exidyn.identification.fit.base_parameters import base_parameters
from exidyn.identification.pages.fit_plots import friction_curve, velocity_grid

from ...parts.pages.report_pages import known_fit
from ...parts.small.two_joints import model

pytestmark = pytest.mark.numerical


@pytest.fixture(scope="module")
def fit():
    return known_fit()


def test_friction_curve_is_viscous_and_dry_friction_of_any_effect(fit):
    velocity = velocity_grid(2.0)
    names = list(fit.names)
    for joint in range(2):
        viscous, dry = names.index(f"Fv{joint + 1}"), names.index(f"Fc{joint + 1}")
        sign = np.tanh(velocity / 0.003)
        torque, std = friction_curve(fit, joint, velocity)
        values = fit.estimate.values
        np.testing.assert_allclose(torque, values[viscous] * velocity + values[dry] * sign, rtol=1e-9)
        covariance = fit.estimate.covariance[np.ix_([viscous, dry], [viscous, dry])]
        rows = np.stack([velocity, sign], axis=1)
        np.testing.assert_allclose(std**2, np.einsum("tp,pq,tq->t", rows, covariance, rows), rtol=1e-9)
    velocity, torque = curve_with(fit, StribeckFriction(), Fs1=2.0)
    assert np.all(np.sign(torque) == np.sign(velocity))
    assert abs(torque[1]) > abs(torque[0])
    velocity, torque = curve_with(fit, Hysteresis(), Fh1=3.0)
    np.testing.assert_allclose(torque, 3.0 * np.sign(velocity), rtol=1e-9)
    velocity, torque = curve_with(fit, LoadDependentFriction(), mu1=0.1)
    assert np.all(np.sign(torque) == np.sign(velocity))
    assert np.ptp(np.abs(torque)) < 1e-9
    velocity, torque = curve_with(fit, Hysteresis(), Off1=5.0, MX1=1.0, YY1=7.0)
    np.testing.assert_array_equal(torque, 0.0)


def curve_with(fit, effect, **values):
    """Curve of joint 0 where one effect is added to the model and everything else is zero."""
    enlarged = model(effect)
    base = base_parameters(enlarged)
    plain = [enlarged.names[column] for column in base.kept]
    estimate = replace(
        fit.estimate,
        values=np.array([values.get(name, 0.0) for name in plain]),
        covariance=np.zeros((len(plain) + 2, len(plain) + 2)),
    )
    velocity = np.array([-1.0, -0.1, 0.1, 1.0])
    return velocity, friction_curve(replace(fit, model=enlarged, base=base, estimate=estimate), 0, velocity)[
        0
    ]
