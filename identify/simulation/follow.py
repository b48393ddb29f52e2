"""Follow: what a simulated arm's sensors measure while it is commanded along a motion, tick by tick."""

import numpy as np

from ..recordings.recording import Signal
from .plant import Measured, Plant
from .plant.plant import Watched


def follow(
    plant: Plant,
    position: np.ndarray,
    velocity: np.ndarray,
    tick: float,
    watched: Watched = iter,
) -> dict[str, Signal]:
    """Signals of a run as a controller would have measured them, keys from `SIGNALS`.

    Args:
        plant: The arm, standing where the motion begins.
        position: Commanded, one a tick, shape (t, n) [rad].
        velocity: Commanded, shape (t, n) [rad/s].
        tick: Time from command to command [s]; each is reached at its own time.
        watched: Hands on the commands one by one, and may show how far that is.
    """
    seen = [plant.measure()]
    if len(position) > 1:
        seen.append(plant.follow(position[1:], velocity[1:], tick, watched))
    measured = zip(Measured._fields, map(np.vstack, zip(*seen, strict=True)), strict=True)
    every = dict(measured) | {"command": position, "command_velocity": velocity}
    time = tick * np.arange(len(position))
    return {name: Signal(time, values) for name, values in every.items()}
