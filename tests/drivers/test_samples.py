"""Samples by a host's clock and by a controller's."""

import numpy as np
import pytest

from exidyn.drivers.host_clock import Tick
from exidyn.drivers.samples import ControllerSamples, HostSamples

TICK = Tick(7, 2e-4, 3)


def test_what_is_not_measured_is_unknown_and_a_silent_joint_gives_no_number():
    position = np.array([1.0, 2.0])
    samples = HostSamples(2)
    whole = samples.of(5, TICK, [True, True], position=position, events=("warm",), fault="")
    assert (whole.host_time, whole.controller_time, whole.lateness, whole.skipped) == (5, 5, 2e-4, 3)
    np.testing.assert_array_equal(whole.position, position)
    assert np.isnan(whole.current).all()
    assert not whole.stale.any()
    assert whole.events == ("warm",)
    part = samples.of(6, TICK, [True, False], position=position, fault="stopped")
    np.testing.assert_array_equal(part.position, [1.0, np.nan])
    np.testing.assert_array_equal(part.stale, [False, True])
    assert part.fault == "stopped"
    np.testing.assert_array_equal(position, [1.0, 2.0])


def test_arrays_that_samples_share_cannot_be_written():
    sample = HostSamples(2).of(5, TICK, [True, True])
    with pytest.raises(ValueError, match="read-only"):
        sample.stale[0] = True
    with pytest.raises(ValueError, match="read-only"):
        sample.torque[0] = 0.0


def test_cycles_that_are_missing_are_counted_once():
    samples = ControllerSamples(1, 2, 0.004)

    def measured(time):
        return samples.of(time, time + 100, samples.cycles(time), 0.0, position=np.zeros(1), sent=True)

    assert measured(4_000_000).skipped == 0
    assert measured(16_000_000).skipped == 2
    silent = samples.of_silence(3, events=(), fault="", sent=False)
    assert (silent.skipped, silent.controller_time) == (2, 16_000_000)
    assert silent.stale.all()
    assert np.isnan(silent.state).all()
    assert measured(36_000_000).skipped == 1  # of five cycles, the first three were reported
    samples.restart()
    assert measured(400_000_000).skipped == 0


def test_times_of_the_host_never_go_back():
    samples = ControllerSamples(1, 0, 0.004)
    first = samples.of(1, 1000, 1, 0.0)
    assert samples.of(2, 900, 1, 0.0).host_time == first.host_time + 1


def test_lateness_is_over_the_quickest_message():
    samples = ControllerSamples(1, 0, 0.001)
    assert samples.lateness(1_000_000, 0) == 0.0
    samples.of(0, 1_000_000, 1, 0.0)
    assert samples.lateness(2_500_000, 1_000_000) == pytest.approx(5e-4, abs=1e-6)
