"""Driver franka and a server that is not ours: what it refuses, what stops it, who stops the arm."""

import os
import re
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np
import pytest

from exidyn.drivers import Arm, Command, StopLevel, create
from exidyn.drivers.errors import BadSettings, LinkLost, NotReady
from exidyn.drivers.franka.fci_messages import ERRORS, STATE
from exidyn.identification.recordings.align import follows_by
from exidyn.identification.recordings.recording import Signal

from ...parts.controllers.franka_controller import BUFFER, INSTALLED, running

ARM = Arm(tuple(f"joint{k}" for k in range(1, 8)), np.full(7, -2.0), np.full(7, 2.0), np.full(7, 2.0))
STILL = np.zeros(7)
pytestmark = [pytest.mark.clocked, INSTALLED]


@contextmanager
def controller(*arguments, patience=2000, **settings):
    """A controller, and its driver, not open yet."""
    with (
        running(*arguments, patience=patience) as (peer, given),
        create("franka", given | settings, ARM) as d,
    ):
        yield peer, d


def hold(driver):
    """Armed, and the command that holds it where it stands."""
    driver.open()
    driver.arm_drives()
    return Command(driver.held(), STILL)


def exchanged(driver, command):
    """The sample with which a command went out."""
    for _ in range(5000):
        sample = driver.exchange(command)
        if sample.sent or sample.fault:
            return sample
    raise AssertionError("not sent")


def until_fault(driver, command, seconds=20.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        sample = driver.exchange(command)
        if sample.fault and not sample.stale.any():
            return sample
    raise AssertionError("no fault")


def until_state(driver, command, condition, count=5000):
    """The controller's state, by name, once it is so: the reason of a stop comes by TCP, states by UDP."""
    for _ in range(count):
        sample = driver.exchange(command)
        state = dict(zip(STATE, sample.state, strict=False))
        if state and condition(state):
            return state
    raise AssertionError(f"the state stays {state}")


def moved(driver, command, count=1500, amplitude=0.1):
    """Samples of a motion there and back, with their commands."""
    found = []
    for number in range(count):
        target = command.position + 0.5 * amplitude * (1 - np.cos(2 * np.pi * number / count))
        sample = exchanged(driver, Command(target, STILL))
        assert sample.fault == ""
        found.append((sample, target))
    return found


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--mode", 5], "user stopped .5.: release the user stop"),
        (["--mode", 3], "guiding .3.: release the guiding button"),
        (["--mode", 4], "reflex .4.: .*recover"),
        (
            ["--version", 5],
            "server version: 5, library version: 10.. .*FR3.*a Panda .system 4. is not supported",
        ),
    ],
)
def test_what_is_in_the_way_is_reported_in_a_line_before_anything_moves(arguments, message):
    with controller(*arguments) as (peer, driver):
        with pytest.raises(NotReady, match=message) as found:
            driver.open()
        assert len(str(found.value)) < 290
        assert not peer.printed("motion")


def test_an_address_without_a_controller_is_reported():
    with create("franka", {"address": "127.255.255.7"}, ARM) as driver:
        with pytest.raises(LinkLost, match="refused.*activate FCI in Desk"):
            driver.open()


def test_an_arm_of_six_joints_is_refused():
    six = Arm(("j",) * 6, *(np.zeros(6),) * 3)
    with pytest.raises(BadSettings, match="6 joints; expected 7"):
        create("franka", {"address": "127.0.0.1"}, six)


def test_every_error_has_the_name_that_libfranka_gives_it():
    with controller() as (peer, driver):
        driver.open_to_read()
        driver.exchange(None)
        for number, name in enumerate(ERRORS):
            peer.tell(f"error {number}")
            end = time.monotonic() + 10.0
            while f"error is {name} ({number + 1})" not in driver.exchange(None).events:
                assert time.monotonic() < end, name


@pytest.mark.parametrize(
    ("line", "message", "mode", "error"),
    [
        ("reflex joint_reflex", "joint_reflex: a torque is beyond the collision thresh", 4, 7),
        ("reflex cartesian_reflex", "cartesian_reflex: a force at the hand", 4, 8),
        ("error 0", "joint_position_limits_violation: guide it back", 4, 1),
        ("reflex communication_constraints_violation", "20 commands in a row came too late", 4, 26),
        ("reflex joint_motion_generator_velocity_discontinuity", "commands were not smooth enough", 4, 15),
        ("user", "User Stop|user stop|safety function", 5, 0),
    ],
)
def test_what_stops_the_arm_is_named_and_recorded_with_the_state(line, message, mode, error):
    with controller() as (peer, driver):
        command = hold(driver)
        assert exchanged(driver, command).fault == ""
        peer.wait_for("motion started")
        peer.tell(line)
        sample = until_fault(driver, command)
        assert re.search(message, sample.fault)
        assert len(sample.fault) < 290
        assert "\n" not in sample.fault
        shown = until_state(driver, command, lambda state: state["robot_mode"] == mode)
        assert shown["error"] == error
        assert not driver.exchange(command).sent


def test_a_reflex_is_recovered_from_where_that_is_asked_for():
    with controller() as (peer, driver):
        peer.tell("reflex joint_reflex")
        peer.wait_for("aborted")
        with pytest.raises(NotReady, match="joint_reflex"):
            driver.open()
    with controller(recover=True) as (peer, driver):
        peer.tell("reflex joint_reflex")
        peer.wait_for("aborted")
        driver.open()


def test_torques_and_motors_are_recorded_as_the_controller_gives_them():
    with controller() as (_, driver):
        info = driver.open()
        sample = driver.exchange(None)
    state = dict(zip(info.state, sample.state, strict=True))
    joints = np.arange(1, 8)
    np.testing.assert_allclose(sample.torque, 0.1 * joints, rtol=1e-6)
    np.testing.assert_allclose([state[f"tau_J_d{k}"] for k in joints], 0.05 * joints, rtol=1e-6)
    motor = sample.position + 0.1 * joints / 7000.0
    np.testing.assert_allclose([state[f"theta{k}"] for k in joints], motor, atol=3e-7)
    assert np.all(np.isnan(sample.current))


def test_every_command_reaches_the_arm_once_and_later_by_what_is_held_back():
    with controller() as (peer, driver):
        found = moved(driver, hold(driver))
        fresh = [(sample, target) for sample, target in found if not sample.stale.any()]
        time_ = np.array([1e-9 * sample.controller_time for sample, _ in fresh])
        late = follows_by(
            Signal(time_, np.array([target for _, target in fresh])),
            Signal(time_, np.array([sample.position for sample, _ in fresh])),
        )
        assert not peer.printed("aborted")
    # a machine with other work makes it later, and twice the buffer would be a buffer too many
    assert BUFFER - 0.005 < late < 2.0 * BUFFER


def test_a_motion_beyond_the_limits_is_stopped_before_the_controller_sees_it():
    with controller("--strict") as (peer, driver):
        command = hold(driver)
        for number in range(300):
            exchanged(driver, Command(command.position + 0.5e-6 * number**2, STILL))
        for _ in range(2):
            exchanged(driver, Command(command.position + 0.5, STILL))
        sample = until_fault(driver, command)
        assert re.search(
            "joint 1: commanded velocity is .* rad/s, limit of the controller 2.62", sample.fault
        )
        peer.wait_for("motion ended")
        assert not peer.printed("aborted")


def test_without_commands_the_process_stops_the_arm():
    with controller("--strict") as (peer, driver):
        moved(driver, hold(driver), count=300, amplitude=0.02)
        time.sleep(BUFFER + 1.0)
        peer.wait_for("motion ended")
        assert "no command for 200 ms: the arm was stopped" in until_fault(driver, None).fault
        assert not peer.printed("aborted")


def test_a_quick_stop_brakes_within_the_limits_and_off_ends_the_motion_at_once():
    with controller("--strict") as (peer, driver):
        command = hold(driver)
        for number in range(500):
            exchanged(driver, Command(command.position + 0.5e-6 * number**2, STILL))
        driver.stop(StopLevel.QUICK)
        assert driver.exchange(command).sent is False
        peer.wait_for("motion ended")
        assert not peer.printed("aborted")
    with controller() as (peer, driver):
        exchanged(driver, hold(driver))
        peer.wait_for("motion started")
        driver.stop(StopLevel.OFF)
        peer.wait_for("motion stopped")


def test_closing_ends_the_motion():
    with controller() as (peer, driver):
        exchanged(driver, hold(driver))
        peer.wait_for("motion started")
        driver.close()
        peer.wait_for("motion ended")
        assert not peer.printed("aborted")


PROGRAM = """
import os, sys, numpy as np
from exidyn.drivers import Arm, Command, create
arm = Arm(tuple("abcdefg"), np.full(7, -2.0), np.full(7, 2.0), np.full(7, 2.0))
driver = create("franka", {"address": sys.argv[1], "buffer": 0.2}, arm)
driver.open(); driver.arm_drives()
for number in range(600):
    while not driver.exchange(Command(driver.held() + 0.5e-6 * number**2, np.zeros(7))).sent: pass
os._exit(9)
"""


def test_when_the_drivers_program_dies_its_process_stops_the_arm_within_the_limits():
    with running("--strict") as (peer, given):
        path = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        done = subprocess.run([sys.executable, "-c", PROGRAM, given["address"]], env=path, check=False)
        assert done.returncode == 9
        peer.wait_for("motion ended")
        assert not peer.printed("aborted")


def test_when_the_process_dies_the_controller_stops_the_arm():
    with controller(patience=200) as (peer, driver):
        command = hold(driver)
        exchanged(driver, command)
        peer.wait_for("motion started")
        driver._link._process.kill()
        with pytest.raises(LinkLost, match="process that talks to .* has ended"):
            until_fault(driver, command)
        peer.wait_for("connection lost while moving")


def test_a_controller_that_falls_silent_is_lost():
    with controller() as (peer, driver):
        command = hold(driver)
        exchanged(driver, command)
        peer.tell("hold 3")
        with pytest.raises(LinkLost, match="UDP receive|nothing from"):
            until_fault(driver, command)


def test_an_unchanged_franky_sim_is_moved(tmp_path):
    """Its arm is MuJoCo's, with a controller of franky-sim's own."""
    where = "127.71.3.9"
    command = [sys.executable, "-m", "franky_sim.run_server", "--simulator", "mujoco", "--hostname", where]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            driver, end = create("franka", {"address": where, "buffer": BUFFER}, ARM), time.monotonic() + 60.0
            while time.monotonic() < end:
                try:
                    driver.open()
                    break
                except LinkLost:
                    time.sleep(0.5)
            with driver:
                driver.arm_drives()
                begin = driver.held()
                found = moved(driver, Command(begin, STILL), amplitude=0.05)
                far = np.nanmax([sample.position for sample, _ in found], axis=0) - begin
            assert np.all(far > 0.03)
        finally:
            process.kill()
