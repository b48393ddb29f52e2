"""What must hold of every driver whose arm is only read: drives that are off stay off, against its peer."""

import can
import numpy as np
import pytest

from exidyn.drivers import DRIVERS, create, driver_class
from exidyn.drivers.errors import NotReady

from ..parts.controllers.can_peers import drives, motors
from ..peers.can_arm import bus_settings
from ..peers.driver_peers import peer_of
from .test_driver_contract import arm

COUNT = 30
"""Samples that are read."""


@pytest.mark.parametrize("name", DRIVERS)
def test_it_is_read_without_power_and_without_a_command(name, tmp_path):
    peer = peer_of(name)
    with peer.running(tmp_path) as (process, settings):
        with create(name, settings, arm(name)) as driver:
            info = driver.open_to_read()
            samples = [driver.exchange(None) for _ in range(COUNT)]
            states = driver.states()
            samples += [driver.exchange(None) for _ in range(COUNT)]
            assert driver.sent_to_read
        assert peer.off(process, COUNT)
    positions = np.array([sample.position for sample in samples])
    assert np.isfinite(positions).mean() > 0.8
    assert np.nanmax(np.ptp(positions[np.isfinite(positions).all(axis=1)], axis=0)) < 0.005
    assert "position" in info.signals
    assert not any(sample.fault for sample in samples)
    assert len(states) == arm(name).dof
    assert set(states) == {peer.states}


@pytest.mark.parametrize("name", DRIVERS)
def test_settings_state_how_many_joints_there_are(name, tmp_path):
    kind = driver_class(name)
    with peer_of(name).running(tmp_path) as (_, settings):
        assert kind.count_joints(settings) == (0 if kind.simulated else arm(name).dof)


def test_axes_are_counted_where_they_are_listed():
    assert driver_class("kuka_rsi").count_joints({"axes": "A1 A2 A3 E1"}) == 4


def test_motors_that_were_left_on_stay_on():
    """A dead-man that is set while there are no commands would switch them off, and the arm would drop."""
    with motors("--on", dead_man=0.5) as (peer, driver):
        driver.open_to_read()
        for _ in range(120):  # more than twice the dead-man
            driver.exchange(None)
        assert driver.states() == ("on",) * 6
        driver.close()
        assert not peer.printed(": error")
        assert not peer.printed(": off,")


def test_what_reading_may_do_is_reported_before_anything_is_opened():
    with motors(maker="t-motor") as (peer, driver):
        assert "goes limp" in driver.risk_of_reading
        driver.open_to_read()
        sample = driver.exchange(None)
        driver.close()
        assert np.isfinite(sample.position).all()
        assert not peer.printed(": on,")
    with motors() as (_, driver):
        assert driver.risk_of_reading == ""


def test_drives_that_another_controller_moves_keep_their_network():
    with drives("--begin", "enabled") as (peer, driver):
        settings = bus_settings(peer.address)
        port = int(settings["options"].partition("port=")[2].partition(",")[0])
        with can.Bus(interface="udp_multicast", channel=settings["channel"], port=port, fd=False) as listener:
            with pytest.raises(NotReady, match="another controller moves it"):
                driver.open_to_read()
            received = []
            while (message := listener.recv(0.2)) is not None:
                received.append(message.arbitration_id)
        assert received
        assert 0x000 not in received  # network management
