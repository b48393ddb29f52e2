r"""Portable: a model in the terms that simulators share, and what they cannot represent.

They accept bodies only that can exist: ten parameters are moved, where they must be, to those of one. About
the centre of mass, :math:`\Sigma = \tfrac12 \mathrm{tr}(I) E - I` is the second moment of the mass, and so
positive definite; that is the triangle inequality of the principal moments of inertia.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..arm.robot import Robot
from ..effects import Effect
from ..effects.rigid_body import inertial_parameters, with_bodies
from ..effects.simulator_terms import JointTerms, Spring
from ..errors import RobotError
from ..fit.estimators.consistent import of_pseudo_inertia, pseudo_inertia
from ..model import Model


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


NOTHING = 1e-6
"""Least mass over the largest parameter of the arm's bodies: a link that is hardly there."""
EXTENT = 1e-3
"""Root mean square distance of the mass from its centre, in each direction, at least [m]; what is identified
under physical consistency has as much."""
ENOUGH = 0.5
"""Share of the least mass and of the least moment that is left alone. What was moved to the least is computed
again with rounding, which differs between processors: cancellation about the centre of mass leaves about
machine precision times the largest moment, a billionth of the least moment of usual links. Half is far from
that, and a body with half the least is still one that simulators accept."""


def possible(values: np.ndarray, largest: float) -> np.ndarray:
    """Ten parameters of a body with mass and extent in all directions; unchanged if they are that already.

    Mass and its centre are kept, unless there is no mass; second moments that are too small are raised, the
    least change in their sum of squares.

    Args:
        values: In `INERTIAL` order, shape (10,).
        largest: Of all parameters of the arm's bodies.
    """
    pseudo, nothing = pseudo_inertia(values), NOTHING * largest
    if pseudo[3, 3] < ENOUGH * nothing:
        pseudo = np.diag([0.0, 0.0, 0.0, nothing])
    around = np.outer(pseudo[:3, 3], pseudo[:3, 3]) / pseudo[3, 3]
    moments, axes = np.linalg.eigh(pseudo[:3, :3] - around)
    least = EXTENT**2 * pseudo[3, 3]
    if values[9] >= ENOUGH * nothing and moments[0] >= ENOUGH * least:
        return values
    pseudo[:3, :3] = (axes * np.maximum(moments, least)) @ axes.T + around
    return of_pseudo_inertia(pseudo)
