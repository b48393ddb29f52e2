"""Rigid bodies of a model apart from its other effects: Pinocchio computes their torque in microseconds."""

import numpy as np
import pinocchio as pin

from ...effects import Effect
from ...errors import WrongShape
from ...model import Model


def bodies_apart(
    model: Model, values: np.ndarray, payload: str
) -> tuple[pin.Model, list[tuple[Effect, np.ndarray]]]:
    """The joints with the bodies that parameters (p,) give them, and all effects of another kind.

    Args:
        model: Robot and effects.
        values: Its parameters, shape (p,).
        payload: Name of the body that is carried; empty for none.

    Returns:
        Joints and bodies; each of the other effects with its own parameters.

    Raises:
        WrongShape: Not a value a parameter.
    """
    kinematics, others = _bodiless(model.robot.kinematics), []
    values = np.asarray(values, float)
    if values.shape != (len(model.parameters),):
        raise WrongShape(
            f"{model.robot.name}: values have shape {values.shape}, expected ({len(model.parameters)},), one "
            "a parameter of the model"
        )
    for effect, own in model.shares(values):
        bodies = effect.bodies(model.robot, own, payload)
        for link, body in bodies.items():
            kinematics.inertias[link + 1] += body
        if not bodies:
            others.append((effect, own))
    return kinematics, others


def _bodiless(kinematics: pin.Model) -> pin.Model:
    """The same joints without any inertia."""
    bare = kinematics.copy()
    for link in range(bare.njoints):
        bare.inertias[link] = pin.Inertia.Zero()
    bare.armature = np.zeros(bare.nv)
    return bare
