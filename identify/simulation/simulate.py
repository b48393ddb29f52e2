"""A recording of a model that follows a motion exactly: torque by inverse dynamics, noise on top."""

from dataclasses import dataclass, replace

import numpy as np

from ..arm.motion import Motion
from ..model import Model
from ..recordings.recording import KnownPayload, Recording, Signal

CHUNK = 2000
"""Samples whose regressor is held at once: a few megabytes."""


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
        sensors: Noise.
        payload: The payload that the recording names; None for none.
        name: Of the recording.
        seed: Of the noise.
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
    """Motor current without noise, shape (t, n) [A], formed in pieces to spare memory."""
    remembered = plant.remember(motion)
    pieces = []
    for start in range(0, len(motion), CHUNK):
        rows = slice(start, start + CHUNK)
        piece = plant.loaded(motion[rows])
        columns = plant.regressor(piece, {place: every[rows] for place, every in remembered.items()})
        pieces.append(columns @ values + plant.known_torque(piece))
    return np.concatenate(pieces) @ plant.robot.to_motors.T / gain
