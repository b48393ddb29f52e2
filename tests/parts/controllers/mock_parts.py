"""A mock of a small arm, and what is asked of it."""

import numpy as np

from exidyn.drivers import Arm, Command, create
from exidyn.identification.simulation.plant import typical_plant

from ..small.two_joints import GAIN, model, trajectory, true_values

CYCLE = 0.002
STEPPED = {"clock": "stepped"}


def two_joint_plant():
    return typical_plant(model(), trajectory(12.0).at(np.zeros(1)).position[0], true_values(model()), GAIN)


def arm(plant=two_joint_plant):
    limits = model().robot.limits
    return Arm(model().robot.joints, limits.position_lower, limits.position_upper, limits.velocity, plant)


def opened(**settings):
    driver = create("mock", STEPPED | settings, arm())
    info = driver.open()
    driver.arm_drives()
    return driver, info


def moving(count=500, speed=0.2, cycle=CYCLE):
    """Commands that speed up smoothly from where the arm stands."""
    start = trajectory(12.0).at(np.zeros(1)).position[0]
    times = cycle * np.arange(1, count + 1)
    share = np.minimum(times / 0.2, 1.0)
    pace = speed * share**2 * (3 - 2 * share)
    way = np.cumsum(pace) * cycle
    return [Command(start + a, np.full(2, v)) for a, v in zip(way, pace, strict=True)]


def play(driver, commands):
    return [driver.exchange(command) for command in commands]
