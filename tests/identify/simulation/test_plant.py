"""The plant moves by its model, and its sensors measure it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from exidyn.identification.effects import (
    EFFECTS,
    CoulombFriction,
    Payload,
    RigidBody,
    RotorInertia,
    known_parameters,
)
from exidyn.identification.errors import RobotError, WrongShape
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.plant import (
    DriveControl,
    Integration,
    Measured,
    Plant,
    Sensors,
    typical_plant,
)
from exidyn.identification.simulation.plant.typical import typical_parts
from exidyn.identification.simulation.simulate import exact_current
from exidyn.trajectories.random_motion import random_fourier

from ...parts.runs.robots import six_axis, sliding
from ...parts.runs.simulated import (
    GRAVITY,
    LEVER,
    MASS,
    ROTOR,
    follow,
    known,
    pendulum,
    pendulum_values,
    stiff,
)
from ..effects.test_effects import default
from .test_plant_forces import drawn

pytestmark = pytest.mark.slow

TICK = 0.002
BODY = known_parameters(8.0, (0.05, 0.03, 0.1), (0.1, 0.01, 0.02, 0.12, 0.01, 0.08))


def quiet(model, payload="", integration=None, seconds=2.0, seed=0):
    """A plant with exact sensors, and a random motion that it is to follow."""
    wave = replace(random_fourier(model.robot.limits, 8.0, seed=seed), rest=0.0, ramp=0.5)
    motion = wave.at(TICK * np.arange(1, round(seconds / TICK)))
    position, velocity = motion.position, motion.velocity
    plant = Plant(
        model,
        model.nominal_values,
        model.robot.drive_gain,
        position[0],
        typical_parts(model)[0],
        payload=payload,
        integration=integration or Integration(),
    )
    return plant, position, velocity


def differentiated(motion):
    """The motion by its positions alone, as an identification knows it."""
    spline = make_interp_spline(motion.time, motion.position, 5)
    return replace(motion, velocity=spline(motion.time, 1), acceleration=spline(motion.time, 2))


def misfit(model, run):
    """Rms of measured current minus that of the positions' inverse dynamics, over the rms current, (n,)."""
    inside = slice(100, -100)
    exact = exact_current(model, model.nominal_values, model.robot.drive_gain, differentiated(run.motion))
    wrong = (run.measured.current - exact)[inside]
    return np.sqrt(np.mean(wrong**2, axis=0) / np.mean(exact[inside] ** 2, axis=0))


@pytest.mark.parametrize("name", ["cobot", "kr270"])
def test_current_is_inverse_dynamics_of_the_motion_that_happened(name):
    model = read_model(name) + Payload("L", BODY)
    run = follow(*quiet(model, "L"))
    exact = exact_current(model, model.nominal_values, model.robot.drive_gain, run.motion)
    np.testing.assert_allclose(run.measured.current, exact, atol=1e-9 * np.abs(exact).max())
    assert np.all(misfit(model, run) < 3e-3)
    assert np.all(misfit(model, run)[:3] < 1e-3)


def test_the_error_of_a_step_is_of_second_order():
    model = read_model("cobot")
    rough, fine = (
        np.linalg.norm(misfit(model, follow(*quiet(model, integration=cut, seconds=1.0))))
        for cut in (Integration(2e-3, 2e-3), Integration(5e-4, 5e-4))
    )
    assert fine < 0.15 * rough


def test_a_motor_that_several_joints_turn_makes_their_work():
    robot = replace(six_axis(), drive_gain=np.arange(2.0, 8.0))
    model = Model(robot, (RigidBody(), RotorInertia()))
    values = drawn(model)
    control = DriveControl.tuned(np.full(6, 60.0), 10.0, np.full(6, np.inf))
    plant = Plant(model, values, robot.drive_gain, np.zeros(6), control)
    time = TICK * np.arange(1, 400)[:, None]
    wave = 0.2 * np.sin(time * np.arange(3.0, 9.0)) ** 3
    run = follow(plant, wave, np.gradient(wave, TICK, axis=0))
    exact = exact_current(model, values, robot.drive_gain, run.motion)
    np.testing.assert_allclose(run.measured.current, exact, rtol=1e-9, atol=1e-9 * np.abs(exact).max())
    assert np.abs(run.motion.position - wave).max() < 0.05


@pytest.mark.parametrize("robot", [six_axis, sliding])
@pytest.mark.parametrize("key", EFFECTS)
def test_every_effect_is_simulated(key, robot):
    more = () if key in ("link_inertia", "rotor_inertia") else (default(key),)
    model = Model(robot(), (RigidBody(), RotorInertia(), *more))
    values = drawn(model)
    model = known(model, values)
    control = DriveControl.tuned(np.full(6, 60.0), 10.0, np.full(6, np.inf))
    plant = Plant(model, values, np.ones(6), np.full(6, 0.3), control, payload="L")
    time = TICK * np.arange(1, 100)[:, None]
    wave = 0.3 + 0.1 * np.sin(12.0 * time + np.zeros(6)) * np.tanh(8.0 * time) ** 3
    run = follow(plant, wave, np.gradient(wave, TICK, axis=0))
    exact = exact_current(model, values, np.ones(6), run.motion)
    np.testing.assert_allclose(run.measured.current, exact, atol=2e-3 * np.abs(exact).max())
    assert np.ptp(run.motion.position, axis=0).min() > 0.05


def test_a_pendulum_keeps_its_energy_and_its_period():
    model = pendulum()
    plant = Plant(model, pendulum_values(), np.ones(1), np.array([1.0]), stiff(1))
    plant.release()
    run = follow(plant, np.ones((2500, 1)), np.zeros((2500, 1)))
    inertia = MASS * LEVER**2 + ROTOR
    position, velocity = run.motion.position[:, 0], run.motion.velocity[:, 0]
    energy = 0.5 * inertia * velocity**2 - MASS * GRAVITY * LEVER * np.cos(position)
    swing = MASS * GRAVITY * LEVER
    np.testing.assert_allclose(energy, -swing * np.cos(1.0), atol=1e-3 * swing)
    crossings = run.motion.time[1:][(position[1:] < 0) & (position[:-1] >= 0)]
    # amplitude of 1 rad: longer than for small ones by 1 + 1/16 + 11/3072 + ...
    period = 2 * np.pi * np.sqrt(inertia / swing) * 1.066318
    assert np.mean(np.diff(crossings)) == pytest.approx(period, rel=1e-3)


def test_nothing_jumps_at_the_start():
    model = read_model("kr270")
    start = np.array([0.3, -1.0, 0.8, 0.5, 0.4, -0.2])
    parts = typical_parts(model)[0]
    plant = Plant(model, model.nominal_values, model.robot.drive_gain, start, parts)
    current = plant.measure().current
    run = follow(plant, np.tile(start, (100, 1)), np.zeros((100, 6)))
    assert np.abs(run.motion.position - start).max() < 1e-9
    np.testing.assert_allclose(run.measured.current, np.tile(current, (100, 1)), atol=1e-6)
    assert np.abs(current).max() > 1.0  # it does hold the arm


def test_an_arm_holds_still_and_moves_without_chatter():
    model = pendulum(CoulombFriction(reversal=1e-4), axis="z")
    plant = Plant(model, pendulum_values(20.0, axis="z"), np.ones(1), np.zeros(1), stiff(1))
    time = TICK * np.arange(1, 2001)[:, None]
    run = follow(plant, 0.05 * np.sin(np.pi * time) ** 2, 0.05 * np.pi * np.sin(2 * np.pi * time))
    velocity = run.motion.velocity[:, 0]
    assert np.count_nonzero(np.diff(np.sign(velocity))) == 7  # forth and back, four times
    model = pendulum(CoulombFriction(reversal=1e-4))
    plant = Plant(model, pendulum_values(50.0), np.ones(1), np.array([1.0]), stiff(1))
    plant.release()
    run = follow(plant, np.ones((500, 1)), np.zeros((500, 1)))
    assert np.abs(run.motion.velocity).max() < 1e-4  # it creeps, as smooth friction lets it
    assert np.all(np.diff(run.motion.position[:, 0]) <= 0.0)


def test_the_same_seed_is_the_same_recording_bit_for_bit():
    model = read_model("cobot")
    _, position, velocity = quiet(model, seconds=0.2)
    runs = [follow(typical_plant(model, position[0], seed=seed), position, velocity) for seed in (1, 1, 2)]
    for one, again in zip(runs[0].measured, runs[1].measured, strict=True):
        np.testing.assert_array_equal(one, again)
    assert np.any(runs[0].measured.current != runs[2].measured.current)
    np.testing.assert_array_equal(runs[0].motion.position, runs[2].motion.position)


@pytest.mark.parametrize("with_velocity", [True, False], ids=["velocities", "positions alone"])
def test_to_follow_is_to_step_from_command_to_command(with_velocity):
    model, none = read_model("kr270"), np.zeros(6)
    _, position, velocity = quiet(model, seconds=0.3)
    velocity = velocity if with_velocity else [None] * len(position)
    control, sensors, thermal = typical_parts(model)
    sensors = replace(sensors, encoder_step=none, current_step=none, temperature_step=0.0, current_delay=3e-3)
    parts = (
        model,
        model.nominal_values,
        model.robot.drive_gain,
        position[0],
        control,
        sensors,
        None,
        thermal,
    )
    stepping, following = Plant(*parts, seed=1), Plant(*parts, seed=1)
    seen = []
    for wanted, speed in zip(position, velocity, strict=True):
        stepping.step(wanted, speed, TICK)
        seen.append(stepping.measure())
    pieces = [
        following.follow(position[rows], velocity[rows] if with_velocity else None, TICK)
        for rows in (slice(0, 1), slice(1, 40), slice(40, None))
    ]
    for name, one, other in zip(
        Measured._fields, zip(*seen, strict=True), zip(*pieces, strict=True), strict=True
    ):
        np.testing.assert_allclose(np.concatenate(other), one, rtol=1e-9, atol=1e-9, err_msg=name)
    for last, one in zip(following.measure(), seen[-1], strict=True):
        np.testing.assert_allclose(last, one, rtol=1e-9, atol=1e-9)


def test_slow_ticks_move_the_arm_as_fast_ones_do():
    model = read_model("cobot")
    plant, position, velocity = quiet(model, seconds=1.0)
    often = follow(plant, position[5::6], velocity[5::6], 6 * TICK)
    again = Plant(model, model.nominal_values, model.robot.drive_gain, position[0], typical_parts(model)[0])
    fine = follow(again, position, velocity)
    np.testing.assert_allclose(often.motion.position[40:], fine.motion.position[5::6][40:], atol=2e-5)


def test_the_amplifier_gives_no_more_than_its_largest_current():
    control = DriveControl.tuned(np.ones(1), 3.0, np.array([3.0]))
    plant = Plant(pendulum(axis="z"), pendulum_values(axis="z"), np.array([-2.0]), np.zeros(1), control)
    run = follow(plant, np.full((2000, 1), 0.5), np.zeros((2000, 1)))
    current = run.measured.current[:, 0]
    assert np.abs(current).max() == pytest.approx(3.0)
    inertia = MASS * LEVER**2 + ROTOR
    assert run.motion.acceleration[10, 0] == pytest.approx(3.0 * 2.0 / inertia)
    assert run.motion.position[-1, 0] == pytest.approx(0.5, abs=1e-3)


def test_iron_that_saturates_takes_more_current():
    control = replace(DriveControl.tuned(np.ones(1), 25.0, np.array([100.0])), saturation=np.array([8.0]))
    plant = Plant(pendulum(), pendulum_values(), np.array([3.0]), np.array([np.pi / 2]), control)
    torque = MASS * GRAVITY * LEVER
    current = plant.measure().current[0]
    assert 3.0 * current / np.sqrt(1 + (current / 8.0) ** 2) == pytest.approx(torque)
    assert current > 1.2 * torque / 3.0
    assert control.torque_limit(np.array([3.0]))[0] < 3.0 * 8.0


def test_currents_are_as_late_as_stated():
    model = read_model("cobot")
    _, position, velocity = quiet(model, seconds=0.5)
    exact, late = (
        follow(
            Plant(
                model, model.nominal_values, model.robot.drive_gain, position[0], typical_parts(model)[0],
                Sensors.exact(6, current_delay=delay),
            ),
            position,
            velocity,
        ).measured.current
        for delay in (0.0, 0.0031)
    )  # fmt: skip
    np.testing.assert_allclose(late[2:], 0.45 * exact[1:-1] + 0.55 * exact[:-2], atol=1e-9)


@pytest.mark.parametrize(("what", "start"), [("start", np.zeros(5)), ("start", np.full(6, np.nan))])
def test_a_start_that_is_none_is_refused(what, start):
    with pytest.raises(WrongShape, match=f"cobot: {what} is .*expected 6 finite numbers"):
        typical_plant(read_model("cobot"), start)


def test_an_arm_that_cannot_move_is_refused():
    model = Model(pendulum().robot, (CoulombFriction(),))
    with pytest.raises(RobotError, match="inertia is not positive definite"):
        Plant(model, np.ones(1), np.ones(1), np.zeros(1), stiff(1))
