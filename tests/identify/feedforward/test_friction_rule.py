"""Friction compensation near rest: no torque from noise, no limit cycle, no motion of its own."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.feedforward.feedforward import make_feedforward

from ...parts.small import small_fit

TICK, SECONDS = 0.002, 6.0
ENCODER = 2e-5
"""Standard deviation of the encoder's noise [rad]: 5 times that noise, as velocity, is inside the band."""
CUTOFF = 30.0
"""Cut-off of the controller's velocity filter [Hz]."""


def held(feedforward, push=0.0, band=None):
    """The joint `shoulder` alone under compensation, with stiction: torque (t,) and velocity (t,).

    A push [N m] acts for the first half second. The friction of the joint is that of the arm, and at rest
    whatever holds it, up to the dry friction.
    """
    if band is not None:
        feedforward = replace(feedforward, band=np.full(2, band))
    random, count = np.random.default_rng(0), int(SECONDS / TICK)
    inertia, dry, viscous = 3.0, 4.0, 3.0
    position, velocity, filtered, last = 0.0, 0.0, 0.0, 0.0
    torques, velocities = np.zeros((2, count))
    for k in range(count):
        measured = position + ENCODER * random.normal()
        filtered += (1.0 - np.exp(-2 * np.pi * CUTOFF * TICK)) * ((measured - last) / TICK - filtered)
        last = measured
        q = np.array([measured, 0.0])
        torque = feedforward.friction_compensation(q, np.array([filtered, 0.0]))[0]
        force = torque + (push if k * TICK < 0.5 else 0.0)
        ahead = velocity + TICK * (force - viscous * velocity) / inertia
        stopped = abs(ahead) <= TICK * dry / inertia  # dry friction can end the motion within this step
        velocity = 0.0 if stopped else ahead - np.sign(ahead) * TICK * dry / inertia
        position += TICK * velocity
        torques[k], velocities[k] = torque, velocity
    return torques, velocities


@pytest.fixture(scope="module")
def feedforward():
    return make_feedforward(small_fit.fit())


def test_noise_makes_no_torque_thanks_to_the_band(feedforward):
    torque, velocity = held(feedforward)
    assert np.all(torque == 0.0)
    assert np.all(velocity == 0.0)
    # The rule is what prevents it: with a band of a tenth of the noise, torque jumps by the dry friction.
    torque, velocity = held(feedforward, band=1e-4)
    assert np.std(torque) > 1.0
    assert np.all(np.abs(torque) < 4.0 * 0.7 * 1.1)
    assert np.all(velocity == 0.0)  # undercompensated: even so, the joint does not move by itself
    fit = small_fit.fit()
    np.testing.assert_array_equal(feedforward.band, fit.standstill)
    assert np.all((fit.standstill > 1e-3) & (fit.standstill < 0.1))
    assert np.all(fit.feedforward(band=0.5).band == 0.5)


def test_an_arm_that_was_pushed_comes_to_rest(feedforward):
    torque, velocity = held(feedforward, push=12.0)
    free, plain = held(replace(feedforward, share=0.0), push=12.0)
    assert np.all(free == 0.0)
    assert velocity.max() > 1.3 * plain.max()  # it is easier to move
    last = slice(int(5.0 / TICK), None)
    assert np.all(velocity[last] == 0.0)
    assert np.all(torque[last] == 0.0)


def test_compensation_never_exceeds_the_share_and_never_drives(feedforward):
    random = np.random.default_rng(1)
    q, dq = random.normal(size=(2, 500, 2)) * np.array([[[1.0]], [[0.1]]])
    torque, friction = feedforward.friction_compensation(q, dq), feedforward.friction(q, dq)
    assert np.all(torque * dq >= 0.0)
    assert np.all(np.abs(torque) <= 0.7 * np.abs(friction))
    inside, outside = np.abs(dq) < feedforward.band, np.abs(dq) > 2.0 * feedforward.band
    assert np.all(torque[inside] == 0.0)
    np.testing.assert_allclose(torque[outside], 0.7 * friction[outside])
