"""A quick stop never sets a joint in motion, whatever its position is read as: on every driver."""

import numpy as np
import pytest

from exidyn.drivers import Command, StopLevel, create

from ..peers.driver_peers import REAL, peer_of
from .test_driver_contract import arm, listen, sent

STEP = 0.0005
"""Of the commands in a cycle [rad]: slow, so that every stopping distance is short."""
CYCLES = 60
SOUND = 0.03
"""Distance of a sound arm from what was commanded, with the way of a stop [rad]."""
TURN = 6.283
JOINT = 1


@pytest.mark.parametrize("kind", ["saturated", "exchanged", "turned"])
@pytest.mark.parametrize("name", REAL)
def test_a_quick_stop_holds_what_was_commanded_and_not_what_was_read(name, kind, tmp_path):
    with peer_of(name).running(tmp_path) as (peer, settings), create(name, settings, arm(name)) as driver:
        driver.open()
        driver.arm_drives()
        while not driver.ready:
            driver.exchange(None)
        held = driver.held()
        start = held if held is not None else driver.exchange(None).position
        for number in range(CYCLES):
            target = start + STEP * number
            sent(driver, Command(target, np.zeros(len(start))))
        peer.tell(f"sensor {kind} {JOINT} {TURN}")
        peer.wait_for("sensor wrong")
        listen(driver, 3)
        driver.stop(StopLevel.QUICK)
        listen(driver, CYCLES)
        peer.tell("truth")
        numbers = np.array(peer.wait_for("truth ").split()[1:], float)
    low, high = np.split(numbers, 2)
    assert (low > target - SOUND).all()
    assert (high < target + SOUND).all()
