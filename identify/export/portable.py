"""Portable: a model in the terms that simulators share, and what they cannot represent."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arm.robot import Robot
from ..effects import (
    CoulombFriction,
    CurrentOffset,
    Effect,
    JointEffect,
    JointSpring,
    Payload,
    RigidBody,
    RotorInertia,
    SpringBalancer,
    ViscousFriction,
)
from ..effects.rigid_body import inertial_parameters
from ..errors import RobotError
from ..fit.identified import with_bodies
from ..model import Model
from .bodies import possible


@dataclass(frozen=True, eq=False)
class Joints:
    """What torque each joint takes beyond that of its bodies, each of shape (n,).

    Attributes:
        armature: Inertia of rotor and gear [kg m^2].
        damping: Torque per velocity [N m s/rad].
        dry: Torque of dry friction [N m].
        reversal: Velocity over which that reverses, by tanh [rad/s].
        stiffness: Torque per position [N m/rad].
        constant: Torque at position zero [N m].
    """

    armature: np.ndarray
    damping: np.ndarray
    dry: np.ndarray
    reversal: np.ndarray
    stiffness: np.ndarray
    constant: np.ndarray

    @classmethod
    def none(cls, joints: int) -> "Joints":
        """Nothing yet, to be added to."""
        return cls(*np.zeros((6, joints)))


@dataclass(frozen=True, eq=False)
class Portable:
    """A model sorted by what simulators can represent.

    Attributes:
        model: With bodies in its robot that can exist, the payload in the last of them.
        joints: What most simulators can represent.
        balancers: Springs between two links with their stiffness [N/m] and preload [N].
        left: Other effects and their parameters.
        remarks: What had to be changed, in sentences.
    """

    model: Model
    joints: Joints
    balancers: tuple[tuple[SpringBalancer, float, float], ...]
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
        joints, balancers, left = Joints.none(model.robot.dof), [], []
        for effect, own in shares(model):
            stiffens = isinstance(effect, JointSpring) and effect.stiffening
            if type(effect) in WORDS and not stiffens:
                WORDS[type(effect)](joints, model.robot, effect, own)
            elif isinstance(effect, SpringBalancer):
                balancers.append((effect, float(own[0]), float(own[1])))
            elif not isinstance(effect, RigidBody | Payload):
                left.append((effect, own))
        return cls(model, joints, tuple(balancers), tuple(left), remarks)


def shares(model: Model) -> list[tuple[Effect, np.ndarray]]:
    """Each effect with its nominal parameters."""
    values = model.nominal_values
    return [(effect, values[own]) for effect, own in zip(model.effects, model.columns, strict=True)]


def _solid(model: Model, payload: str) -> tuple[Model, tuple[str, ...]]:
    """The model with its bodies, and the payload, in the robot; and what had to be changed in them."""
    robot, given = model.robot, np.zeros((model.robot.dof, 10))
    for effect, own in shares(model):
        if isinstance(effect, RigidBody):
            given = given + own.reshape(robot.dof, 10)
    given[-1] += _carried(model, payload)
    largest = float(np.max(np.abs(given))) or 1.0
    bodies = np.array([possible(body, largest) for body in given])
    moved = [name for name, old, new in zip(robot.joints, given, bodies, strict=True) if np.any(old != new)]
    remarks = (f"no body can have the mass and moments of the link behind {', '.join(moved)}: moved to the "
               "nearest that one can have",) if moved else ()  # fmt: skip
    effects = tuple(e for e in model.effects if not (isinstance(e, Payload) and e.name == payload))
    bare = replace(model, effects=effects)
    stated = {n: b for n, b in model.stated.items() if n in set(bare.names) - set(_rigid_names(bare))}
    return Model(with_bodies(robot, bodies), effects, stated), remarks


def _rigid_names(model: Model) -> list[str]:
    rigid = [effect for effect in model.effects if isinstance(effect, RigidBody)]
    return [parameter.name for effect in rigid for parameter in effect.parameters(model.robot)]


def _carried(model: Model, payload: str) -> np.ndarray:
    """Ten parameters of a payload in the frame of the last link, shape (10,)."""
    if not payload:
        return np.zeros(10)
    names = [effect.name for effect in model.effects if isinstance(effect, Payload)]
    if payload not in names:
        raise RobotError(
            f"{model.robot.name}: no payload '{payload}'. Payloads of the model: {', '.join(names) or 'none'}"
        )
    for effect, own in shares(model):
        if isinstance(effect, Payload) and effect.name == payload:
            for body in effect.bodies(model.robot, own, payload).values():
                return inertial_parameters(body)
    raise RobotError(
        f"{model.robot.name}: payload '{payload}' has a mass of 0 or less; identify it, or give it"
    )


def _to(name: str) -> "Word":
    def add(joints: Joints, robot: Robot, effect: JointEffect, own: np.ndarray) -> None:
        getattr(joints, name)[effect.columns(robot)] += own

    return add


def _dry(joints: Joints, robot: Robot, effect: CoulombFriction, own: np.ndarray) -> None:
    # Simulators know one velocity at which it changes its sign: that of the larger part.
    columns = np.array(effect.columns(robot), dtype=int)
    joints.reversal[columns[own >= joints.dry[columns]]] = effect.reversal
    joints.dry[columns] += own


def _spring(joints: Joints, robot: Robot, effect: JointSpring, own: np.ndarray) -> None:
    columns = effect.columns(robot)
    joints.stiffness[columns] += own[::2]
    joints.constant[columns] += own[1::2]


Word = Callable[..., None]
WORDS: dict[type[Effect], Word] = {
    RotorInertia: _to("armature"),
    ViscousFriction: _to("damping"),
    CoulombFriction: _dry,
    CurrentOffset: _to("constant"),
    JointSpring: _spring,
}
"""Effects that act on each joint alone in a way that most simulators know: how each adds to `Joints`."""
