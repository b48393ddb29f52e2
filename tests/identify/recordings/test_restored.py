"""Turns and signs that a log lost, samples that repeat or saturate, and velocities of something else."""

import numpy as np
import pytest

from exidyn.identification.recordings.misread_columns import signed, unwrapped
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.recordings.recording_checks import check
from exidyn.identification.recordings.restored_signals import saturated

from ...parts.runs.logs import cobot_log
from ...parts.runs.runs import require

LOG = cobot_log()
TIME = np.arange(2000) / 100.0
SWING = 900.0 * np.sin(2 * np.pi * 0.4 * TIME) + 5.0 * np.random.default_rng(2).normal(size=2000)


@pytest.mark.parametrize("turn", [2 * np.pi, 360.0])
def test_full_turns_are_undone(turn):
    angle = turn * 0.8 * np.sin(TIME)
    restored = unwrapped((angle + turn / 2) % turn - turn / 2, turn)
    assert restored is not None
    np.testing.assert_allclose(np.diff(restored.values), np.diff(angle), atol=1e-9)


def test_angles_and_signs_that_were_not_lost_stay():
    assert unwrapped(np.sin(TIME)) is None
    assert unwrapped(np.random.default_rng(1).normal(size=500) * 10.0) is None
    counts = np.round(SWING)
    restored = signed(np.where(counts < 0, 1024 - counts, counts))
    assert restored is not None
    np.testing.assert_array_equal(restored.values, counts)


@pytest.mark.parametrize("scale", [1.0, 1e-3, 2.69e-3])
@pytest.mark.parametrize("bits", [16, 32])
def test_sign_of_a_register_is_restored(bits, scale):
    counts = np.round(SWING)
    restored = signed(scale * (counts % 2.0**bits))
    assert restored is not None
    np.testing.assert_allclose(restored.values, scale * counts, rtol=1e-6, atol=scale * 1e-3)
    assert f"{bits} bits" in restored.fact


@pytest.mark.parametrize("values", [SWING, np.abs(np.round(SWING)), np.round(SWING) + 2000.0, np.zeros(500)])
def test_efforts_with_their_sign_stay(values):
    assert signed(values) is None


def test_samples_that_repeat_are_left_out():
    held = [np.repeat(one[::5], 5, axis=0)[: len(one)] for one in (LOG.position, LOG.current)]
    signals = {name: Signal(LOG.time, one) for name, one in zip(("position", "current"), held, strict=True)}
    checked = check(Recording("log", LOG.model, signals))
    assert len(checked.signals["position"]) == -(-len(LOG.time) // 5)
    assert any("repeat the one before" in warning for warning in checked.warnings)


def test_velocity_of_another_joint_and_unit_is_said():
    velocity = np.gradient(LOG.position, LOG.time, axis=0)
    velocity[:, 1], velocity[:, 2] = velocity[:, 3], 180 / np.pi * velocity[:, 2]
    signals = {
        "position": Signal(LOG.time, LOG.position),
        "velocity": Signal(LOG.time, velocity),
        "current": Signal(LOG.time, LOG.current),
    }
    warnings = check(Recording("log", LOG.model, signals)).warnings
    assert [one for one in warnings if "velocity of joint2 is not the derivative" in one]
    assert [one for one in warnings if "velocity of joint3 is 57.3 times" in one and "deg/s" in one]
    assert not [one for one in warnings if "velocity of joint1" in one]


@pytest.mark.parametrize(("digits", "scale"), [(6, 2.69), (6, 2.69e-3), (7, 1e-4)])
def test_a_sign_that_was_lost_before_scaling_is_restored(digits, scale):
    counts = np.round(SWING)
    written = np.array([float(f"{value:.{digits}g}") for value in scale * (counts % 65536)])
    restored = signed(written)
    assert restored is not None
    np.testing.assert_allclose(restored.values, scale * counts, atol=1e-3 * scale)


def test_an_effort_below_zero_throughout_is_restored_by_that_of_another_joint():
    counts = np.round(100.0 * LOG.current)
    counts[:, 1] = -100.0 - np.abs(counts[:, 1])
    signals = {
        "position": Signal(LOG.time, LOG.position),
        "current": Signal(LOG.time, 0.01 * (counts % 65536)),
    }
    checked = check(Recording("log", LOG.model, signals))
    require(checked, current=0.01 * counts, atol=1e-6)


SECONDS = np.arange(0.0, 20.0, 0.01)
CRESTS = np.sin(2.0 * SECONDS) + 0.3 * np.sin(5.0 * SECONDS)


@pytest.mark.parametrize("step", [1e-6, 1e-4])
def test_positions_that_a_register_holds_are_known_from_crests(step):
    measured = step * np.round(CRESTS / step)
    assert not saturated(measured).any()
    held = saturated(np.clip(measured, -2.0, 1.0))
    assert np.array_equal(held, measured >= 1.0)


def test_an_arm_that_rests_at_the_end_of_its_range_is_not_clipped():
    rest = np.concatenate([np.zeros(300), 0.5 - 0.5 * np.cos(SECONDS[:314]), np.ones(300)])
    assert not saturated(rest).any()


def test_they_are_left_out_with_a_warning():
    log = cobot_log()
    position = np.array(log.position)
    limit = float(np.percentile(position[:, 1], 90))
    clipped = position[:, 1] > limit
    position[:, 1] = np.minimum(position[:, 1], limit)
    run = Recording(
        "log", log.model, {"position": Signal(log.time, position), "current": Signal(log.time, log.current)}
    )
    found = check(run)
    assert len(found.signals["position"]) == len(found.signals["current"]) == np.sum(~clipped)
    assert any(text.startswith(f"position: joint2 is held at exactly {limit:g}") for text in found.warnings)
