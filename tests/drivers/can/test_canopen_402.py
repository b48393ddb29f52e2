"""Driver canopen_402 against drives in another process on a real python-can bus."""

import can
import numpy as np
import pytest

from exidyn.drivers import Driver, StopLevel, create
from exidyn.drivers.errors import LinkLost, NotReady

from ...parts.controllers.can_peers import ARM, armed, command, drives, follow, standing, until_fault
from ...peers.can_arm import canopen_settings


def listen(driver, cycles):
    for _ in range(cycles):
        driver.exchange(None)


def test_the_arm_follows_and_its_units_are_ours():
    with drives() as (peer, driver):
        info = driver.open()
        assert info.cycle == 0.01
        assert info.clock == "host"
        assert info.signals == ("position", "current")
        assert "quick stop 2 s" in info.dead_man
        assert "vendor 0x00001234" in info.settings["joint3 (node 3)"]
        assert "'Example Drive 3'" in info.settings["joint3 (node 3)"]
        driver.arm_drives()
        where = standing(driver)
        np.testing.assert_allclose(where, [0.0, -1.0, 1.0, 0.0, 0.5, 0.0], atol=1e-6)
        samples = [sample for sample in follow(driver, where) if not sample.stale.any()]
        assert len(samples) > 20
        np.testing.assert_allclose(samples[-1].current, 0.1 * np.arange(1, 7), atol=0.0021)
        reached = np.array([sample.position for sample in samples])
        assert (reached.max(axis=0) - where > 0.09).all()
        assert np.isnan(samples[0].velocity).all()
        assert not peer.printed("0x8611")


def test_a_sample_at_500_hz_has_all_joints():
    with drives(cycle=0.002) as (_, driver):
        armed(driver)
        fresh = [not driver.exchange(None).stale.any() for _ in range(500)]
        assert all(fresh)


def test_what_is_set_is_in_the_drives():
    with drives(following_error=0.2, write_limits=True) as (_, driver):
        driver.open()
        sdo = driver._network._network[3].sdo
        read = {
            (index, sub): int.from_bytes(sdo.upload(index, sub), "little", signed=index == 0x60C2)
            for index, sub in EXPECTED
        }
    assert read == EXPECTED


COUNTS_PER_RADIAN = 131072 * 101 / (2.0 * np.pi)
EXPECTED = {
    (0x6060, 0): 8, (0x6061, 0): 8, (0x60C2, 1): 10, (0x60C2, 2): -3, (0x1006, 0): 10000,
    (0x6007, 0): 3, (0x605A, 0): 6, (0x605E, 0): 2, (0x1016, 1): 127 << 16 | 2000, (0x1017, 0): 1000,
    (0x1400, 1): 0x203, (0x1400, 2): 1, (0x1600, 0): 2, (0x1600, 1): 0x60400010, (0x1600, 2): 0x607A0020,
    (0x1401, 1): 0x80000303, (0x1402, 1): 0x80000403, (0x1403, 1): 0x80000503,
    (0x1800, 1): 0x183, (0x1800, 2): 1, (0x1A00, 0): 3, (0x1A00, 1): 0x60410010, (0x1A00, 2): 0x60640020,
    (0x1A00, 3): 0x60780010, (0x1801, 1): 0x80000283, (0x1003, 0): 0,
    (0x6065, 0): round(0.2 * COUNTS_PER_RADIAN), (0x6066, 0): 20,
    (0x607D, 2): int((3.0 - 0.15) * COUNTS_PER_RADIAN),
}  # fmt: skip


def test_nothing_is_ever_stored_in_a_drive():
    with drives(at_close="off") as (peer, driver):
        follow(driver, armed(driver), 20)
        driver.close()
        assert not peer.printed("store")


def test_torque_is_at_the_joint():
    with drives(effort="torque") as (_, driver):
        assert driver.open().signals == ("position", "torque")
        sample = driver.exchange(None)
        raw = 0.1 * np.arange(1, 7) / 4.0  # the peer gives the same share of rated as its current
        fresh = ~sample.stale
        np.testing.assert_allclose(sample.torque[fresh], (raw * 2.0 * 101.0)[fresh], rtol=0.02)
        assert np.isnan(sample.current).all()


def test_old_errors_are_reported_and_cleared():
    with drives() as (_, driver):
        assert any("0x8130 (heartbeat lost)" in text for text in driver.open().warnings)
        driver.close()
        again = create("canopen_402", canopen_settings(driver.settings.options[5:].split(",")[0]), ARM)
        with again:
            assert not again.open().warnings


def test_a_drive_in_fault_is_named_and_reset_by_arming():
    with drives("--begin", "fault") as (peer, driver):
        warnings = driver.open().warnings
        assert "joint1 (node 1) was in fault 0x3210 (DC link over-voltage)" in warnings[0]
        driver.arm_drives()
        assert peer.wait_for("node 6: enabled")


def test_arming_after_a_held_stop_goes_through_no_state_without_torque():
    with drives() as (peer, driver):
        armed(driver)
        driver.stop(StopLevel.QUICK)
        peer.wait_for("node 6: stopping")
        for _ in range(5):
            driver.exchange(None)
        before = len(peer.lines)
        driver.arm_drives()
        assert peer.wait_until(lambda: len(peer.lines) >= before + 6)
        assert {line.split(": ")[1].strip() for line in peer.lines[before:]} == {"enabled"}


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (["--object", "2:0x6075:0=0"], NotReady, ["joint2 (node 2)", "rated current", "= 0"]),
        (["--object", "4:0x1000:0=0x191"], NotReady, ["joint4", "profile 401", "402"]),
        (["--object", "1:0x6502:0=0x2D"], NotReady, ["joint1", "mode 8", "0x0000002D"]),
        (["--without", "5:0x6064:0"], NotReady, ["joint5", "0x6064:0 (position)", "needs"]),
        (["--without", "3:0x607A:0"], NotReady, ["joint3", "takes 0x607A:0 (target position) into no PDO"]),
        (["--begin", "enabled"], NotReady, ["joint1", "operation enabled already", "another controller"]),
    ],
)
def test_a_drive_that_cannot_be_used_is_refused(change, error, words):
    with drives(*change) as (peer, driver):
        with pytest.raises(error) as caught:
            driver.open()
        assert all(word in str(caught.value) for word in words), caught.value
        driver.close()


def test_a_target_that_jumps_ends_in_a_following_error():
    with drives() as (_, driver):
        where = armed(driver)
        sample = until_fault(driver, where + 1.0)
        assert "0x8611 (following error)" in sample.fault


def test_a_command_that_is_no_number_is_a_fault_and_not_sent():
    with drives() as (peer, driver):
        where = armed(driver)
        where[1] = np.nan
        assert "is not a position" in driver.exchange(command(where)).fault
        assert not peer.printed("0x8611")


def test_drives_stop_when_the_host_falls_silent():
    with drives() as (peer, driver):
        follow(driver, armed(driver), 20)
        for number in range(1, 7):
            peer.wait_for(f"node {number}: emergency 0x8130")
            peer.wait_for(f"node {number}: stopping")
        samples = [driver.exchange(None) for _ in range(5)]
        assert "this computer sent nothing for" in samples[-1].fault
        assert any("heartbeat lost" in event for sample in samples for event in sample.events)


def test_after_a_pause_of_this_computer_drives_are_not_enabled_again_and_nothing_moves():
    with drives(dead_man=0.2) as (peer, driver):
        where = armed(driver)
        follow(driver, where, 20)
        stood, before = standing(driver), sum("enabled" in line for line in peer.lines)
        Driver.clock.sleep(0.6)  # the drives' watchdog stops them
        peer.wait_for("node 6: stopping")
        samples = [driver.exchange(command(stood + 0.3)) for _ in range(40)]
        assert "this computer sent nothing for" in samples[0].fault
        assert sum("enabled" in line for line in peer.lines) == before
        fresh = [sample.position for sample in samples if not sample.stale.any()]
        assert fresh
        assert (np.abs(np.array(fresh) - stood) < 0.01).all()


def test_two_drives_with_one_number_are_stale_and_told():
    with drives() as (peer, driver):
        armed(driver)
        peer.tell("double 3")
        samples = [driver.exchange(None) for _ in range(20)]
        assert any("two different answers" in event for sample in samples for event in sample.events)
        assert samples[-1].stale.tolist() == [False, False, True, False, False, False]


def test_a_quick_stop_holds_and_off_overrides_it():
    with drives() as (peer, driver):
        armed(driver)
        driver.stop(StopLevel.QUICK)
        peer.wait_for("node 6: stopping")
        samples = [driver.exchange(None) for _ in range(10)]
        assert not any(sample.fault for sample in samples)
        driver.stop(StopLevel.OFF)
        peer.wait_for("node 6: switch-on disabled")
        driver.stop(StopLevel.QUICK)
        for _ in range(5):
            driver.exchange(None)
        assert peer.lines[-1].strip().endswith("switch-on disabled")


@pytest.mark.parametrize(("how", "last"), [("hold", "stopping"), ("off", "switch-on disabled")])
def test_after_the_end_drives_do_not_miss_the_host(how, last):
    with drives(at_close=how, dead_man=1.0) as (peer, driver):
        follow(driver, armed(driver), 20)
        driver.close()
        peer.wait_for(f"node 6: {last}")
        with pytest.raises(LookupError):
            peer.wait_for("0x8130", 2.0)
        driver.close()  # again
        with pytest.raises(NotReady):
            driver.exchange(None)


def test_noise_changes_nothing():
    with drives("--fault", "noise:0@0") as (_, driver):
        where = armed(driver)
        samples = follow(driver, where, 100)
        assert len(samples) == 100
        assert not samples[-1].fault
        fresh = [sample for sample in samples if not sample.stale.any()]
        assert fresh
        assert all(np.isfinite(sample.position).all() for sample in fresh)
        assert all((np.abs(sample.position - where) < 0.11).all() for sample in fresh)


def test_drives_that_are_all_gone_are_a_lost_link():
    with drives(hasty=True) as (peer, driver):
        armed(driver)
        peer.process.kill()
        with pytest.raises(LinkLost, match="nothing was received"):
            listen(driver, 500)


def test_drives_on_a_serial_adapter():
    with drives("--adapter", bitrate=500_000, cycle=0.02) as (peer, driver):
        where = armed(driver)
        samples = follow(driver, where, 30)
        assert peer.wait_for("adapter got S6")
        assert not samples[-1].fault
        assert any(not sample.stale.any() for sample in samples)


def test_a_bus_that_is_not_there_is_a_lost_link():
    table = {**canopen_settings("43113"), "interface": "slcan", "channel": "/dev/nonsense", "options": ""}
    with create("canopen_402", table, ARM) as driver, pytest.raises(LinkLost, match="slcan /dev/nonsense"):
        driver.open()


def test_settings_reach_the_bus(monkeypatch):
    asked = {}

    def no_bus(**options):
        asked.update(options)
        raise can.CanInitializationError("not today")

    monkeypatch.setattr(can, "Bus", no_bus)
    table = {
        **canopen_settings("43113"),
        "interface": "slcan",
        "channel": "/dev/ttyACM0",
        "options": "tty_baudrate=3000000, rtscts=true",
    }
    with create("canopen_402", table, ARM) as driver, pytest.raises(LinkLost, match="not today"):
        driver.open()
    assert asked == {
        "interface": "slcan",
        "channel": "/dev/ttyACM0",
        "bitrate": 1_000_000,
        "tty_baudrate": 3_000_000,
        "rtscts": True,
        "ignore_config": True,
    }
