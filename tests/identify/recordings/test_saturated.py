"""Positions at which a register saturates."""

import numpy as np
import pytest

from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.recordings.recording_checks import check
from exidyn.identification.recordings.restored_signals import saturated

from ...parts.runs.logs import cobot_log

TIME = np.arange(0.0, 20.0, 0.01)
SWING = np.sin(2.0 * TIME) + 0.3 * np.sin(5.0 * TIME)


@pytest.mark.parametrize("step", [1e-6, 1e-4])
def test_positions_that_a_register_holds_are_known_from_crests(step):
    measured = step * np.round(SWING / step)
    assert not saturated(measured).any()
    held = saturated(np.clip(measured, -2.0, 1.0))
    assert np.array_equal(held, measured >= 1.0)


def test_an_arm_that_rests_at_the_end_of_its_range_is_not_clipped():
    rest = np.concatenate([np.zeros(300), 0.5 - 0.5 * np.cos(TIME[:314]), np.ones(300)])
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
