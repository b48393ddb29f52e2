"""Simulated recordings, of a model that follows a motion exactly or of a plant that is commanded along it."""

from dataclasses import dataclass, replace
from zlib import crc32

import numpy as np

from ..arm.motion import Motion
from ..arm.robot import Robot
from ..effects import Prior
from ..model import Model
from ..preparation.undelayed import earlier
from ..recordings.recording import KnownPayload, Recording, Signal
from .plant import Measured, Plant
from .plant.plant import Watched


@dataclass(frozen=True)
class Sensors:
    """What the measurement adds.

    Attributes:
        current_noise: Standard deviation of white current noise over each joint's rms current [-].
        encoder_noise: Standard deviation of position noise [rad].
        encoder_step: Resolution of position [rad]; zero for none.
    """

    current_noise: float = 0.01
    encoder_noise: float = 1e-6
    encoder_step: float = 4e-6


def simulate(
    plant: Model,
    values: np.ndarray,
    gain: np.ndarray,
    motion: Motion,
    nominal: Model,
    sensors: Sensors = Sensors(),  # noqa: B008
    payload: KnownPayload | None = None,
    name: str = "simulated",
    seed: int = 0,
) -> Recording:
    """Record a motion that a plant follows exactly.

    Args:
        plant: What the arm really is, with any payload as one of its effects.
        values: Its parameters, shape (p,).
        gain: Its drive gains, shape (n,) [N m/A].
        motion: What the joints do.
        nominal: The model that the recording holds.
        sensors: What they add.
        payload: That the recording names; None for none.
        name: Name of the recording.
        seed: Seed of the noise.
    """
    random = np.random.default_rng(seed)
    carried = replace(motion, payload=payload.name if payload else "")
    current = exact_current(plant, values, gain, carried)
    usual = np.sqrt(np.mean(current**2, axis=0))
    current = current + sensors.current_noise * usual * random.normal(size=current.shape)
    position = motion.position + sensors.encoder_noise * random.normal(size=current.shape)
    if sensors.encoder_step:
        position = np.round(position / sensors.encoder_step) * sensors.encoder_step
    signals = {
        "position": Signal(motion.time, position),
        "current": Signal(motion.time, current),
        "command": Signal(motion.time, motion.position),
    }
    settings = {"source": f"simulated, seed {seed}"}
    return Recording(name, nominal, signals, payload=payload, settings=settings)


def exact_current(plant: Model, values: np.ndarray, gain: np.ndarray, motion: Motion) -> np.ndarray:
    """Motor current without noise as it is recorded, shape (t, n) [A], formed in pieces to spare memory."""
    torque = np.concatenate([columns @ values + known for columns, known in plant.pieces(motion)])
    torque = torque + plant.at(values).gear_torque(motion)[0]
    current = plant.recorded(torque @ plant.robot.to_motors.T) / gain
    return np.clip(earlier(motion.time, current, -plant.delay), -plant.current_limit, plant.current_limit)


USUAL = 0.1
"""Relative deviation of values without a stated tolerance: what data sheets of drive gains are off by."""
MOST = 0.1
"""Largest relative change: limits and monitors of the nominal arm still fit."""


def as_built(model: Model) -> Model:
    """The same effects with other values, drawn within the tolerances of the nominal ones.

    The same model always gives the same arm, whatever else is added to it: each value is drawn by its name.
    Masses change with all moments of their link, so that every body can exist.
    """
    stated = {
        name: Prior(prior.value * _factor(name, _share(prior)), prior.std)
        for name, prior in model.stated.items()
    }
    return replace(model, robot=_robot(model.robot), stated=stated)


def _robot(robot: Robot) -> Robot:
    tolerances = zip(robot.joints, robot.drive_gain_tolerance, strict=True)
    factors = [_factor(f"gain {joint}", tolerance) for joint, tolerance in tolerances]
    kinematics = robot.kinematics.copy()
    for link, joint in enumerate(robot.joints, start=1):
        body = kinematics.inertias[link]
        factor = _factor(f"link {joint}", robot.inertial_tolerance)
        body.mass, body.inertia = factor * body.mass, factor * body.inertia
        kinematics.inertias[link] = body
    return replace(robot, kinematics=kinematics, drive_gain=np.array(factors) * robot.drive_gain)


def _share(prior: Prior) -> float:
    """Relative deviation of a prior."""
    return prior.std / abs(prior.value) if prior.value and np.isfinite(prior.std) else USUAL


def _factor(name: str, tolerance: float) -> float:
    """One, less or more by up to the tolerance; the same for the same name."""
    drawn = np.random.default_rng(crc32(name.encode())).uniform(-1.0, 1.0)
    return 1.0 + drawn * min(tolerance, MOST)


def follow(
    plant: Plant, position: np.ndarray, velocity: np.ndarray, tick: float, watched: Watched = iter
) -> dict[str, Signal]:
    """Signals of a run as a controller would have measured them, keys from `SIGNALS`.

    The plant stands where the motion begins. Positions (t, n) [rad] and velocities (t, n) [rad/s] are
    commanded one a tick [s], each reached at its own time; `watched` hands them on one by one, and may show
    how far that is.
    """
    seen = [plant.measure()]
    if len(position) > 1:
        seen.append(plant.follow(position[1:], velocity[1:], tick, watched))
    measured = zip(Measured._fields, map(np.vstack, zip(*seen, strict=True)), strict=True)
    every = dict(measured) | {"command": position, "command_velocity": velocity}
    time = tick * np.arange(len(position))
    return {name: Signal(time, values) for name, values in every.items()}
