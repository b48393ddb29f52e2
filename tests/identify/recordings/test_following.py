"""By how much positions are behind commands, where that is known."""

import numpy as np
import pytest

from exidyn.identification.recordings.align import follows_by
from exidyn.identification.recordings.recording import Signal

TIME = np.arange(0.0, 8.0, 0.002)


def way(time):
    return np.column_stack([np.sin(2.0 * time), 0.3 * np.cos(5.0 * time) - 1.0])


@pytest.mark.parametrize("latency", [0.004, 0.0343, 0.21])
def test_it_is_found_beside_noise_a_steady_distance_and_gaps(latency):
    noise = 1e-4 * np.random.default_rng(0).standard_normal((len(TIME), 2))
    position = way(TIME - latency) + noise + [0.02, -0.01]
    position[500:520] = np.nan
    rows = np.delete(np.arange(len(TIME)), slice(1000, 1400))
    found = follows_by(Signal(TIME, way(TIME)), Signal(TIME[rows], position[rows]))
    assert found == pytest.approx(latency, abs=2e-4)


def test_it_is_unknown_at_rest_and_without_commands():
    rest = Signal(TIME, np.ones((len(TIME), 2)))
    assert np.isnan(follows_by(rest, rest))
    assert np.isnan(follows_by(Signal(TIME[:1], way(TIME[:1])), rest))
    assert np.isnan(follows_by(Signal(TIME, way(TIME)), Signal(TIME, np.full((len(TIME), 2), np.nan))))
    assert np.isnan(follows_by(Signal(TIME, way(TIME)), Signal(TIME, way(TIME - 0.5))))
