"""A small arm with runs of ten seconds, for tests of payloads."""

from dataclasses import replace
from functools import cache

import numpy as np

from exidyn.identification.arm.rigid_regressor import INERTIAL
from exidyn.identification.effects import Payload
from exidyn.identification.model import Model
from exidyn.identification.payload.body import Body
from exidyn.identification.recordings.recording import KnownPayload, Recording
from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.simulate import Sensors, simulate
from exidyn.trajectories.random_motion import random_fourier

RATE, SECONDS = 100.0, 14.0
TOOL = Body(3.0, np.array([0.02, -0.03, 0.12]), np.diag([0.012, 0.014, 0.006]))
"""The payload of the tests."""


@cache
def arm(gain_tolerance: float = 0.001, inertial_tolerance: float = 0.1) -> Model:
    """The cobot with these tolerances."""
    model = read_model("cobot")
    robot = replace(
        model.robot, drive_gain_tolerance=np.full(6, gain_tolerance), inertial_tolerance=inertial_tolerance
    )
    return replace(model, robot=robot)


def run(
    nominal: Model,
    seed: int,
    body: Body | None = None,
    links: float = 1.0,
    gain: float = 1.0,
    friction: float = 1.0,
    scatter: float = 0.0,
) -> Recording:
    """A run of an arm whose links, gains and friction are the nominal ones times these factors.

    Links also scatter by the share `scatter` of their sizes, as tolerances state.
    """
    plant, payload = nominal, None
    if body is not None:
        known = tuple(zip(INERTIAL, map(float, body.parameters), strict=True))
        plant, payload = nominal + Payload("L", known), KnownPayload("L", known)
    values = plant.nominal_values
    sizes = np.array([prior.std for prior in plant.priors]) / nominal.robot.inertial_tolerance
    drawn = scatter * np.random.default_rng(0).normal(size=len(values)) * sizes
    for effect, columns in zip(plant.effects, plant.columns, strict=True):
        values[columns] *= links if effect.of_links else friction if effect.greased else 1.0
        values[columns] += drawn[columns] if effect.of_links else 0.0
    time = np.arange(round(RATE * SECONDS)) / RATE
    motion = random_fourier(nominal.robot.limits, SECONDS, seed=seed).at(time)
    gains = gain * nominal.robot.drive_gain
    recording = simulate(
        plant, values, gains, motion, nominal, Sensors(0.005), payload, f"run {seed}", seed=seed
    )
    return replace(recording, payload=None)
