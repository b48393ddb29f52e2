"""Driver ur_rtde and a controller that is a process: what it refuses, what stops it, and its latency."""

import re
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from exidyn.drivers import Arm, Command, Driver, StopLevel, create
from exidyn.drivers.errors import BadSettings, LinkLost, NotReady
from exidyn.drivers.ur_rtde.program import UrSettings, program_text
from exidyn.drivers.ur_rtde.session import STATE
from exidyn.identification.recordings.align import follows_by
from exidyn.identification.recordings.recording import Signal

from ...peers.peer_process import Peer
from ...peers.ur_script import ScriptError, program, translated
from ...peers.ur_settings import ur_settings

CYCLE = 0.008
"""Of a CB3, which busy machines keep [s]."""
ARM = Arm(tuple(f"joint{k}" for k in range(1, 7)), np.full(6, -7.0), np.full(6, 7.0), np.full(6, 3.0))


@contextmanager
def controller(*arguments, series="cb3", **settings):
    """A controller, and its driver, not open yet."""
    with Peer("ur_controller.py", "--robot", "obedient", "--series", series, *arguments) as peer:
        given = ur_settings(peer.address) | {"cycle": CYCLE, "dead_man": 2.0} | settings
        with create("ur_rtde", given, ARM) as driver:
            yield peer, driver


def hold(driver):
    """Armed, and the command that holds it where it stands."""
    driver.open()
    driver.arm_drives()
    return Command(driver.held(), np.zeros(6))


def until_fault(driver, command, seconds=20.0):
    end = Driver.clock.monotonic() + seconds
    while Driver.clock.monotonic() < end:
        sample = driver.exchange(command)
        if sample.fault:
            return sample
    raise AssertionError("no fault")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--safety-mode", 3], "protective stop .safety mode 3.*enable the robot again"),
        (["--safety-mode", 7], "robot emergency stop .safety mode 7.*release"),
        (["--robot-mode", 3], "robot mode is power off .3.: switch the arm on"),
        (["--slider", 0.6], "speed slider is at 60 %.*set it to 100 %"),
        (["--local", "--series", "e"], "local control: choose Remote Control"),
        (["--protocol", 1], "version 2 of RTDE.*too old"),
        (["--unknown", "joint_mode"], "3.15.8.106339 of the controller does not have joint_mode"),
        (["--unknown", "input_double_register_29"], "have input_double_register_29. Try 3.*; or first_reg"),
        (
            ["--in-use", "input_int_register_24"],
            "another program writes input_int_register_24.*first_register = 0",
        ),
    ],
)
def test_what_is_in_the_way_is_reported_in_a_line_before_anything_is_sent(arguments, message):
    with controller(*arguments) as (peer, driver):
        with pytest.raises(NotReady, match=message) as found:
            driver.open()
        assert len(str(found.value)) < 290
        assert not peer.printed("program")


def test_a_cycle_that_the_controller_does_not_keep_is_refused():
    with controller(cycle=0.002) as (_, driver), pytest.raises(BadSettings, match="CB3.*Try cycle = 0.008"):
        driver.open()
    with (
        controller(series="e", cycle=0.003) as (_, driver),
        pytest.raises(BadSettings, match="0.002, or a mul"),
    ):
        driver.open()


def test_what_changes_between_opening_and_arming_is_seen():
    with controller() as (peer, driver):
        driver.open()
        peer.tell("slider 0.5")
        for _ in range(10):  # until it is in what the controller sends
            driver.exchange(None)
        with pytest.raises(NotReady, match="slider"):
            driver.arm_drives()
        assert not peer.printed("program")


def test_a_program_that_is_not_begun_is_reported():
    with controller("--local", wait=0.5) as (_, driver):
        driver.open()  # a CB3 cannot be asked for remote control
        with pytest.raises(NotReady, match="does not begin in 0.5 s.*Remote Control"):
            driver.arm_drives()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("protective", "protective stop .safety mode 3"),
        ("emergency", "robot emergency stop .safety mode 7"),
        ("slider 0.7", "speed slider is at 70 %"),
        ("pause", "stopped at the controller"),
        ("halt", "stopped at the controller"),
    ],
)
def test_what_stops_the_arm_is_named_and_recorded_with_the_state(line, message):
    with controller() as (peer, driver):
        command = hold(driver)
        assert driver.exchange(command).fault == ""
        peer.tell(line)
        sample = until_fault(driver, command)
        assert re.search(message, sample.fault)
        state = dict(zip(STATE, sample.state, strict=True))
        expected = {
            "protective": ("safety_mode", 3.0),
            "emergency": ("safety_mode", 7.0),
            "slider 0.7": ("speed_slider", 0.7),
            "pause": ("program", 4.0),
            "halt": ("program", 1.0),
        }[line]
        assert state[expected[0]] == expected[1]
        assert not driver.exchange(command).sent


def test_messages_of_the_controller_and_changes_of_its_modes_are_events():
    with controller() as (peer, driver):
        driver.open()
        driver.exchange(None)
        peer.tell("say joint 3 is warm")
        peer.tell("protective")
        end, events = Driver.clock.monotonic() + 10.0, []
        while Driver.clock.monotonic() < end and len(events) < 2:
            events += driver.exchange(None).events
        assert sorted(events) == ["safety mode is protective stop (3)", "the controller: joint 3 is warm"]


def test_the_program_stops_the_arm_when_no_command_comes():
    with controller(dead_man=0.2) as (peer, driver):
        command = hold(driver)
        driver.exchange(command)
        Driver.clock.sleep(1.0)
        peer.wait_for("stopping")
        assert "its program has stopped the arm" in until_fault(driver, command).fault


def test_a_quick_stop_ends_the_program_and_off_takes_the_power():
    with controller() as (peer, driver):
        command = hold(driver)
        driver.exchange(command)
        driver.stop(StopLevel.QUICK)
        peer.wait_for("stopping")
        assert driver.exchange(command).sent is False
        driver.stop(StopLevel.OFF)
        peer.wait_for("powered off")


def test_closing_ends_the_program():
    with controller() as (peer, driver):
        driver.exchange(hold(driver))
        driver.close()
        peer.wait_for("program ended: to its end")


def test_a_connection_that_is_cut_is_lost_and_the_program_stops_the_arm():
    with controller(dead_man=0.2) as (peer, driver):
        command = hold(driver)
        peer.tell("cut")
        with pytest.raises(LinkLost, match="ended the connection|Broken|reset"):
            until_fault(driver, command)
        peer.wait_for("stopping")
        peer.wait_for("program ended: to its end")


def test_what_is_no_controller_is_reported(tmp_path):
    with controller() as (peer, _):
        given = ur_settings(peer.address)
        given["rtde_port"] = given["dashboard_port"]
        with create("ur_rtde", given | {"wait": 0.5}, ARM) as driver, pytest.raises(LinkLost, match="RTDE"):
            driver.open()


def test_an_arm_of_seven_joints_is_refused():
    seven = Arm(("j",) * 7, *(np.zeros(7),) * 3)
    with pytest.raises(BadSettings, match="7 joints; expected 6"):
        create("ur_rtde", {"address": "127.0.0.1"}, seven)


def test_positions_and_currents_have_the_controllers_time_and_servojs_latency_is_between_commands_and_them():
    with controller("--latency", 0.032) as (_, driver):
        command = hold(driver)
        times, positions, commands = [], [], []
        for number in range(400):
            target = command.position + 0.1 * (1 - np.cos(2 * np.pi * number / 200))
            sample = driver.exchange(Command(target, np.zeros(6)))
            if not sample.stale.any():
                times.append(1e-9 * sample.controller_time)
                positions.append(sample.position)
                commands.append(target)
    late = follows_by(
        Signal(np.array(times), np.array(commands)), Signal(np.array(times), np.array(positions))
    )
    assert 0.0315 < late < 0.032 + 3.5 * CYCLE


def test_the_program_is_one_that_the_peer_can_run_and_nothing_else_is():
    settings = UrSettings(address="")
    text = program_text(settings, 7)
    assert "servoj(q, 0, 0, 0.002, 0.03, 300)" in text
    assert program_text(replace(settings, address='"\nhalt\n"'), 7) == text  # numbers are all that it holds
    inputs, written = [0, 1], {}
    functions = {
        "write_output_integer_register": written.__setitem__,
        "read_input_integer_register": lambda k: inputs[k - 24],
        "read_input_float_register": lambda k: float(k),
        "servoj": lambda *_: iter([("servoj", _[0])]),
        "stopj": lambda *_: iter([("stopj", _[0])]),
    }
    running = program(text, functions)
    assert next(running) == ("servoj", [24.0, 25.0, 26.0, 27.0, 28.0, 29.0])
    assert written == {25: 0, 24: 7}
    for count in range(1, 6):
        inputs[0] = count
        next(running)
    silent = 0
    while written[25] == 0:
        last = next(running)
        silent += 1
    assert (last, written[25]) == (("stopj", 10.0), 2)
    assert silent == round(settings.dead_man / settings.cycle) + 1
    for wrong in ("import os", "x = __import__('os')", "def a():\n  x = 1\n", "end"):
        with pytest.raises(ScriptError):
            translated(wrong)
