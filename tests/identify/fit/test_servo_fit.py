"""The law of position servos, identified from runs of plain MuJoCo."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.fit.servo_fit import ServoRun, identify_servos
from tests.parts.servo_arms import ARM, log, real_arm

mujoco = pytest.importorskip("mujoco", minversion="4.0")

GAIN = np.ones(2)


@pytest.fixture(scope="module")
def run():
    return ServoRun.of(log(real_arm(), 0, "run"), GAIN)


def test_gains_and_delay_from_measured_torque(run):
    fit = identify_servos([run])
    np.testing.assert_allclose(fit.law.stiffness, (600.0, 300.0), rtol=0.02)
    np.testing.assert_allclose(fit.law.damping, (60.0, 30.0), rtol=0.02)
    np.testing.assert_allclose(fit.law.delay, 0.02, atol=1e-3)
    assert np.all(np.isinf(fit.law.limit))
    assert np.all(fit.law.integral == 0.0)
    assert np.all(np.abs(fit.law.feed_forward) < 0.02 * fit.law.damping)


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_noise_of_the_torque_does_not_make_gains_too_large(share):
    """Without the variance of the noise, a stiffness of 600 would come out as 740 or 1,170."""
    raw = log(real_arm(), 0, "run")
    torque = raw.signals["torque"]
    noise = share * np.std(torque.values, axis=0) * np.random.default_rng(9).normal(size=torque.values.shape)
    noisy = replace(raw, signals={**raw.signals, "torque": replace(torque, values=torque.values + noise)})
    run = ServoRun.of(noisy, GAIN)
    fit = identify_servos([run])
    assert np.all(np.abs(fit.law.stiffness - (600.0, 300.0)) < 3.0 * fit.std.stiffness)
    naive = identify_servos([replace(run, noise=np.zeros(2))])
    assert np.all(naive.law.stiffness > (700.0, 360.0))


def test_an_integrator_and_feed_forward_belong_to_the_law_if_the_runs_show_them(run):
    """The torque of the same motion under a law with both."""
    time = run.time
    error = run.command(time - 0.02) - run.position
    torque = (
        600.0 * error - 60.0 * run.velocity + 25.0 * run.command(time - 0.02, 1)
        + 400.0 * np.cumsum(error, axis=0) / run.rate
    )  # fmt: skip
    fit = identify_servos([replace(run, torque=torque, raw_torque=torque, noise=np.zeros(2))])
    np.testing.assert_allclose(fit.law.stiffness, 600.0, rtol=0.01)
    np.testing.assert_allclose(fit.law.feed_forward, 25.0, rtol=0.05)
    np.testing.assert_allclose(fit.law.integral, 400.0, rtol=0.05)


def test_a_limit_of_the_torque_is_found_where_it_is_reached():
    text = ARM.replace('kp="800" kv="40"', 'kp="800" kv="40" forcerange="-18 18"')
    fit = identify_servos([ServoRun.of(log(text, 0, "run"), GAIN)])
    assert fit.law.limit[0] == pytest.approx(18.0, rel=0.01)
    assert fit.law.stiffness[0] == pytest.approx(800.0, rel=0.03)
    assert np.isinf(fit.law.limit[1])


def test_current_counts_by_its_gain():
    from dataclasses import replace

    recording = log(real_arm(), 0, "run")
    torque = recording.signals["torque"]
    current = replace(torque, values=torque.values / (5.0, 2.0))
    signals = {name: signal for name, signal in recording.signals.items() if name != "torque"}
    run = ServoRun.of(replace(recording, signals=signals | {"current": current}), np.array([5.0, 2.0]))
    np.testing.assert_allclose(identify_servos([run]).law.stiffness, (600.0, 300.0), rtol=0.02)
