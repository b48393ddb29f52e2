from types import SimpleNamespace

import numpy as np
import pytest

from exidyn.acquire.run.stopping.history import History
from exidyn.acquire.run.stopping.monitors import (
    ControllerClock,
    JointMonitor,
    JointRule,
    Lateness,
    Outside,
    Silence,
    Stale,
    mean_speed,
)
from exidyn.drivers import Command, StopLevel
from exidyn.identification.arm.robot import SLIDING

JOINTS = ("one", "two")


def seen(position=(0.0, 0.0), **other):
    fields = {"position": np.array(position), "host_time": 0, "controller_time": 0, "skipped": 0}
    fields |= {"stale": np.zeros(2, bool), "sent": True}
    return SimpleNamespace(**(fields | other))


def sent(position):
    return Command(np.full(2, position), np.zeros(2))


TURNING = SimpleNamespace(joints=JOINTS, dof=2, unit=lambda joint, unit: unit)
SECOND_SLIDES = SimpleNamespace(
    joints=JOINTS, dof=2, unit=lambda joint, unit: SLIDING[unit] if joint else unit
)


def joint_monitor(signal, limit, cycles, robot=TURNING, cycle=0.002, **other):
    rule = JointRule("quantity", signal, np.full(2, limit), cycles * cycle, "rad", **other)
    return JointMonitor(rule, robot, cycle)


def tracking(limit, cycles, robot=TURNING):
    return joint_monitor(lambda history: history.tracking_error, limit, cycles, robot)


def speed(limit):
    return joint_monitor(lambda history: mean_speed(history, 10, 0.002), limit, 10)


def first_stop(monitor, samples, memory=1):
    history = History(2, 0.002, memory)
    for number, (sample, command) in enumerate(samples):
        history.add(sample, command)
        found = monitor.look(history)
        if found is not None:
            return number, found
    return None


def test_a_delay_of_the_drive_is_no_tracking_error():
    ramp = np.arange(200) * 0.01
    samples = [(seen((ramp[max(k - 10, 0)],) * 2), sent(ramp[k])) for k in range(200)]
    assert first_stop(tracking(0.005, 5), samples, 20) is None


def test_an_arm_that_stays_behind_is_one_after_as_many_cycles_as_are_allowed():
    samples = [(seen((0.0, k * 0.01)), sent(k * 0.01)) for k in range(100)]
    number, stop = first_stop(tracking(0.1, 5), samples, 10)
    assert stop.joint == "one"
    assert number == 10 + 9 + 5  # limit reached, memory over, five in a row


def test_one_sample_handed_out_again_does_not_hide_that_the_arm_stays_behind():
    still = seen((0.0, 0.0))
    number, stop = first_stop(tracking(0.1, 5), [(still, sent(k * 0.01)) for k in range(100)], 10)
    assert number == 10 + 9 + 5
    assert stop.kind == "quantity"


def test_rules_that_add_the_same_cycle_count_it_once():
    history = History(2, 0.002, 1)
    pair = seen((0.3, 0.1)), sent(0.0)
    for _ in range(3):
        history.add(*pair)
    assert history.before(0) is not None
    assert history.before(1) is None


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
    samples = [(seen((p, p), host_time=k * 2_000_000), sent(0.0)) for k, p in enumerate(position)]
    assert first_stop(speed(1.1), samples) is None
    assert first_stop(speed(0.4), samples) is not None


def test_lost_cycles_do_not_make_a_speed():
    samples = [(seen((k * 0.01,) * 2, host_time=k * 10_000_000), sent(0.0)) for k in range(100)]
    assert first_stop(speed(1.2), samples) is None


def test_an_arm_that_began_outside_may_come_back_in():
    limits = SimpleNamespace(position_lower=np.full(2, -1.0), position_upper=np.full(2, 1.0))
    samples = [(seen((1.5, 0.0)), None), (seen((1.2, 0.0)), sent(0.0)), (seen((1.2, -1.1)), sent(0.0))]
    number, stop = first_stop(joint_monitor(Outside(limits).distance, 0.01, 1), samples)
    assert (number, stop.joint) == (2, "two")


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
    away = [
        (seen(), sent(1.0)) if k % 5 < 4 else (seen((np.nan, np.nan), sent=False), None) for k in range(15)
    ]
    assert first_stop(tracking(0.1, 6), away)[0] == 6


@pytest.mark.parametrize(("place", "unit"), [(0, "rad"), (1, "m")])
def test_a_stop_is_in_the_units_of_its_joint(place, unit):
    position = np.zeros(2)
    position[place] = 0.5
    _, stop = first_stop(tracking(0.1, 1, SECOND_SLIDES), [(seen(position), sent(0.0))])
    assert stop.unit == unit
    assert f" {unit}, limit" in stop.text


def clocks(rate, cycle=0.008, late=(), seconds=5.0):
    """Samples of a controller whose clock goes at a rate; now and then one is late [s]."""
    for k in range(round(seconds / cycle)):
        delay = late[k % len(late)] if late else 0.0
        yield (
            seen(host_time=round(1e9 * (k * cycle + delay)), controller_time=round(1e9 * rate * k * cycle)),
            None,
        )


@pytest.mark.parametrize("cycle", [0.001, 0.002, 0.008, 0.012])
@pytest.mark.parametrize("rate", [0.0, -1.0, 0.3])
def test_a_controllers_clock_that_does_not_go_on_is_a_quick_stop(rate, cycle):
    number, stop = first_stop(ControllerClock(cycle, 0.05), clocks(rate, cycle))
    assert (stop.kind, stop.level.name) == ("controller clock", "QUICK")
    assert number * cycle < 0.2


@pytest.mark.parametrize("cycle", [0.001, 0.002, 0.008, 0.012])
def test_samples_that_are_late_are_no_fault_of_the_clock(cycle):
    late = [0.05, *[0.0] * 10, 0.02, *[0.0] * 5]
    for rate in (0.9999, 1.0001):
        assert first_stop(ControllerClock(cycle, 0.05), clocks(rate, cycle, late)) is None


def test_cycles_in_which_nothing_came_say_nothing_of_the_clock():
    silent = [(seen(stale=np.ones(2, bool), host_time=k * 8_000_000), None) for k in range(200)]
    assert first_stop(ControllerClock(0.008, 0.05), silent) is None


def hot(number, celsius, cycle=0.002):
    return seen(temperature=np.array([celsius, 25.0]), host_time=round(1e9 * number * cycle)), None


def temperature_monitor():
    return joint_monitor(lambda history: history.sample.temperature, 85.0, 500, gaps=True)


@pytest.mark.parametrize("every", [1, 10, 100])
def test_a_motor_that_is_too_hot_stops_the_run_after_a_second_however_seldom_it_is_read(every):
    samples = [hot(k, 99.0 if k % every == 0 else np.nan) for k in range(2000)]
    number, stop = first_stop(temperature_monitor(), samples)
    assert 498 <= number <= 500
    assert stop.joint == "one"
    assert (stop.value, stop.limit) == (99.0, 85.0)


def test_one_wrong_reading_of_a_temperature_stops_nothing():
    samples = [hot(k, (99.0 if k == 300 else 60.0) if k % 100 == 0 else np.nan) for k in range(2000)]
    assert first_stop(temperature_monitor(), samples) is None


def test_joints_that_are_silent_too_often_stop_the_run_though_never_for_long():
    one = np.array([True, False])
    samples = [(seen(stale=one if k % 5 == 0 else np.zeros(2, bool)), None) for k in range(1000)]
    number, stop = first_stop(Stale(0.002, 0.1, 5), samples)
    assert number == 5 * 50  # the fifty-first of five hundred is beyond a tenth
    assert stop.level is StopLevel.BRAKE
    assert first_stop(Stale(0.002, 0.25, 5), samples) is None


@pytest.mark.parametrize(("skipped", "level"), [(30, StopLevel.BRAKE), (200, StopLevel.QUICK)])
def test_after_a_long_stall_the_arm_rests_and_is_not_braked_by_commands(skipped, level):
    samples = [(seen(), sent(0.0)), (seen(skipped=skipped), sent(0.0))]
    number, stop = first_stop(Lateness(0.002, 0.05, 0.05), samples)
    assert (number, stop.level) == (1, level)
