"""Driver canopen_402 and drives that are not ours: canopen's LocalNode, ROS-Industrial's dictionary."""

from contextlib import contextmanager

import can
import canopen
import numpy as np
import pytest

from exidyn.drivers import create
from exidyn.drivers.errors import NotReady

from ...parts.controllers.can_peers import ARM, SLOW, command, follow, late_answers_count, standing
from ...parts.system_needs import MULTICAST
from ...peers.can_arm import CHANNEL, COUNTS, GEAR, canopen_settings, sign, zero
from ...peers.local_drives import drives_on
from ...peers.peer_process import Peer
from ...peers.ros2_dictionary import ros2_dictionary

pytestmark = pytest.mark.clocked

PER_RADIAN = sign(6) * COUNTS * GEAR / (2.0 * np.pi)
WHERE = np.array([0.0, -1.0, 1.0, 0.0, 0.5, 0.0])
POSITIONS = [round(one) for one in (WHERE - zero(6)) * PER_RADIAN]
SETTINGS = {
    "cycle": SLOW,
    "current_object": "0x606C:0 int32",  # there is no current; its velocity can be checked
    "current_scale": 1e-6,
    "require_dead_man": False,
}
"""What it takes to use these drives; nothing is added to their dictionary."""


@contextmanager
def in_a_process():
    MULTICAST.require()
    with Peer("local_drives.py", *POSITIONS, shared=False) as process:
        yield canopen_settings(process.address)


@contextmanager
def in_this_process():
    network = canopen.Network()
    network.connect(interface="virtual", channel="foreign", ignore_config=True)
    try:
        drives_on(network, ros2_dictionary, POSITIONS, lambda *_, **__: None)
        more = {"interface": "virtual", "channel": "foreign", "options": ""}
        yield {**canopen_settings("0"), **more}
    finally:
        network.disconnect()


@pytest.fixture(params=[in_a_process, in_this_process], ids=["udp_multicast", "virtual"])
def foreign(request):
    """Settings that reach drives on a bus."""
    with late_answers_count(), request.param() as settings:
        yield settings


def test_they_run_with_settings_only(foreign):
    with create("canopen_402", {**foreign, **SETTINGS}, ARM) as driver:
        info = driver.open()
        assert info.signals == ("position", "current")
        assert "vendor 0x00000555" in info.settings["joint1 (node 1)"]
        assert not info.dead_man
        assert len(info.warnings) == 6
        assert all("no 0x6007:0" in text for text in info.warnings)
        driver.arm_drives()
        np.testing.assert_allclose(standing(driver), WHERE, atol=1e-6)
        samples = follow(driver, WHERE, 200)
        assert len(samples) == 200
        assert not samples[-1].fault
        fresh = [sample for sample in samples if not sample.stale.any()]
        assert len(fresh) > 50
        reached = np.array([sample.position for sample in fresh])
        assert (reached.max(axis=0) - WHERE > 0.09).all()
        fastest = 1e-6 * np.abs(PER_RADIAN) * 0.05 * 2.0 * np.pi / (200 * SLOW)
        moved = np.abs([sample.current for sample in fresh])
        np.testing.assert_allclose(np.median(moved, axis=0), fastest / np.sqrt(2.0), rtol=0.2)


def test_each_thing_that_they_lack_is_one_line(foreign):
    wanted = dict(SETTINGS)
    lines = []
    for name, words in (
        ("require_dead_man", ["0x6007:0", "require_dead_man = false"]),
        ("current_scale", ["0x6075:0", "rated_current", "current_scale"]),
        ("current_object", ["neither 0x6078:0", "0x6077:0", "current_object"]),
    ):
        del wanted[name]
        with create("canopen_402", {**foreign, **wanted}, ARM) as driver, pytest.raises(NotReady) as caught:
            driver.open()
        lines.append(str(caught.value))
        assert all(word in lines[-1] for word in [*words, "joint1 (node 1)"]), lines[-1]
        assert "\n" not in lines[-1]


def test_frames_of_others_do_not_command_them():
    with in_a_process() as settings:
        port = int(settings["options"].split("=")[1].split(",")[0])
        with (
            create("canopen_402", {**settings, **SETTINGS}, ARM) as driver,
            can.Bus(
                interface="udp_multicast", channel=CHANNEL, port=port, fd=False, ignore_config=True
            ) as other,
        ):
            driver.open()
            driver.arm_drives()
            for base in (0x300, 0x400, 0x500):  # RPDO 2 to 4, as delivered: controlword 0 first
                other.send(can.Message(arbitration_id=base + 2, data=bytes(8), is_extended_id=False))
            assert not any(driver.exchange(command(WHERE)).fault for _ in range(20))
