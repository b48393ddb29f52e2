"""A model that holds what lies between arm and recordings: files, fits, simulation and export."""

from dataclasses import replace

import numpy as np
import pytest

from exidyn.identification.effects import Prior, RotorInertia
from exidyn.identification.errors import ExidynError
from exidyn.identification.export import FORMATS, Portable
from exidyn.identification.fit.fit_file import fit_text
from exidyn.identification.fit.identification import identify
from exidyn.identification.fit.identified import identified
from exidyn.identification.measurements import (
    MEASUREMENTS,
    Backlash,
    CurrentClipping,
    DriveGainSaturation,
    JointElasticity,
    TimeDelay,
)
from exidyn.identification.preparation.prepare import prepare
from exidyn.identification.robot_files.commented import commented_text
from exidyn.identification.robot_files.robot_file import parse_model
from exidyn.identification.robot_files.robot_text import model_text
from exidyn.identification.simulation.plant import DriveControl, Plant, Sensors, Transmission
from exidyn.identification.simulation.simulate import Sensors as Noise
from exidyn.identification.simulation.simulate import follow, simulate
from exidyn.trajectories.random_motion import random_fourier

from ...parts.small import two_joints

EVERY = {
    "time_delay": TimeDelay(0.0137),
    "time_delay of one": TimeDelay(-0.0061, ("elbow",)),
    "joint_elasticity": JointElasticity("elbow", 900.0, 1.5),
    "backlash": Backlash("elbow", 0.01, 0.4, 6.0),
    "drive_gain_saturation": DriveGainSaturation("shoulder", 0.3, 12.0, 20.0),
    "drive_gain_saturation below a ceiling": DriveGainSaturation("shoulder", 0.4, ceiling=80.0),
    "current_clipping": CurrentClipping(1.2, ("shoulder",)),
}
RATE = 500.0


def arm(*measurements):
    """With friction that is a tenth short of the true one, as where filters reach over clipped samples."""
    model = two_joints.model()
    friction = {"Fv1": 3.0, "Fv2": 1.5, "Fc1": 4.0, "Fc2": 2.0}
    stated = {name: Prior(0.9 * value) for name, value in friction.items()}
    return replace(model, stated=stated, measurements=measurements)


def recording(*measurements, seed=0):
    """What is recorded of a motion that motors follow exactly, with little noise."""
    path = random_fourier(two_joints.arm().limits, 12.0, period=4.0, seed=seed)
    plant, sensors = arm(*measurements), Noise(1e-4, 0.0, 0.0)
    motion = path.at(np.arange(0.0, 12.0, 1.0 / RATE))
    values = two_joints.true_values(two_joints.model())
    return simulate(plant, values, two_joints.GAIN, motion, arm(), sensors, name=f"run{seed}")


def residual(fit):
    """Of the run held out, shape (n,) [N m]."""
    return fit.validation[0].residual_rms


def fitted(model, *measurements):
    runs = [recording(*measurements, seed=seed) for seed in (0, 1, 2)]
    return identify(runs[:2], runs[2:], model=model, as_recorded=True)


@pytest.mark.parametrize("name", EVERY)
def test_a_file_holds_it(name):
    model = arm(EVERY[name], TimeDelay(0.001, ("shoulder",)))
    assert parse_model(model_text(model)).measurements == model.measurements
    assert parse_model(commented_text(model)).measurements == model.measurements


def test_every_kind_is_kept_by_a_fit_and_its_arm():
    assert {type(one) for one in EVERY.values()} == set(MEASUREMENTS.values())
    fit = fitted(arm(EVERY["time_delay"]), EVERY["time_delay"])
    assert identified(fit).measurements == (EVERY["time_delay"],)
    assert "time_delay" in fit_text(fit)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ('name = "time_delays"\nseconds = 0.1', "there is no measurement 'time_delays'"),
        ('name = "time_delay"', "needs seconds"),
        ('name = "time_delay"\nseconds = 12.0', "exceeds 1 s"),
        ('name = "time_delay"\nseconds = 0.01\njoints = [1]', "elbow"),
        ('name = "joint_elasticity"\njoint = "wrist"\nstiffness = 1e4', "wrist"),
        ('name = "joint_elasticity"\njoint = "elbow"\nstiffness = 0.0', "stiffness: 0 is not above 0"),
        ('name = "backlash"\njoint = "elbow"\ngap = -1e-3', "gap: -0.001 is not above 0"),
        ('name = "current_clipping"\nlimit = 0.0', "limit: 0 is not above 0"),
        ('name = "drive_gain_saturation"\njoint = "elbow"\nloss = 0.1', "either knee and width, or"),
    ],
)
def test_a_wrong_row_is_refused(row, words):
    with pytest.raises(ExidynError, match=words):
        parse_model(f"{model_text(arm())}\n[[measurement]]\n{row}\n")


@pytest.mark.parametrize("name", EVERY)
def test_a_fit_takes_it_out_of_recordings(name):
    rigid, with_it, without = fitted(arm()), fitted(arm(EVERY[name]), EVERY[name]), fitted(arm(), EVERY[name])
    np.testing.assert_allclose(with_it.estimate.values, rigid.estimate.values, rtol=0.03, atol=0.02)
    # What stands for clipped samples reaches by 5 mN m into rows beside them.
    assert np.all(residual(with_it) < np.maximum(1.5 * residual(rigid), 0.01))
    assert np.max(residual(without) / residual(with_it)) > 5.0


def test_delays_add_up_and_the_narrower_limit_holds():
    model = arm(
        TimeDelay(0.02), TimeDelay(-0.005, ("elbow",)), CurrentClipping(3.0), CurrentClipping(2.0, ("elbow",))
    )
    np.testing.assert_allclose(model.delay, [0.02, 0.015])
    np.testing.assert_allclose(model.current_limit, [3.0, 2.0])


def plant(*measurements):
    model = replace(two_joints.model(RotorInertia()), measurements=measurements)
    stated = dict(zip(model.names, two_joints.true_values(model), strict=True)) | {"Ia1": 0.5, "Ia2": 0.3}
    values = np.array([stated[name] for name in model.names])
    control = DriveControl.tuned(np.array([1.8, 0.6]), 25.0, np.full(2, np.inf))
    return Plant(model, values, two_joints.GAIN, np.zeros(2), control, Sensors.exact(2))


def followed(*measurements):
    time = np.arange(0.0, 2.0, 0.002)
    position = np.outer(1.0 - np.cos(2 * np.pi * time), [0.1, -0.15])
    return follow(plant(*measurements), position, np.gradient(position, 0.002, axis=0), 0.002)


def test_a_simulated_arm_shows_currents_or_positions_late():
    exact, late = followed(), followed(TimeDelay(0.02), TimeDelay(-0.01, ("elbow",)))
    for joint, samples in ((0, 10), (1, 5)):
        np.testing.assert_allclose(
            late["current"].values[samples:, joint], exact["current"].values[:-samples, joint], atol=1e-9
        )
    np.testing.assert_array_equal(late["position"].values, exact["position"].values)
    exact, early = followed(), followed(TimeDelay(-0.008))
    np.testing.assert_array_equal(early["current"].values, exact["current"].values)
    np.testing.assert_allclose(early["position"].values[4:], exact["position"].values[:-4], atol=1e-9)


def test_a_simulated_arm_clips_and_saturates():
    exact = followed()["current"].values
    clipped = followed(CurrentClipping(0.3))["current"].values
    np.testing.assert_allclose(clipped, np.clip(exact, -0.3, 0.3), atol=1e-12)
    one = DriveGainSaturation("shoulder", 0.5, 4.0, 2.0)
    shown = followed(one)["current"].values * two_joints.GAIN
    np.testing.assert_allclose(shown, one.recorded(arm().robot, exact * two_joints.GAIN), atol=1e-9)
    assert np.max(np.abs(shown - exact * two_joints.GAIN)) > 0.5


@pytest.mark.parametrize("name", ["drive_gain_saturation", "drive_gain_saturation below a ceiling"])
def test_a_restored_torque_is_the_torque(name):
    torque = np.stack([np.linspace(-70.0, 70.0, 501), np.linspace(-5.0, 5.0, 501)], axis=1)
    shown = arm(EVERY[name]).recorded(torque)
    assert np.max(np.abs(shown - torque)) > 3.0
    np.testing.assert_allclose(arm(EVERY[name]).restored(shown), torque, atol=1e-3)


def test_gears_of_a_model_are_those_of_its_plant():
    gears = Transmission.of(arm(JointElasticity("elbow", 900.0, 1.5), JointElasticity("elbow", 900.0, 1.0)))
    np.testing.assert_allclose(gears.stiffness, [np.inf, 450.0])
    np.testing.assert_allclose(gears.damping, [0.0, 1.5])
    play = Transmission.of(arm(Backlash("elbow", 0.01)))
    assert play.backlash.tolist() == [0.0, 0.01]
    assert np.isfinite(play.stiffness[1])


def test_a_fit_of_a_swinging_link_finds_its_friction():
    """In closed loop, with a gear that the simulation integrates and the fit computes along the motion."""
    gear = JointElasticity("elbow", 900.0, 1.5)
    made = []
    for seed in (0, 1):
        path = random_fourier(two_joints.arm().limits, 10.0, period=2.0, seed=seed).at(
            np.arange(0.0, 10.0, 0.002)
        )
        start = plant(gear)
        offset = path.position - path.position[0]
        signals = follow(start, offset, path.velocity, 0.002)
        del signals["link_position"]
        made.append(replace(recording(seed=seed), signals=signals))
    rotors = two_joints.model(RotorInertia())
    held, rigid = (
        identify(made[:1], made[1:], model=replace(rotors, measurements=gears), as_recorded=True)
        for gears in ((gear,), ())
    )
    assert np.all(held.validation[0].residual_rms < 0.5 * rigid.validation[0].residual_rms)
    assert held.value("Fc2") == pytest.approx(2.0, rel=0.05)


def test_a_second_encoder_shows_no_twist_beside_the_gear_that_a_model_holds():
    gear = JointElasticity("elbow", 900.0, 1.5)
    made = replace(recording(), signals=followed(gear))
    rotors = two_joints.model(RotorInertia())
    held, rigid = (
        prepare(replace(made, model=replace(rotors, measurements=gears))) for gears in ((gear,), ())
    )
    twists = [np.ptp((run.motion.position - run.link_position)[:, 1]) for run in (held, rigid)]
    assert twists[0] < 0.1 * twists[1]


def test_an_export_says_what_it_cannot_hold():
    portable = Portable.of(arm(*EVERY.values()))
    for name, format_ in FORMATS.items():
        left = [words for words in format_.leaves_out(portable) if words.partition(":")[0] in MEASUREMENTS]
        assert len(left) == (0 if name in ("json", "toml") else len(EVERY))
    assert parse_model(FORMATS["toml"].text(portable)).measurements == tuple(EVERY.values())
    assert '"seconds": 0.0137' in FORMATS["json"].text(portable)
