from dataclasses import replace

import numpy as np
import pytest

from exidyn.drivers import Command, Driver, StopLevel, create
from exidyn.drivers.errors import BadSettings, NotReady
from exidyn.drivers.host_clock import HOST
from exidyn.drivers.mock.driver import EPOCH, SteppedClock
from exidyn.identification.fit.estimators.least_squares import given_nominal
from exidyn.identification.fit.identification import identify
from exidyn.identification.recordings.recording import Recording, Signal
from exidyn.identification.simulation.plant import Plant
from exidyn.identification.simulation.plant.typical import typical_parts

from ...parts.controllers.mock_parts import CYCLE, STEPPED, arm, moving, opened, play
from ...parts.small.two_joints import GAIN, model, trajectory, true_values
from ...peers.arm import make_plant


def test_it_reports_what_it_is():
    driver, info = opened(cycle=0.004, silent="current, temperature")
    assert driver.simulated
    assert not driver.in_real_time
    assert (info.cycle, info.clock, info.signals) == (0.004, "host", ("position", "velocity"))
    assert info.window_lower is None
    assert "0.2 s" in info.dead_man
    assert not info.warnings
    sample = driver.exchange(None)
    assert np.isnan(sample.current).all()
    assert np.isnan(sample.torque).all()
    assert np.isfinite(sample.position).all()
    driver.close()
    driver.close()


@pytest.mark.parametrize("cycle", [0.002, 0.004, 0.012])
def test_its_clock_goes_on_by_a_cycle_an_exchange(cycle):
    driver, _ = opened(cycle=cycle)
    samples = play(driver, [None] * 20)
    step = round(cycle * 1e9)
    assert [sample.controller_time for sample in samples] == [k * step for k in range(20)]
    assert [sample.host_time for sample in samples] == [EPOCH + k * step for k in range(20)]
    assert all(sample.lateness == 0.0 and sample.skipped == 0 and not sample.fault for sample in samples)


def test_the_same_settings_are_the_same_samples_bit_for_bit():
    one, again = (play(opened()[0], moving(100)) for _ in range(2))
    for a, b in zip(one, again, strict=True):
        np.testing.assert_array_equal(a.position, b.position)
        np.testing.assert_array_equal(a.current, b.current)


def test_a_command_is_reached_one_cycle_later():
    commands = moving()
    samples = play(opened()[0], commands)
    position = np.array([sample.position for sample in samples])
    wanted = np.array([command.position for command in commands])
    behind = np.abs(position[1:] - wanted[:-1]).max()
    assert behind < 2e-3  # what the drive lags
    np.testing.assert_allclose(position[300:] - position[299:-1], 0.2 * CYCLE, atol=1e-4)


def test_without_commands_the_arm_stays():
    driver, _ = opened()
    start = driver.exchange(None).position
    samples = play(driver, [None] * 100)
    assert max(np.abs(sample.position - start).max() for sample in samples) < 1e-4
    play(driver, moving(200))
    there = driver.exchange(None).position
    later = play(driver, [None] * 200)[-1].position
    assert np.abs(later - there).max() < 0.02  # it brakes from 0.2 rad/s, and holds


def test_a_quick_stop_brakes_by_itself_and_takes_no_more_commands():
    driver, _ = opened(deceleration=4.0)
    commands = moving()
    samples = play(driver, commands[:300])
    driver.stop(StopLevel.QUICK)
    after = play(driver, commands[300:])
    way = after[-1].position - samples[-1].position
    np.testing.assert_allclose(way, 0.2**2 / (2 * 4.0), atol=2e-3)
    assert np.abs(after[-1].velocity).max() < 0.01
    assert not after[-1].fault
    driver.stop(StopLevel.BRAKE)  # has nothing to do


def test_torque_off_lets_the_arm_drop():
    driver, _ = opened()
    start = driver.exchange(None).position
    driver.stop(StopLevel.OFF)
    samples = play(driver, [None] * 300)
    assert np.abs(samples[-1].position - start).max() > 0.2
    assert max(np.abs(sample.current).max() for sample in samples[2:]) < 0.5


def test_the_dead_man_stops_drives_that_nobody_commands():
    driver, _ = opened(dead_man=0.05, faults="stall 0.2 at 0.5")
    samples = play(driver, moving(400))
    stalled = next(k for k, sample in enumerate(samples) if sample.lateness > 0.1)
    assert samples[stalled + 1].skipped == 100 - 1
    assert "no command for 0.05 s" in samples[stalled + 1].fault
    assert samples[-1].fault == samples[stalled + 1].fault
    assert np.abs(samples[-1].position - samples[stalled + 1].position).max() < 5e-3
    assert np.abs(samples[-1].velocity).max() < 0.01


def test_a_short_stall_is_no_fault_and_nothing_is_caught_up():
    driver, _ = opened(faults="stall 0.02 at 0.5")
    commands = moving(400)
    samples = play(driver, commands)
    assert sum(sample.skipped for sample in samples) == 9
    assert not samples[-1].fault
    times = np.diff([sample.controller_time for sample in samples])
    assert sorted(set(times)) == [2_000_000, 20_000_000]
    assert np.abs(samples[-1].position - commands[-2].position).max() < 5e-3


def test_beyond_the_window_the_controller_stops():
    driver, info = opened(window=[0.05, 0.5])
    np.testing.assert_array_equal(info.window_upper, [0.05, 0.5])
    np.testing.assert_array_equal(info.window_lower, [-0.05, -0.5])
    samples = play(driver, moving(500))
    assert "shoulder: commanded 0.0" in samples[-1].fault
    assert abs(samples[-1].position[0] - samples[0].position[0]) < 0.07


@pytest.mark.clocked
def test_in_real_time_it_keeps_to_the_clock(monkeypatch):
    monkeypatch.setattr(Driver, "clock", HOST)
    driver = create("mock", {"cycle": 0.01, "clock": "real"}, arm())
    with driver:
        assert driver.in_real_time
        driver.open()
        begin = HOST.monotonic()
        samples = [driver.exchange(command) for command in moving(20, cycle=0.01)]
        gone = HOST.monotonic() - begin
    assert gone > 0.19
    host = np.diff([sample.host_time for sample in samples])
    assert np.all(host > 0)
    controller = np.diff([sample.controller_time for sample in samples])
    skipped = np.array([sample.skipped for sample in samples[1:]])
    np.testing.assert_array_equal(controller, 10_000_000 * (1 + skipped))
    assert all(sample.lateness >= 0.0 for sample in samples)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"cycle": 0.0}, "0.0005 to 0.1"),
        ({"clock": "sundial"}, "Valid: stepped, real"),
        ({"silent": "position"}, "Valid: velocity, current, temperature"),
        ({"faults": "flood at 2"}, "no fault is called 'flood at 2'. Valid: drop, duplicate"),
        ({"faults": "stale joint9"}, r"'joint9' in fault 'stale joint9' is neither .*\(shoulder, elbow\)"),
        ({"faults": "drop at 1.2.3"}, "'1.2.3' in fault"),
    ],
)
def test_settings_that_cannot_be_are_refused(settings, message):
    with pytest.raises(BadSettings, match=message):
        create("mock", settings, arm())


def test_it_needs_an_arm_and_to_be_open():
    driver = create("mock", STEPPED, arm(None))
    with pytest.raises(NotReady, match="not open"):
        driver.exchange(None)
    with pytest.raises(BadSettings, match="no arm to simulate"):
        driver.open()
    driver.stop(StopLevel.QUICK)
    driver.stop(StopLevel.OFF)
    driver.close()


def test_a_stepped_clock_skips_what_has_gone_by():
    clock = SteppedClock(0.002)
    assert [clock.wait().number for _ in range(3)] == [0, 1, 2]
    clock.sleep(0.0071)
    tick = clock.wait()
    assert (tick.number, tick.skipped) == (5, 2)
    assert tick.lateness == pytest.approx(0.0011)
    assert clock.wait().skipped == 0


def fitted(quiet):
    """A fit of a recording of the mock, and its errors."""
    cycle, seconds = 0.004, 12.0
    motion = trajectory(seconds).at(cycle * np.arange(1, round(seconds / cycle) + 1))
    control, sensors, _ = typical_parts(model())
    if quiet:
        sensors = replace(sensors, current_noise=np.zeros(2), current_drift=np.zeros(2))
    start = motion.position[0]
    driver = create(
        "mock",
        STEPPED | {"cycle": cycle},
        arm(lambda: Plant(model(), true_values(model()), GAIN, start, control, sensors, seed=1)),
    )
    driver.open()
    samples = play(driver, [Command(*row) for row in zip(motion.position, motion.velocity, strict=True)])
    time = 1e-9 * np.array([sample.controller_time for sample in samples])
    signals = {
        name: Signal(time, np.array([getattr(sample, name) for sample in samples]))
        for name in ("position", "velocity", "current")
    }
    fit = identify([Recording("mock", model(), signals)], drop=False)
    return fit, fit.estimate.values - fit.base.regrouping @ true_values(fit.model)


def test_parameters_are_found_again_in_a_recording_of_it():
    noisy, error = fitted(quiet=False)
    deviation = noisy.estimate.std
    assert np.abs(error / deviation).max() < 4.0
    assert np.sqrt(np.mean((error / deviation) ** 2)) < 1.6
    deviation = np.sqrt(np.diag(given_nominal(noisy.estimate)))  # of noise, with the gains as stated
    assert np.median(deviation / np.maximum(np.abs(noisy.estimate.values), 0.1)) < 0.03
    # What the drives, the sampling and the encoder leave without current noise is small beside it.
    exact, bias = fitted(quiet=True)
    assert exact.names == noisy.names
    assert np.abs(bias / deviation).max() < 0.3


def test_peers_get_an_arm_in_the_middle_of_its_range():
    plant = make_plant()
    assert len(plant.joints) == 6
    np.testing.assert_allclose(plant.measure().position, [0, -np.pi / 2, 0, 0, 0, 0], atol=1e-4)
    elsewhere = make_plant("kr270", start=np.full(6, -0.3), seed=2)
    np.testing.assert_allclose(elsewhere.measure().position, -0.3, atol=1e-4)


def test_before_the_first_command_nobody_is_missed(clock):
    """A program that only reads, or that asks a person first, may take its time."""
    driver, _ = opened(clock="real", dead_man=0.002)
    for _ in range(3):
        clock.sleep(0.02)
        assert not driver.exchange(None).fault
    driver.exchange(moving(1)[0])
    clock.sleep(0.02)
    assert "no command for 0.002 s" in driver.exchange(None).fault
