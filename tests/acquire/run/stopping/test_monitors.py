from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.acquire.run.stopping.monitors import Lateness, Outside, Silence, Speed, Tracking
from exidyn.drivers import Command
from exidyn.identify.arm.robot import SLIDING

JOINTS = ("one", "two")


def seen(position=(0.0, 0.0), **other):
    fields = {"position": np.array(position), "controller_time": 0, "skipped": 0, "stale": np.zeros(2, bool)}
    fields["sent"] = True
    return SimpleNamespace(**(fields | other))


def sent(position):
    return Command(np.full(2, position), np.zeros(2))


def sliding(joint, unit):
    """The first joint turns, the second slides."""
    return SLIDING[unit] if joint else unit


def first_stop(monitor, samples):
    for number, (sample, command) in enumerate(samples):
        found = monitor.look(sample, command)
        if found is not None:
            return number, found
    return None


def test_a_delay_of_the_drive_is_no_tracking_error():
    ramp = np.arange(200) * 0.01
    samples = [(seen((ramp[max(k - 10, 0)],) * 2), sent(ramp[k])) for k in range(200)]
    assert first_stop(Tracking(JOINTS, np.full(2, 0.005), 5, 20), samples) is None


def test_an_arm_that_stays_behind_is_one_after_as_many_cycles_as_are_allowed():
    samples = [(seen((0.0, k * 0.01)), sent(k * 0.01)) for k in range(100)]
    number, stop = first_stop(Tracking(JOINTS, np.full(2, 0.1), 5, 10), samples)
    assert stop.joint == "one"
    assert number == 10 + 9 + 5  # limit reached, memory over, five in a row


def test_a_joint_that_is_silent_now_and_then_is_borne():
    one = np.array([True, False])
    samples = [(seen(stale=one if k % 3 else np.zeros(2, bool)), None) for k in range(99)]
    assert first_stop(Silence(JOINTS, 3), samples) is None
    number, stop = first_stop(Silence(JOINTS, 3), [(seen(stale=one), None)] * 5)
    assert number == 2
    assert stop.joint == "one"


def test_a_coarse_encoder_is_no_speed():
    step = 0.01
    position = np.round(np.arange(300) * 0.001 / step) * step
    samples = [(seen((p, p), controller_time=k * 2_000_000), sent(0.0)) for k, p in enumerate(position)]
    assert first_stop(Speed(JOINTS, np.full(2, 1.1), 10, 0.002), samples) is None
    assert first_stop(Speed(JOINTS, np.full(2, 0.4), 10, 0.002), samples) is not None


def test_lost_cycles_do_not_make_a_speed():
    samples = [(seen((k * 0.01,) * 2, controller_time=k * 10_000_000), sent(0.0)) for k in range(100)]
    assert first_stop(Speed(JOINTS, np.full(2, 1.2), 10, 0.002), samples) is None


def test_an_arm_that_began_outside_may_come_back_in():
    monitor = Outside(JOINTS, np.full(2, -1.0), np.full(2, 1.0), np.full(2, 0.01), 1)
    monitor.look(seen((1.5, 0.0)), None)
    assert monitor.look(seen((1.2, 0.0)), sent(0.0)) is None
    assert monitor.look(seen((1.2, -1.1)), sent(0.0)).joint == "two"


def test_missed_cycles_are_counted_over_one_second():
    few = [(seen(skipped=int(k % 40 == 0)), sent(0.0)) for k in range(2000)]
    many = [(seen(skipped=int(k % 10 == 0)), sent(0.0)) for k in range(2000)]
    assert first_stop(Lateness(0.002, 0.05, 0.05), few) is None
    assert first_stop(Lateness(0.002, 0.05, 0.05), many)[1].kind == "lateness"


def test_a_position_that_is_not_a_number_is_a_silent_joint():
    samples = [(seen((0.0, np.nan)), sent(0.0))] * 5
    assert first_stop(Silence(JOINTS, 3), samples)[1].joint == "two"


def test_a_cycle_in_which_the_controller_did_not_ask_is_a_missed_one():
    silent = seen((np.nan, np.nan), sent=False), None
    samples = [silent if k % 10 == 0 else (seen(), sent(0.0)) for k in range(2000)]
    assert first_stop(Lateness(0.004, 0.05, 0.05), samples)[1].kind == "lateness"
    listening = [(seen(skipped=1), None)] * 1000
    assert first_stop(Lateness(0.004, 0.05, 0.05), listening) is None


def test_a_cycle_without_a_command_does_not_make_a_tracking_error_begin_anew():
    away = [(seen(), sent(1.0))] * 4 + [(seen((np.nan, np.nan), sent=False), None)]
    assert first_stop(Tracking(JOINTS, np.full(2, 0.1), 6, 1), away * 3)[0] == 6


@pytest.mark.parametrize(("place", "unit"), [(0, "rad"), (1, "m")])
def test_a_stop_is_in_the_units_of_its_joint(place, unit):
    position = np.zeros(2)
    position[place] = 0.5
    bounds = np.full(2, 0.1)
    tracking = Tracking(JOINTS, bounds, 1, 1, sliding)
    outside = Outside(JOINTS, -bounds, bounds, np.zeros(2), 1, sliding)
    for monitor in (tracking, outside):
        _, stop = first_stop(monitor, [(seen(position), sent(0.0))])
        assert stop.unit == unit
        assert f" {unit}, limit" in stop.text
