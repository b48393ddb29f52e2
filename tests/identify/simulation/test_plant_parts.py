"""Gears that give way, drives that warm up, sensors that count and hiss."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import ViscousFriction
from exidyn.identification.errors import RobotError
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.plant import Plant, Sensors, Thermal, Transmission
from exidyn.identification.simulation.plant.sensors import Readings
from exidyn.identification.simulation.plant.typical import typical_parts

from ...parts.runs.simulated import GRAVITY, LEVER, MASS, ROTOR, pendulum, pendulum_values, stiff

pytestmark = pytest.mark.slow

TICK = 0.002
LINK = MASS * LEVER**2
STIFFNESS = 2000.0


def elastic(damping=0.0, backlash=0.0):
    return Transmission(np.array([STIFFNESS]), np.array([damping]), np.array([backlash]))


def on_a_gear(gear, stiffness=None):
    """A pendulum that swings in the plane, its motor behind a gear."""
    drive = stiff(1) if stiffness is None else stiff(1, stiffness)
    return Plant(pendulum(axis="z"), pendulum_values(axis="z"), np.ones(1), np.zeros(1), drive, None, gear)


def commanded(plant, positions, tick=TICK):
    """Positions of motor and link after each command, each (t,)."""
    motor, link = [], []
    for position in positions:
        plant.step(np.array([position]), np.zeros(1), tick)
        motor.append(plant.truth().position[0, 0])
        link.append(plant.measure().link_position[0])
    return np.array(motor), np.array(link)


def frequency(wave, tick=TICK):
    """Of a sine, by its first and last upward crossing of the mean [Hz]."""
    wave = wave - wave.mean()
    up = np.flatnonzero((wave[1:] >= 0) & (wave[:-1] < 0))
    times = tick * (up + wave[up] / (wave[up] - wave[up + 1]))
    return (len(up) - 1) / (times[-1] - times[0])


def test_an_elastic_joint_rings_against_its_rotor_or_alone():
    plant = on_a_gear(elastic())
    commanded(plant, 0.02 * np.linspace(0, 1, 20) ** 2)
    plant.release()
    motor, link = commanded(plant, np.zeros(1000))
    expected = np.sqrt(STIFFNESS * (1 / LINK + 1 / ROTOR)) / (2 * np.pi)
    assert np.ptp(motor - link) > 1e-3
    assert frequency(motor - link) == pytest.approx(expected, rel=5e-3)
    momentum = LINK * link + ROTOR * motor
    drift = np.diff(momentum) / TICK
    np.testing.assert_allclose(drift, drift[0], atol=1e-9)
    plant = on_a_gear(elastic(), 1e3)
    commanded(plant, 0.02 * np.linspace(0, 1, 20) ** 2)
    _, link = commanded(plant, np.full(1000, 0.02))
    assert frequency(link) == pytest.approx(np.sqrt(STIFFNESS / LINK) / (2 * np.pi), rel=5e-3)
    ringing = []
    for damping in (0.0, 5.0):
        plant = on_a_gear(elastic(damping), 1e3)
        commanded(plant, 0.02 * np.linspace(0, 1, 20) ** 2)
        ringing.append(np.ptp(commanded(plant, np.full(500, 0.02))[1][-100:]))
    # a damper d on a link J: amplitudes fall by exp(-d t / 2 J)
    assert ringing[1] / ringing[0] == pytest.approx(np.exp(-5.0 * 0.9 / (2 * LINK)), rel=0.2)


def test_a_gear_bends_under_the_weight_it_bears_and_nothing_jumps():
    plant = Plant(pendulum(), pendulum_values(), np.ones(1), np.array([1.0]), stiff(1), None, elastic())
    measured = plant.measure()
    weight = MASS * GRAVITY * LEVER * np.sin(measured.link_position[0])
    assert measured.position[0] == pytest.approx(1.0)
    assert 1.0 - measured.link_position[0] == pytest.approx(weight / STIFFNESS, rel=1e-6)
    assert measured.current[0] == pytest.approx(weight, rel=1e-6)
    motor, link = commanded(plant, np.ones(200))
    np.testing.assert_allclose(motor, 1.0, atol=1e-7)
    np.testing.assert_allclose(link, measured.link_position[0], atol=1e-6)


def test_only_the_elastic_joints_get_a_motor_of_their_own():
    model = read_model("cobot")
    stiffness = np.array([np.inf, 2e4, np.inf, np.inf, 3e3, np.inf])
    parts = Transmission(stiffness, np.zeros(6), np.zeros(6))
    start = np.array([0.2, -1.0, 0.9, 0.3, 0.6, 0.1])
    control = replace(stiff(6, 5.0), velocity_gain=np.full(6, 300.0))
    plant = Plant(model, model.nominal_values, model.robot.drive_gain, start, control, None, parts)
    measured = plant.measure()
    bent = measured.position - measured.link_position
    np.testing.assert_allclose(bent[[0, 2, 3, 5]], 0.0, atol=1e-12)
    torque = model.robot.drive_gain * measured.current
    np.testing.assert_allclose(bent[[1, 4]], (torque / stiffness)[[1, 4]], rtol=1e-9)


def test_a_motor_turns_in_its_backlash_without_its_link():
    width = 0.01
    plant = on_a_gear(elastic(20.0, width), 10.0)
    motor, link = commanded(plant, np.linspace(0, 0.4 * width, 200))
    assert motor[-1] > 0.3 * width
    np.testing.assert_allclose(link, 0.0, atol=1e-12)
    motor, link = commanded(plant, np.full(300, 3 * width))
    assert link[-1] > 2 * width


def test_backlash_changes_sides_with_the_weight():
    width = 0.01
    for side in (1.0, -1.0):
        plant = Plant(
            pendulum(), pendulum_values(), np.ones(1), np.array([side]), stiff(1), None, elastic(0.0, width)
        )
        link = plant.measure().link_position[0]
        weight = MASS * GRAVITY * LEVER * np.sin(link)
        assert side - link == pytest.approx(weight / STIFFNESS + side * width / 2, rel=1e-6)


@pytest.mark.parametrize(
    ("stiffness", "backlash", "message"),
    [(0.0, 0.0, "without drive"), (-1.0, 0.0, "none below 0"), (np.inf, 0.1, "needs a finite stiffness")],
)
def test_gears_that_are_none_are_refused(stiffness, backlash, message):
    with pytest.raises(RobotError, match=message):
        Transmission(np.array([stiffness]), np.zeros(1), np.array([backlash]))


def test_windings_and_friction_warm_a_joint():
    thermal = Thermal(20.0, np.array([0.5]), np.array([0.2]), time_constant=0.3)
    plant = Plant(pendulum(), pendulum_values(), np.array([2.0]), np.array([1.0]), stiff(1), thermal=thermal)
    current = plant.measure().current[0]
    rise = 0.5 * 0.2 * current**2
    for _ in range(150):
        plant.step(np.ones(1), np.zeros(1), TICK)
    assert plant.measure().temperature[0] == pytest.approx(20.0 + rise * (1 - np.exp(-1.0)), rel=1e-9)
    for _ in range(50):
        plant.step(np.ones(1), np.zeros(1), 0.1)
    assert plant.measure().temperature[0] == pytest.approx(20.0 + rise, rel=1e-6)
    thermal = Thermal(20.0, np.array([0.5]), np.zeros(1), time_constant=0.05)
    model = pendulum(ViscousFriction(), axis="z")
    plant = Plant(
        model, pendulum_values(7.0, axis="z"), np.ones(1), np.zeros(1), stiff(1, 10.0), thermal=thermal
    )
    for tick in range(1, 500):
        plant.step(np.array([0.8 * tick * TICK]), np.array([0.8]), TICK)
    speed = plant.truth().velocity[0, 0]
    assert plant.measure().temperature[0] == pytest.approx(20.0 + 0.5 * 7.0 * speed**2, rel=1e-2)
    assert speed == pytest.approx(0.8, rel=1e-2)


@pytest.mark.parametrize("robot", ["cobot", "kr270"])
def test_typical_arms_warm_up_by_twenty_kelvin_in_half_an_hours(robot):
    model = read_model(robot)
    control, _, thermal = typical_parts(model)
    current, speed = control.current_limit / 3, model.robot.limits.velocity / 3
    true = dict(zip(model.names, model.nominal_values, strict=True))
    friction = np.array([true[f"Fv{j + 1}"] * v**2 + true[f"Fc{j + 1}"] * v for j, v in enumerate(speed)])
    warm = np.full(model.robot.dof, 25.0)
    assert thermal.after(warm, current, friction, 1e6) == pytest.approx(45.0, abs=1.0)
    assert np.all(thermal.after(warm, current, friction, 60.0) < 26.0)


def readings(**parts):
    """Ten thousand readings of a still joint with one ampere: position, velocity, current."""
    none = np.zeros(1)
    given = dict.fromkeys(
        ("encoder_step", "encoder_noise", "current_step", "current_noise", "current_drift"), none
    )
    sensors = Sensors(**(given | {name: np.atleast_1d(value) for name, value in parts.items()}))
    seen = Readings(sensors, np.array([0.123456]), np.ones(1), seed=1)
    return [values[:, 0] for values in seen.see(np.full((10_000, 1), 0.123456), np.ones((10_000, 1)), TICK)]


def test_sensors_add_noise_and_steps_or_nothing():
    _, _, current = readings(current_noise=0.03, current_drift=0.04)
    noise = current - 1.0
    assert np.std(noise) == pytest.approx(0.05, rel=0.05)
    # five ticks are the 10 ms after which 37 % are left
    assert np.mean(noise[5:] * noise[:-5]) == pytest.approx(0.04**2 * np.exp(-1.0), rel=0.25)
    position, velocity, current = readings(encoder_step=1e-3, current_step=0.3)
    np.testing.assert_allclose(position, 0.123)
    np.testing.assert_allclose(velocity, 0.0)
    np.testing.assert_allclose(current, 0.9)
    position, velocity, current = readings()
    assert set(position) == {0.123456}
    assert set(velocity) == {0.0}
    assert set(current) == {1.0}
