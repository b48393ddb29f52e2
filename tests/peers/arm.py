"""The arm that the peers move: a simulated one, with drives and sensors."""

import numpy as np

from exidyn.identification.robot_files.robot_file import read_model
from exidyn.identification.simulation.plant import Plant, typical_plant


def make_plant(robot="cobot", start=None, seed=0, payload="") -> Plant:
    """A simulated arm of a built-in robot or a robot file, in the middle of its range by default."""
    model = read_model(robot)
    if start is None:
        lower, upper = model.robot.limits.position_lower, model.robot.limits.position_upper
        start = 0.5 * (np.maximum(lower, -np.pi) + np.minimum(upper, np.pi))
    return typical_plant(model, np.asarray(start, float), seed=seed, payload=payload)
