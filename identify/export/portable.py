"""Portable: a model in the terms that simulators share, and what they cannot represent."""

from dataclasses import dataclass, replace

import numpy as np

from ..arm.robot import Robot
from ..effects import Effect
from ..effects.rigid_body import inertial_parameters, with_bodies
from ..effects.simulator_terms import JointTerms, Spring
from ..errors import RobotError
from ..model import Model
from .bodies import possible


@dataclass(frozen=True, eq=False)
class Portable:
    """A model sorted by what simulators can represent.

    Attributes:
        model: With bodies in its robot that can exist, the payload in the last of them.
        joints: What most simulators can represent.
        balancers: Springs between two links.
        left: Other effects and their parameters.
        remarks: What had to be changed, in sentences.
    """

    model: Model
    joints: JointTerms
    balancers: tuple[Spring, ...]
    left: tuple[tuple[Effect, np.ndarray], ...]
    remarks: tuple[str, ...]

    @property
    def robot(self) -> Robot:
        """Its kinematics, bodies and limits."""
        return self.model.robot

    @classmethod
    def of(cls, model: Model, payload: str = "") -> "Portable":
        """Sort a model at its nominal values.

        Args:
            model: Robot, effects and priors.
            payload: Name of the body on the flange that becomes part of the last link; empty for none.

        Raises:
            RobotError: No such payload in the model, or one that is no body.
        """
        model, remarks = _solid(model, payload)
        joints, balancers, left = JointTerms.of(model.robot.dof), [], []
        for effect, own in model.shares(model.nominal_values):
            form = effect.portable(model.robot, own)
            if isinstance(form, JointTerms):
                joints = joints + form
            elif isinstance(form, Spring):
                balancers.append(form)
            elif not (effect.of_links or effect.payload):
                left.append((effect, own))
        return cls(model, joints, tuple(balancers), tuple(left), remarks)


def _solid(model: Model, payload: str) -> tuple[Model, tuple[str, ...]]:
    """The model with its bodies, and the payload, in the robot; and what had to be changed in them."""
    robot, given = model.robot, np.zeros((model.robot.dof, 10))
    for effect, own in model.shares(model.nominal_values):
        if effect.of_links:
            given = given + own.reshape(robot.dof, 10)
    given[-1] += _carried(model, payload)
    largest = float(np.max(np.abs(given))) or 1.0
    bodies = np.array([possible(body, largest) for body in given])
    moved = [name for name, old, new in zip(robot.joints, given, bodies, strict=True) if np.any(old != new)]
    remarks = (f"no body can have the mass and moments of the link behind {', '.join(moved)}: moved to the "
               "nearest that one can have",) if moved else ()  # fmt: skip
    effects = tuple(e for e in model.effects if not payload or e.payload != payload)
    bare = replace(model, effects=effects)
    stated = {n: b for n, b in model.stated.items() if n in set(bare.names) - set(_rigid_names(bare))}
    return Model(with_bodies(robot, bodies), effects, stated), remarks


def _rigid_names(model: Model) -> list[str]:
    rigid = [effect for effect in model.effects if effect.of_links]
    return [parameter.name for effect in rigid for parameter in effect.parameters(model.robot)]


def _carried(model: Model, payload: str) -> np.ndarray:
    """Ten parameters of a payload in the frame of the last link, shape (10,)."""
    if not payload:
        return np.zeros(10)
    if payload not in model.payloads:
        names = ", ".join(model.payloads) or "none"
        raise RobotError(f"{model.robot.name}: no payload '{payload}'. Payloads of the model: {names}")
    for effect, own in model.shares(model.nominal_values):
        if effect.payload == payload:
            for body in effect.bodies(model.robot, own, payload).values():
                return inertial_parameters(body)
    raise RobotError(
        f"{model.robot.name}: payload '{payload}' has a mass of 0 or less; identify it, or give it"
    )
