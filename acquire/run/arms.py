"""The arm that a driver gets, and the simulated ones that the mock drives."""

from collections.abc import Callable, Mapping
from typing import Any
from zlib import crc32

import numpy as np

from exidyn.drivers import Arm, Driver, create
from exidyn.drivers.driver import Plant
from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects import Payload
from exidyn.identification.model import Model
from exidyn.identification.recordings.recording import KnownPayload
from exidyn.identification.simulation.plant import typical_plant

from .errors import explained_if_slow

SHARE = 0.3
"""Of its range at which each joint stands [-]: half-way most arms point up, and gravity has little effect."""


def make_driver(
    name: str, settings: Mapping[str, Any], robot: Robot, plant: Callable[[], Plant] | None = None
) -> Driver:
    """A driver that is not open yet.

    Raises:
        DriverError: An unknown driver, or settings that it cannot have.
    """
    limits = robot.limits
    arm = Arm(robot.joints, limits.position_lower, limits.position_upper, limits.velocity, plant)
    return create(name, settings, arm)


def noise_seed(seed: int, run: str) -> int:
    """Seed of the noise of one run, by its name: two runs of an arm are two draws, and each can be repeated.

    Runs with the same noise do not average it: what is fitted to them would seem more certain than it is.
    """
    return crc32(f"{seed} {run}".encode())


def standing_pose(robot: Robot) -> np.ndarray:
    """Where the simulated arm stands, shape (n,) [rad] or [m]; joints without limits have half a turn."""
    lower = np.where(np.isfinite(robot.limits.position_lower), robot.limits.position_lower, -np.pi)
    upper = np.where(np.isfinite(robot.limits.position_upper), robot.limits.position_upper, np.pi)
    pose: np.ndarray = lower + SHARE * (upper - lower)
    return pose


def standing_arm(nominal: Robot, real: Model, seed: int = 0, payload: str = "") -> Callable[[], Plant]:
    """What makes the arm of the mock: the real one with a body by name, at `standing_pose` of the nominal."""
    return lambda: simulated_arm(real, standing_pose(nominal), seed=seed, payload=payload)


def simulated_arm(model: Model, start: np.ndarray, *, seed: int = 0, payload: str = "") -> Plant:
    """`typical_plant`; see `explained_if_slow`."""
    with explained_if_slow():
        return typical_plant(model, start, seed=seed, payload=payload)


def with_body(model: Model, body: KnownPayload | None) -> Model:
    """The model with what hangs on its flange."""
    return model if body is None else model + Payload(body.name, body.known)
