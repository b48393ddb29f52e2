"""Driver can_mit against motors in another process on a real python-can bus."""

import can
import numpy as np
import pytest

from exidyn.drivers import Command, Driver, StopLevel, create
from exidyn.drivers.errors import BadSettings, NotReady

from ...parts.controllers.can_peers import ARM, armed, command, follow, motors, standing, until_fault
from ...peers.can_arm import MASTER, mit_settings, multicast

STEP = 25.0 / 65535.0
"""Of position in a frame [rad]."""


def test_the_arm_follows_and_its_units_are_ours():
    with motors() as (peer, driver):
        info = driver.open()
        assert info.signals == ("position", "velocity", "torque", "temperature")
        assert "switched off 2 s" in info.dead_man
        assert "TIMEOUT 40000 read back" in info.dead_man
        assert "answers with torque in N m" in info.settings["joint2 (motor 2)"]
        assert "KT_Value 0.945" in info.settings["joint2 (motor 2)"]
        assert not peer.printed("on")
        driver.arm_drives()
        where = standing(driver)
        np.testing.assert_allclose(where, [0.0, -1.0, 1.0, 0.0, 0.5, 0.0], atol=STEP)
        samples = [sample for sample in follow(driver, where) if not sample.stale.any()]
        assert len(samples) > 20
        reached = np.array([sample.position for sample in samples])
        assert (reached.max(axis=0) - where > 0.09).all()
        np.testing.assert_allclose(samples[-1].torque, 0.1 * np.arange(1, 7), atol=0.003)
        np.testing.assert_allclose(samples[-1].temperature, 25.0)
        assert np.isnan(samples[-1].current).all()


def test_motors_are_switched_on_with_zero_gains():
    with motors() as (peer, driver):
        armed(driver)
        for number in range(1, 7):
            assert peer.wait_for(f"motor {number}: on, gains (0.0, 0.0)")


def test_velocity_has_the_joints_sign():
    with motors() as (_, driver):
        where = armed(driver)
        velocity = 0.5 * np.arange(1, 7)
        for _ in range(10):
            sample = driver.exchange(Command(where, velocity))
        fresh = ~sample.stale
        np.testing.assert_allclose(sample.velocity[fresh], velocity[fresh], atol=0.01)


def test_a_torque_constant_gives_current_too():
    with motors(torque_constant=2.0) as (_, driver):
        assert "current" in driver.open().signals
        sample = driver.exchange(None)
        fresh = ~sample.stale
        np.testing.assert_allclose(sample.current[fresh], sample.torque[fresh] / 2.0)


@pytest.mark.parametrize("short", [True, False])
def test_both_answers_of_the_other_maker_are_read(short):
    arguments = ["--short"] if short else []
    with motors(*arguments, maker="t-motor", current_range=10.0) as (_, driver):
        info = driver.open()
        assert "current" in info.signals
        assert "torque" not in info.signals
        assert ("temperature" in info.signals) is not short
        assert not info.dead_man
        assert any("keeps following its last command" in text for text in info.warnings)
        driver.arm_drives()
        where = standing(driver)
        samples = [sample for sample in follow(driver, where) if not sample.stale.any()]
        assert len(samples) > 20
        np.testing.assert_allclose(samples[-1].current, 0.1 * np.arange(1, 7), atol=0.003)


def test_without_a_current_range_the_other_maker_is_read_as_torque_with_a_warning():
    with motors(maker="t-motor") as (_, driver):
        info = driver.open()
        assert "torque" in info.signals
        assert any("set current_range" in text for text in info.warnings)


def test_ranges_that_are_not_the_motors_are_refused():
    with motors("--register", "3:23=28.0") as (_, driver):
        with pytest.raises(NotReady, match=r"joint3 \(motor 3\) has TMAX = 28, its model here has 10"):
            driver.open()


def test_an_old_error_is_reported_and_cleared_by_arming():
    with motors("--error", "9") as (peer, driver):
        info = driver.open()
        assert any("joint1 (motor 1) has error 9 (under-voltage)" in text for text in info.warnings)
        driver.arm_drives()
        assert peer.wait_for("motor 6: on")


def test_motors_switch_off_when_the_host_falls_silent():
    with motors() as (peer, driver):
        where = armed(driver)
        follow(driver, where, 20)
        for number in range(1, 7):
            peer.wait_for(f"motor {number}: error 13")
        sample = until_fault(driver, where)
        assert "this computer sent nothing for" in sample.fault
        samples = [sample, *(driver.exchange(None) for _ in range(10))]
        events = [event for sample in samples for event in sample.events]
        assert sum("error 13 (host silent)" in event for event in events) == 6
        assert not peer.printed(": on, gains (200")


def test_reading_goes_on_after_a_pause_of_this_computer():
    with motors(dead_man=0.1) as (_, driver):
        driver.open_to_read()
        driver.exchange(None)
        Driver.clock.sleep(1.2)
        samples = [driver.exchange(None) for _ in range(5)]
        assert not samples[-1].stale.any()
        assert samples[-1].fault == ""


def test_a_dead_man_shorter_than_some_cycles_is_refused():
    with pytest.raises(
        BadSettings, match=r"dead_man is 0.05 s, less than 3 cycles of 0.02 s.*Try dead_man = 0.06"
    ):
        create("can_mit", mit_settings("1") | {"cycle": 0.02, "dead_man": 0.05}, ARM)
    create("can_mit", mit_settings("1", maker="t-motor") | {"cycle": 0.02, "dead_man": 0.05}, ARM)


def test_an_answer_with_a_register_is_no_state():
    with motors() as (peer, driver):
        where = armed(driver)
        with multicast(int(peer.address)) as other:
            register = bytes([3, 0, 0x33, 21]) + bytes(4)  # as motor 3 answers another program
            other.send(can.Message(arbitration_id=MASTER + 3, data=register, is_extended_id=False))
            samples = [driver.exchange(command(where)) for _ in range(5)]
        seen = [sample.position[2] for sample in samples if not sample.stale[2]]
        np.testing.assert_allclose(seen, where[2], atol=0.01)
        assert samples[-1].fault == ""


def test_a_position_at_the_end_of_its_range_is_not_used():
    with motors() as (peer, driver):
        armed(driver)
        peer.tell("sensor saturated 2 0.0")
        peer.wait_for("sensor wrong")
        samples = [driver.exchange(None) for _ in range(5)]
        assert np.isnan(samples[-1].position[2])
        assert sum("is the end of its range" in event for sample in samples for event in sample.events) == 1


def test_motors_whose_positions_jump_are_not_switched_on():
    with motors("--jumpy", 4) as (_, driver):
        driver.open()
        with pytest.raises(
            NotReady, match=r"joint4 \(motor 4\) is not switched on: its last 5 positions differ by"
        ):
            driver.arm_drives()


def test_a_quick_stop_holds_and_off_switches_off():
    with motors() as (peer, driver):
        where = armed(driver)
        for k in range(20):
            driver.exchange(command(where + 0.002 * k))
        driver.stop(StopLevel.QUICK)
        samples = [driver.exchange(command(where)) for _ in range(60)]
        # A motor whose process had to wait answers the first of them with where it was on the way.
        last = [sample.position for sample in samples[30:] if not sample.stale.any()]
        assert (np.abs(last[-1] - last[0]) < 0.005).all()
        assert (last[-1] - where > 0.02).all()
        assert not peer.printed(": off")
        driver.stop(StopLevel.OFF)
        for number in range(1, 7):
            peer.wait_for(f"motor {number}: off")
        assert not driver.exchange(None).fault


def test_after_the_end_held_motors_do_not_miss_the_host():
    with motors(dead_man=1.0) as (peer, driver):
        follow(driver, armed(driver), 20)
        driver.close()
        with pytest.raises(LookupError):
            peer.wait_for("error 13", 2.0)
        assert not peer.printed(": off")
        assert not peer.printed("store")


def test_a_motor_that_runs_away_is_not_left_running_at_the_end():
    with motors("--fault", "runaway:3@5") as (peer, driver):
        where = armed(driver)
        while not peer.printed("motor 3: now runaway"):
            driver.exchange(command(where))
        driver.close()
        for number in range(1, 7):
            assert peer.wait_for(f"motor {number}: off")


def test_after_the_end_motors_are_off_where_that_is_wanted():
    with motors(at_close="off") as (peer, driver):
        follow(driver, armed(driver), 20)
        driver.close()
        for number in range(1, 7):
            peer.wait_for(f"motor {number}: off")
        driver.close()
        with pytest.raises(NotReady):
            driver.exchange(None)


def test_what_does_not_fit_into_a_frame_is_a_fault_and_not_sent():
    with motors() as (_, driver):
        where = armed(driver)
        sample = driver.exchange(command(where + 13.0))
        assert "joint1 (motor 1): a command of 12.95 rad" in sample.fault
        for _ in range(5):
            sample = driver.exchange(None)
        assert (np.abs(sample.position - where)[~sample.stale] < 0.01).all()
