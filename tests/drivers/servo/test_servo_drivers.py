"""What the drivers of servos have in common, against servos that run as a process."""

import numpy as np
import pytest

from exidyn.drivers import Command, StopLevel, create
from exidyn.drivers.errors import BadSettings, NotReady

from ...parts.controllers.servo_parts import (
    SETTINGS,
    TURN,
    arm,
    armed,
    counting,
    driver,
    fresh,
    hold,
    send_only,
    servo,
    still,
    until,
)

BOTH = pytest.mark.parametrize("kind", SETTINGS)


@pytest.mark.parametrize(
    ("kind", "settings", "near"),
    [
        ("dynamixel", {"fast_sync_read": "on"}, 2e-3),
        ("dynamixel", {"fast_sync_read": "off"}, 2e-3),
        ("feetech", {}, 4e-3),
    ],
)
def test_the_arm_follows_and_reports_position_velocity_and_current(servos, kind, settings, near):
    with armed(driver(kind, servos, **settings)) as one:
        start = still(one)
        samples = []
        for number in range(300):
            sweep = 0.1 * (1.0 - np.cos(np.pi * number / 300)) * np.ones(6)
            samples.append(one.exchange(Command(start + sweep, np.zeros(6))))
        until(one, lambda s: np.all(np.abs(s.position - start - 0.2) < near), hold(start + 0.2))
    speed = np.nanmax([sample.velocity for sample in samples], axis=0)
    assert (speed > 0.05).all()  # its own sign and gear on every joint
    assert np.nanmax(np.abs([sample.current for sample in samples])) > 0.5
    temperature = [sample.temperature for sample in samples]
    assert np.nanmin(temperature) > 10.0
    assert kind == "feetech" or np.isnan(temperature).any()  # read in some cycles only


@pytest.mark.parametrize(("kind", "late"), [("dynamixel", (0.0045, 0.0135)), ("feetech", (0.02, 0.029))])
def test_every_fresh_sample_is_of_its_own_cycle_on_both_sides_of_zero(mirrors, kind, late):
    trouble = {-80: f"late {late[0]} 1", 10: f"late {late[1]} 1", 50: "short 1"}
    with armed(counting(kind, mirrors)) as one:
        checked = 0
        for number in range(-100, 100):
            if number in trouble:
                send_only(mirrors, trouble[number])
            sample = one.exchange(hold(np.full(6, number * TURN)))
            checked += not sample.stale.any()
            np.testing.assert_allclose(sample.position[~sample.stale], number * TURN, atol=1e-9)
        assert checked > 50


@BOTH
def test_a_quick_stop_holds_where_the_arm_is_and_no_command_moves_it_again(servos, kind):
    with armed(driver(kind, servos)) as one:
        start = fresh(one).position
        for number in range(100):
            one.exchange(hold(start + 0.001 * number))
        one.stop(StopLevel.QUICK)
        here = fresh(one).position
        for _ in range(100):
            one.exchange(hold(start + 1.0))
        np.testing.assert_allclose(fresh(one).position, here, atol=0.03)
        one.stop(StopLevel.OFF)
        one.stop(StopLevel.QUICK)
        fresh(one)
        assert one._bus.read(one.torque) == [0] * 6


@pytest.mark.parametrize(
    ("kind", "line", "settings", "message"),
    [
        (
            "dynamixel",
            "heal",
            {"operating_mode": "position"},
            r"servo 10 .* operating mode 4, not 3 \(position\).*extended is 4",
        ),
        ("feetech", "set 33 1 1", {}, r"servo 10 .* operating mode 1, not 0 \(position\)"),
    ],
)
def test_another_operating_mode_is_refused(servos, kind, line, settings, message):
    send_only(servos, line)
    with driver(kind, servos, **settings) as one, pytest.raises(NotReady, match=message):
        one.open()


@pytest.mark.parametrize(("kind", "silent"), [("dynamixel", ()), ("feetech", range(6))])
def test_an_adapter_that_hears_itself_is_not_taken_for_servos(servos, kind, silent):
    send_only(servos, "echo")
    for place in silent:
        send_only(servos, f"silent {servo(place)}")
    with driver(kind, servos) as one, pytest.raises(NotReady, match="the adapter echoes"):
        one.open()


@pytest.mark.parametrize(
    ("kind", "change", "message"),
    [
        (
            "dynamixel",
            {"baudrate": 1_000_000, "cycle": 0.001},
            "cycle of 1 ms is too short.*baudrate of 2000000",
        ),
        ("dynamixel", {"ids": 3}, "two joints have the servo 3"),
        ("feetech", {"cycle": 0.0015}, "40 bytes out and 126 back at 1000000 bit/s.*cycle of 0.0019 s"),
    ],
)
def test_settings_that_a_line_cannot_carry_are_refused(kind, change, message):
    with pytest.raises(BadSettings, match=message):
        create(kind, SETTINGS[kind]("/dev/x") | change, arm())
