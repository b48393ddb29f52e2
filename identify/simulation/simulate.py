"""Simulated recordings of a model that follows a motion exactly, or of a plant that is commanded to."""

from dataclasses import dataclass, replace
from zlib import crc32

import numpy as np

from ..arm.motion import Motion
from ..effects import Prior
from ..model import Model
from ..preparation.filters import earlier
from ..recordings.recording import KnownPayload, Recording, Signal
from .plant import Measured, Plant
from .plant.plant import Watched


@dataclass(frozen=True)
class Sensors:
    """Noise and resolution of the measurement."""

    # Standard deviation of white current noise relative to each joint's RMS current [-].
    current_noise: float = 0.01
    encoder_noise: float = 1e-6  # standard deviation of position noise [rad]
    encoder_step: float = 4e-6  # resolution of position [rad]; zero for none


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

    The plant has parameters `values` (p,), drive gains `gain` (n,) [N m/A], and any payload as one of its
    effects; `nominal` and `payload` are stored in the recording.
    """
    random = np.random.default_rng(seed)
    with_payload = replace(motion, payload=payload.name if payload else "")
    current = exact_current(plant, values, gain, with_payload)
    rms = np.sqrt(np.mean(current**2, axis=0))
    current = current + sensors.current_noise * rms * random.normal(size=current.shape)
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
    """Recorded motor current without noise, shape (t, n) [A], computed in pieces to save memory."""
    torque = np.concatenate([columns @ values + known for columns, known in plant.pieces(motion)])
    torque = torque + plant.at(values).gear_torque(motion)[0]
    current = plant.recorded(torque @ plant.robot.to_motors.T) / gain
    return np.clip(earlier(motion.time, current, -plant.delay), -plant.current_limit, plant.current_limit)


USUAL = 0.1
"""Relative tolerance of values that state none: a typical error of drive gains in data sheets."""
MOST = 0.1
"""Maximum relative change, so that the limits and monitors of the nominal arm still fit."""


def as_built(model: Model) -> Model:
    """The model with values drawn within the tolerances of its nominal values.

    The random number of each value depends only on its name, so the same model always gives the same arm,
    even after other effects were added. Mass and moments of a link scale by one factor, so that every body
    stays physically consistent.
    """
    stated = {}
    for name, prior in model.stated.items():
        known = prior.value and np.isfinite(prior.std)
        tolerance = prior.std / abs(prior.value) if known else USUAL
        stated[name] = Prior(prior.value * _factor(name, tolerance), prior.std)
    robot = model.robot
    kinematics, gain = robot.kinematics.copy(), robot.drive_gain.copy()
    for place, joint in enumerate(robot.joints):
        gain[place] *= _factor(f"gain {joint}", robot.drive_gain_tolerance[place])
        body = kinematics.inertias[place + 1]
        factor = _factor(f"link {joint}", robot.inertial_tolerance)
        body.mass, body.inertia = factor * body.mass, factor * body.inertia
        kinematics.inertias[place + 1] = body
    return replace(model, robot=replace(robot, kinematics=kinematics, drive_gain=gain), stated=stated)


def _factor(name: str, tolerance: float) -> float:
    """A factor within the tolerance of one, determined by the name."""
    drawn = np.random.default_rng(crc32(name.encode())).uniform(-1.0, 1.0)
    return 1.0 + drawn * min(tolerance, MOST)


def follow(
    plant: Plant, position: np.ndarray, velocity: np.ndarray, period: float, watched: Watched = iter
) -> dict[str, Signal]:
    """Signals of a run as a controller would have measured them, keys from `SIGNALS`.

    The plant stands at the start of the motion. Positions (t, n) [rad] and velocities (t, n) [rad/s] are
    commanded once per sampling period [s], and each is reached at its own time. `watched` wraps the iteration
    over samples, for example to show progress.
    """
    measurements = [plant.measure()]
    if len(position) > 1:
        measurements.append(plant.follow(position[1:], velocity[1:], period, watched))
    measured = zip(Measured._fields, map(np.vstack, zip(*measurements, strict=True)), strict=True)
    signals = dict(measured) | {"command": position, "command_velocity": velocity}
    time = period * np.arange(len(position))
    return {name: Signal(time, values) for name, values in signals.items()}
