"""Drivers with their arms, and the simulated arms that the mock driver moves."""

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

RANGE_SHARE = 0.3
"""Share of its range where each joint stands [-]: halfway, most arms point up, where gravity does little."""


def make_driver(
    name: str, settings: Mapping[str, Any], robot: Robot, plant: Callable[[], Plant] | None = None
) -> Driver:
    """Create a driver without opening it.

    Raises:
        DriverError: If there is no such driver, or its settings are invalid.
    """
    limits = robot.limits
    arm = Arm(robot.joints, limits.position_lower, limits.position_upper, limits.velocity, plant)
    return create(name, settings, arm)


def noise_seed(seed: int, run: str) -> int:
    """Seed of the noise of a run, derived from its name, so that runs differ and each can be repeated.

    Runs with the same noise do not average it, and would make estimates seem more certain than they are.
    """
    return crc32(f"{seed} {run}".encode())


def standing_pose(robot: Robot) -> np.ndarray:
    """Position of the simulated arm, shape (n,) [rad] or [m]; a missing limit counts as half a turn."""
    lower = np.where(np.isfinite(robot.limits.position_lower), robot.limits.position_lower, -np.pi)
    upper = np.where(np.isfinite(robot.limits.position_upper), robot.limits.position_upper, np.pi)
    pose: np.ndarray = lower + RANGE_SHARE * (upper - lower)
    return pose


def standing_arm(nominal: Robot, real: Model, seed: int = 0, payload: str = "") -> Callable[[], Plant]:
    """Factory of the mock's arm: the real model with a named payload, at the nominal `standing_pose`."""
    return lambda: simulated_arm(real, standing_pose(nominal), seed=seed, payload=payload)


def simulated_arm(model: Model, start: np.ndarray, *, seed: int = 0, payload: str = "") -> Plant:
    """Create a `typical_plant`, and explain to the user if this is slow."""
    with explained_if_slow():
        return typical_plant(model, start, seed=seed, payload=payload)


def with_body(model: Model, body: KnownPayload | None) -> Model:
    """The model with its payload, if any."""
    return model if body is None else model + Payload(body.name, body.known)
