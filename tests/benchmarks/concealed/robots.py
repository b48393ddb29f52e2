"""Robots that tests of concealed cases record."""

from dataclasses import replace
from functools import cache

import numpy as np
from parts.concealed.plant.closed_loop import SETTLE, STEP
from parts.concealed.recordings.motion import derivatives, smooth
from parts.concealed.robots.arms import ARMS, NO_BALANCER, Arm, Limits, Tool, chain
from parts.concealed.robots.robot import honest


def small_arm(joints: int = 2, lean: int = 0) -> Arm:
    """An arm of one or two equal joints, the second's axis leaning by quarter turns."""
    ones = np.ones(joints)
    body = chain(
        [1] + [lean] * (joints - 1),
        [(0.0, 0.0, 0.3)] + [(0.5, 0.0, 0.1)] * (joints - 1),
        [4.0] * joints,
        [(0.25, 0.02, 0.05)] * joints,
        [(0.05, 0.15, 0.15)] * joints,
    )
    limits = Limits(-3 * ones, 3 * ones, 2 * ones, 8 * ones, 100 * ones)
    return Arm(
        name="small", body=body, limits=limits, home=0.0 * ones, gain=10 * ones, gear=100 * ones, rotor=ones,
        viscous=5 * ones, coulomb=4 * ones, encoder=5e-6 * ones, current=0.01 * ones, floor=0.2 * ones,
        tool=Tool(1.0, np.array([0.0, 0.0, 0.1]), np.full(3, 0.1)), warm=True, balancer=NO_BALANCER,
    )  # fmt: skip


def sticking(arm: Arm, seed: int = 0):
    """A sound robot of an arm, with bristles in its joints and all terms nominal."""
    robot = honest(arm, np.random.default_rng(seed))
    return robot.with_friction(creep=np.zeros(arm.joints), coulomb=np.array(arm.coulomb))


@cache
def sound(name: str):
    """A robot with nothing wrong."""
    arm = ARMS[name]()
    return replace(honest(arm, np.random.default_rng(3)), peak=0.5 * arm.limits.torque)


def swing(joints: int, seconds: float) -> np.ndarray:
    """From rest to rest, two joints in opposite ways, (3, s, n)."""
    time = np.arange(round(seconds / STEP)) * STEP
    return derivatives(np.outer(smooth(time / seconds), 0.6 * np.array([1.0, -1.0])[:joints]))


def quiet(path: np.ndarray) -> np.ndarray:
    """No disturbance of a path."""
    return np.zeros((path.shape[1] + round(SETTLE / STEP), path.shape[2]))
