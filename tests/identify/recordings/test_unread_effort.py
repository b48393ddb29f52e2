"""Efforts that stay at one value while their joint moves."""

import numpy as np
import pytest

from exidyn.identification.recordings.effort_checks import unread

TIME = np.arange(1000) / 100.0
POSITION = np.stack([np.sin(TIME), np.cos(2.0 * TIME)], axis=1)


def effort(kept: float) -> np.ndarray:
    """Noise on both joints; on the first, all but a share of the samples are zero."""
    rng = np.random.default_rng(0)
    found = rng.normal(size=POSITION.shape)
    found[rng.random(len(TIME)) > kept, 0] = 0.0
    return found


def test_efforts_are_unread_where_most_samples_of_a_moving_joint_are_zero():
    share = unread(TIME, POSITION, effort(0.1))
    assert share[0] == pytest.approx(0.9, abs=0.03)
    assert share[1] == 0.0
    assert not unread(TIME, POSITION, effort(0.6)).any()
    still = POSITION.copy()
    still[:600] = still[600]
    held = effort(1.0)
    held[:600] = 3.0
    assert not unread(TIME, still, held).any()
    assert not unread(TIME[:40], POSITION[:40], np.zeros((40, 2))).any()


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e308])
def test_positions_that_are_none_are_left_out(wrong):
    damaged = POSITION.copy()
    damaged[100:103] = wrong, -wrong
    assert unread(TIME, damaged, effort(0.1)) == pytest.approx(unread(TIME, POSITION, effort(0.1)), abs=0.01)
    assert not unread(TIME, np.full_like(POSITION, wrong), effort(0.1)).any()
