"""The Dynamixel driver, against servos that run as a process."""

import random

import numpy as np
import pytest

from exidyn.drivers import Driver, StopLevel, create
from exidyn.drivers.dynamixel.packet import ERRORS
from exidyn.drivers.dynamixel.registers import MODELS, RETURN_DELAY, joins_answers
from exidyn.drivers.errors import BadSettings, LinkLost, NotReady

from ...parts.controllers.servo_parts import (
    SETTINGS,
    TURN,
    arm,
    armed,
    counting,
    driver,
    fresh,
    hold,
    peer,
    send_only,
    servo,
    still,
    until,
)


@pytest.fixture
def kind():
    return "dynamixel"


def test_servos_are_found_set_up_and_reported(servos):
    with driver("dynamixel", servos) as one:
        info = one.open()
        assert info.settings["servos"].startswith("10 XM430-W210 firmware 46, 11 XM430")
        assert info.settings["fast_sync_read"] == "on"
        assert set(info.signals) == {"position", "velocity", "current", "temperature"}
        assert "stop and hold after 2 s" in info.dead_man
        assert info.clock == "host"
        assert (info.window_lower < -30.0).all()
        assert (info.window_upper > 30.0).all()
        assert info.warnings == ()


def test_numbers_that_look_like_headers_come_through(mirrors):
    with armed(counting("dynamixel", mirrors, fast_sync_read="off")) as one:
        for count in (-1, -3, -513, 0xFFFF, 0xFFFD, -131073):
            if abs(count) < 256 * 4096:
                command = hold(np.full(6, count * TURN))
                sample, _ = until(one, lambda s: not s.stale.any(), command)
                np.testing.assert_allclose(sample.position, count * TURN, atol=1e-9)


def test_a_servo_with_a_broken_answer_is_stale_for_that_cycle(mirrors):
    with armed(counting("dynamixel", mirrors, fast_sync_read="off")) as one:
        fresh(one)
        send_only(mirrors, f"corrupt {servo(2)} 1")
        sample, events = until(one, lambda s: s.stale.any())
        assert np.isnan(sample.position[sample.stale]).all()
        assert sample.stale[2]
        assert any(event == "no complete answer from servo 12 (joint3)" for event in events)
        _, events = until(one, lambda s: not s.stale.any())
        assert any(
            event.startswith("answers again from") and "servo 12 (joint3)" in event for event in events
        )


def test_a_silent_servo_is_reported_and_the_others_go_on(mirrors):
    with armed(counting("dynamixel", mirrors, fast_sync_read="off")) as one:
        send_only(mirrors, f"silent {servo(4)}")
        try:
            sample, events = until(one, lambda s: s.stale.sum() == 1)
            assert sample.stale[4]
            assert any("servo 14" in event for event in events)
        finally:
            send_only(mirrors, "clear")


def test_noise_on_the_line_raises_nothing_and_passes(mirrors):
    with armed(counting("dynamixel", mirrors)) as one:
        chance = random.Random(0)
        for number in range(60):
            if number % 6 == 0:
                send_only(mirrors, f"babble {chance.randrange(1, 300)}")
            one.exchange(hold(np.zeros(6)))
        assert (fresh(one, hold(np.zeros(6))).position == 0.0).all()


def test_an_error_for_which_a_servo_stops_is_a_fault_and_another_an_event(servos):
    with armed(driver("dynamixel", servos)) as one:
        fresh(one)
        send_only(servos, f"error {servo(1)} 1")  # input voltage does not switch torque off
        sample, events = until(one, lambda s: s.events)
        assert sample.fault == ""
        assert "servo 11 (joint2) warns: input voltage" in events
        send_only(servos, f"error {servo(3)} 32")
        sample, _ = until(one, lambda s: s.fault)
        assert sample.fault == "servo 13 (joint4) has switched its torque off: overload"
        assert one.exchange(None).fault == sample.fault
        one.close()
        with pytest.raises(NotReady, match="servo 13 .* has stopped itself: overload.*power off and on"):
            one.open()


@pytest.mark.parametrize("fast", ["on", "off"])
@pytest.mark.parametrize("number", range(1, 8))
def test_an_answer_with_an_error_number_is_reported_and_stale(mirrors, fast, number):
    with armed(counting("dynamixel", mirrors, fast_sync_read=fast)) as one:
        fresh(one)
        send_only(mirrors, f"refuse {servo(2)} {number}")
        sample, events = until(one, lambda s: any("answers with" in event for event in s.events))
        error = f"error {number} ({ERRORS[number]})"
        assert f"servo 12 (joint3) answers with {error}: its values are not used" in events
        assert not any("no complete answer" in event and "joint3" in event for event in sample.events)
        for _ in range(10):  # as long as it has one, and reported once
            sample, events = until(one, lambda s: not np.delete(s.stale, 2).any())
            assert sample.stale[2]
            assert np.isnan([sample.position[2], sample.velocity[2], sample.current[2]]).all()
            assert np.isfinite(np.delete(sample.position, 2)).all()
            assert sample.fault == ""
            assert not any("answers with" in event for event in events)
        send_only(mirrors, f"refuse {servo(2)} 0")
        _, events = until(one, lambda s: not s.stale.any())
        assert any("answers again from" in event and "servo 12 (joint3)" in event for event in events)


def test_another_error_number_is_reported_anew_and_with_a_hardware_error(mirrors):
    with armed(counting("dynamixel", mirrors)) as one:
        fresh(one)
        for number in (1, 7):
            send_only(mirrors, f"refuse {servo(5)} {number}")
            _, events = until(one, lambda s: any("answers with" in event for event in s.events))
            assert any(f"(joint6) answers with error {number} ({ERRORS[number]}): its" in e for e in events)
        send_only(mirrors, f"error {servo(5)} 32")
        until(one, lambda s: any("written now) and a hardware error" in event for event in s.events))


def test_servos_that_refuse_before_the_run_are_not_taken_as_set_up(mirrors):
    send_only(mirrors, f"refuse {servo(1)} 1")
    with counting("dynamixel", mirrors) as one:
        with pytest.raises(LinkLost, match="servo 11 .joint2. did not answer"):
            one.open()
        send_only(mirrors, f"refuse {servo(1)} 0")
        one.open()
        send_only(mirrors, f"refuse {servo(1)} 7")
        with pytest.raises(LinkLost, match=r"servo 11 \(joint2\) answers with error 7 \(access"):
            one.arm_drives()


def test_the_bus_watchdog_stops_the_servos_when_the_computer_falls_silent(servos):
    with armed(driver("dynamixel", servos, watchdog=0.1)) as one:
        start = fresh(one).position
        Driver.clock.sleep(0.3)
        sample, _ = until(one, lambda s: s.fault, hold(start + 0.1))
        assert "this computer sent nothing for" in sample.fault
        one._armed = False  # let go without a word, as a dead computer does
        one.close()
        info = one.open()
        assert any("bus watchdog had stopped servo 10" in text for text in info.warnings)


def test_waiting_before_the_first_cycle_does_no_harm(servos):
    with armed(driver("dynamixel", servos, watchdog=1.0)) as one:
        Driver.clock.sleep(1.3)
        assert fresh(one).fault == ""
        start = still(one)
        until(one, lambda s: np.all(np.abs(s.position - start - 0.01) < 2e-3), hold(start + 0.01))


def test_a_servo_that_lost_its_power_is_a_fault(servos):
    with armed(driver("dynamixel", servos, fast_sync_read="off")) as one:
        fresh(one)
        send_only(servos, f"silent {servo(0)}")
        for _ in range(80):
            one.exchange(None)
        send_only(servos, f"reboot {servo(0)}")
        send_only(servos, "clear")
        sample, _ = until(one, lambda s: s.fault)
        assert "servo 10 (joint1) has its torque off" in sample.fault


@pytest.mark.parametrize(("at_end", "torque"), [("hold", [1] * 6), ("off", [0] * 6)])
def test_at_the_end_servos_hold_or_are_off_and_take_goals_of_others(servos, at_end, torque):
    one = driver("dynamixel", servos, at_end=at_end)
    with one:
        one.open()
        one.arm_drives()
        fresh(one)
    one.close()
    with driver("dynamixel", servos) as other:
        info = other.open()
        assert other._bus.read(other.torque) == torque
        assert info.warnings == ()  # the watchdog was let off


@pytest.mark.parametrize("wrong", [1e6, np.nan])
def test_a_goal_that_no_servo_takes_is_not_sent_and_is_a_fault(servos, wrong):
    with armed(driver("dynamixel", servos)) as one:
        start = fresh(one).position
        sample, _ = until(one, lambda s: s.fault, hold([wrong, *start[1:]]))
        assert sample.fault.startswith(f"a command was not sent: joint1 at {wrong:g} rad is count")
        assert fresh(one).fault == sample.fault


def test_old_firmware_answers_one_by_one(servos):
    send_only(servos, "set 6 1 44")
    with driver("dynamixel", servos) as one:
        info = one.open()
        assert info.settings["fast_sync_read"] == "off"
        fresh(one)
    with driver("dynamixel", servos, fast_sync_read="on") as one:
        with pytest.raises(NotReady, match="do not answer a fast sync read"):
            one.open()


@pytest.mark.parametrize("fast", ["on", "off"])
def test_every_question_of_a_run_asks_for_registers_that_are_there(servos, fast):
    with driver("dynamixel", servos, fast_sync_read=fast) as one:
        one.open()
        for reading in [*one._cool, *one._warm]:
            assert all(len(answer.data) == reading.length for answer in one._bus.ask(reading))


def test_a_watchdog_that_is_known_to_fail_is_not_relied_upon(servos):
    send_only(servos, "set 0 2 1200")
    send_only(servos, "set 6 1 51")
    with driver("dynamixel", servos) as one:
        info = one.open()
        assert info.dead_man == ""
        assert any("bus watchdog of servo 10 (joint1), servo 11" in text for text in info.warnings)
    send_only(servos, "set 6 1 52")
    with driver("dynamixel", servos) as one:
        info = one.open()
        assert "stop and hold" in info.dead_man
        assert info.warnings == ()


def test_servos_that_are_not_there_are_named(servos):
    settings = SETTINGS["dynamixel"](servos.address)
    settings["ids"] = [10, 11, 12, 13, 14, 77]
    with create("dynamixel", settings, arm()) as one, pytest.raises(LinkLost) as caught:
        one.open()
    assert "servo 77 (joint6) did not answer at 4000000 bit/s; 10, 11, 12, 13, 14 did" in str(caught.value)
    assert "57600" in str(caught.value)


def test_in_position_mode_the_limits_of_the_servos_are_the_window(mirrors):
    send_only(mirrors, "set 11 1 3")
    with counting("dynamixel", mirrors, operating_mode="position") as one:
        info = one.open()
        np.testing.assert_allclose(info.window_lower, 0.0)
        np.testing.assert_allclose(info.window_upper, 4095 * TURN)


def test_a_return_delay_is_not_changed_while_a_servo_holds_the_arm(servos):
    send_only(servos, "set 9 1 250")
    with driver("dynamixel", servos) as one:
        with pytest.raises(NotReady, match="return delay.*only while torque is off.*Support the arm"):
            one.open()
    with driver("dynamixel", servos, return_delay=500e-6, cycle=0.01) as one:
        one.open()
    send_only(servos, "set 64 1 0")
    with driver("dynamixel", servos) as one:
        one.open()
        assert one._bus.read(RETURN_DELAY) == [0] * 6


def test_the_unit_of_the_current_is_by_model_or_as_given(servos):
    send_only(servos, "set 0 2 9999")
    with driver("dynamixel", servos) as one:
        with pytest.raises(BadSettings, match="model 9999.*set current_unit"):
            one.open()
    with driver("dynamixel", servos, current_unit=0.5) as one:
        assert one.open().settings["current_unit"] == "0.5 0.5 0.5 0.5 0.5 0.5"
    send_only(servos, "set 0 2 1060")
    with driver("dynamixel", servos) as one:
        info = one.open()
        assert "current" not in info.signals
        assert any("measure no current" in text for text in info.warnings)
        assert np.isnan(fresh(one).current).all()


def test_a_line_that_is_cut_is_lost():
    with peer("dynamixel") as cut, driver("dynamixel", cut) as one:
        one.open()
        one.arm_drives()
        fresh(one)
        cut.close()
        with pytest.raises(LinkLost):
            until(one, lambda s: False)
        one.stop(StopLevel.QUICK)
        one.stop(StopLevel.OFF)


def test_servos_that_join_their_answers():
    number = {model.name: number for number, model in MODELS.items()}
    assert joins_answers(number["XM430-W210"], 45)
    assert not joins_answers(number["XM430-W210"], 44)
    assert not joins_answers(number["XL330-M288"], 45)
    assert not joins_answers(number["2XL430-W250"], 50)
    assert not joins_answers(number["MX-64(2.0)"], 50)
    assert not joins_answers(4711, 50)
