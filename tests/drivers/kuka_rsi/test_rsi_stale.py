"""Measurements that cannot be of their cycle, from a controller by hand, as the driver samples them."""

from contextlib import contextmanager

import numpy as np
import pytest

from exidyn.drivers.kuka_rsi.plausibility import ALIVE
from exidyn.drivers.values import SIGNALS

from ...parts.controllers.rsi_controller import START, by_hand, config_file, driver, telegram


class Measured:
    """An arm of which axis 2 moves by 0.01 degrees a cycle, with noisy currents."""

    def __init__(self, controller, kuka):
        self.controller, self.kuka = controller, kuka
        self.position, self.random = np.array(START), np.random.default_rng(0)

    def go(self, cycles):
        """Samples of as many new measurements."""
        samples = []
        for _ in range(cycles):
            self.position[1] += 0.01
            self.current = 5.0 + 0.1 * self.random.standard_normal(6)
            samples.append(self.again())
        return samples

    def again(self, spike=0.0):
        """The sample of the last measurement under a new stamp; a spike moves axis 3 [deg]."""
        position = self.position + spike * np.eye(6)[2]
        self.stamp = self.controller.send(position=position, current=self.current)
        return self.kuka.exchange(None)


@contextmanager
def measured(folder):
    path = config_file(folder)
    with by_hand(path) as controller, driver(path) as kuka:
        controller.begun(kuka)
        yield Measured(controller, kuka)


def test_an_old_measurement_under_a_new_stamp_is_stale_and_answered(tmp_path):
    with measured(tmp_path) as arm:
        before = arm.go(ALIVE + 1)
        assert not any(sample.stale.any() or sample.events for sample in before)
        sample = arm.again()
        assert sample.stale.all()
        assert "sent an old measurement under a new time stamp (1 so far)" in sample.events[0]
        assert (sample.sent, sample.fault) == (True, "")
        assert sample.controller_time == before[-1].controller_time + 4_000_000
        for name in SIGNALS:
            assert np.isnan(getattr(sample, name)).all()
        while f"<IPOC>{arm.stamp}<" not in arm.controller.answer():
            pass
        assert not any(sample.stale.any() or sample.events for sample in arm.go(3))


def test_a_position_that_no_axis_reaches_is_stale_and_the_others_go_on(tmp_path):
    with measured(tmp_path) as arm:
        arm.go(5)
        sample = arm.again(spike=90.0)
        assert sample.stale.tolist() == [False, False, True, False, False, False]
        assert np.isnan(sample.position[2])
        assert np.isnan(sample.current[2])
        np.testing.assert_allclose(np.delete(sample.position, 2), np.radians(np.delete(arm.position, 2)))
        assert sample.events[0].startswith("A3 is 90 degrees from where it was 4 ms before")
        assert sample.fault == ""
        assert not any(sample.stale.any() or sample.events for sample in arm.go(3))


@pytest.mark.parametrize("text", [b"nan", b"inf", b"1e999", b"-1.#IND", b""])
def test_a_telegram_with_a_position_that_is_no_number_is_no_sample(tmp_path, text):
    path = config_file(tmp_path)
    with by_hand(path) as controller, driver(path) as kuka:
        controller.begun(kuka)
        controller.stamp += 4
        controller.raw(telegram(controller.stamp).replace(b'A1="10.0000"', b'A1="' + text + b'"', 1))
        sample = kuka.exchange(None)
        assert sample.stale.all()
        assert "1 telegram could not be read" in sample.events
        controller.send()
        assert not kuka.exchange(None).stale.any()
