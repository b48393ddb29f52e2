"""Follow: what a simulated arm's sensors say while it is commanded along a motion, tick by tick."""

import numpy as np

from .plant import Plant
from .recording import Signal


def follow(plant: Plant, position: np.ndarray, velocity: np.ndarray, tick: float) -> dict[str, Signal]:
    """Signals of a run as a controller would have measured them, keys from `SIGNALS`.

    Args:
        plant: The arm, standing where the motion begins.
        position: Commanded, one a tick, shape (t, n) [rad].
        velocity: Commanded, shape (t, n) [rad/s].
        tick: Time from command to command [s]; each is reached at its own time.
    """
    start, then = plant.measure(), plant.follow(position[1:], velocity[1:], tick)
    pairs = zip(start, then, strict=True)
    measured = {name: np.vstack(pair) for name, pair in zip(start._fields, pairs, strict=True)}
    every = measured | {"command": position, "command_velocity": velocity}
    time = tick * np.arange(len(position))
    return {name: Signal(time, values) for name, values in every.items()}
