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
    seen = [plant.measure()]
    for wanted, speed in zip(position[1:], velocity[1:], strict=True):
        plant.step(wanted, speed, tick)
        seen.append(plant.measure())
    time = tick * np.arange(len(position))
    measured = dict(zip(seen[0]._fields, map(np.array, zip(*seen, strict=True)), strict=True))
    every = measured | {"command": position, "command_velocity": velocity}
    return {name: Signal(time, values) for name, values in every.items()}
