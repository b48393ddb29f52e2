r"""`Portable`: a model in the terms that simulators share.

Simulators accept only physically consistent bodies, so inconsistent parameters are moved to the nearest
consistent ones. About the center of mass, :math:`\Sigma = \tfrac12 \mathrm{tr}(I) E - I` is the second moment
of the mass and therefore positive definite: the triangle inequality of the principal moments of inertia.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..arm.robot import Robot, ServoLaw
from ..effects import Effect
from ..effects.effect import JointEffect
from ..effects.rigid_body import inertial_parameters, with_bodies
from ..effects.simulator_terms import JointTerms, Spring
from ..errors import RobotError
from ..fit.estimators.consistent import of_pseudo_inertia, pseudo_inertia
from ..model import Model

Pair = tuple[Effect, np.ndarray]
"""An effect and its parameters (p,)."""


@dataclass(frozen=True, eq=False)
class Portable:
    """A model sorted by what simulators can represent."""

    # Model with physically consistent bodies in its robot, including the payload in the last link.
    model: Model
    joints: JointTerms  # joint terms that most simulators can represent
    balancers: tuple[Spring, ...]  # springs between two links
    others: tuple[Pair, ...]  # other effects with their parameters
    remarks: tuple[str, ...]  # sentences on changes that were necessary
    servos: ServoLaw | None = None  # law of the joints' position servos; None if there are none

    @property
    def robot(self) -> Robot:
        """Robot of the model, with kinematics, bodies and limits."""
        return self.model.robot

    @property
    def law(self) -> ServoLaw:
        """Law of the position servos; without torque or delay if there are none."""
        none = np.zeros(self.robot.dof)
        return ServoLaw.of(none, none, none + np.inf, none) if self.servos is None else self.servos

    @property
    def torque_limit(self) -> np.ndarray:
        """Largest torque of each joint's motor, shape (n,) [N m]; infinite if there is none."""
        return np.minimum(self.robot.limits.torque, self.law.limit)

    @classmethod
    def of(cls, model: Model, payload: str = "", servos: ServoLaw | None = None) -> "Portable":
        """Sort a model at its nominal values, with the named payload as part of the last link."""
        model, remarks = _solid(model, payload)
        joints, balancers, others = JointTerms.of(model.robot.dof), [], []
        for effect, values in model.shares(model.nominal_values):
            form = effect.portable(model.robot, values)
            if isinstance(form, JointTerms):
                joints = joints + form
            elif isinstance(form, Spring):
                balancers.append(form)
            elif not (effect.of_links or effect.payload):
                others.append((effect, values))
        law = robot_law(model.robot, model.robot.drive_gain) if servos is None else servos
        return cls(model, joints, tuple(balancers), tuple(others), remarks, law)

    def joint_effects(self, kind: type[JointEffect], place: int) -> list[Pair]:
        """Effects of a kind on one joint, each split off from those on other joints."""
        return [
            pair
            for effect, values in self.others
            if isinstance(effect, kind)
            for pair in self._apart(effect, values)
            if pair[0].parameter_joints(self.robot)[0] == place
        ]

    def without_effect(self, part: Effect, values_of_part: np.ndarray) -> "Portable":
        """The model in which one part of an effect has other values (p,); without it if they are zero."""
        others: list[Pair] = []
        for effect, values in self.others:
            pieces = self._apart(effect, values) if type(effect) is type(part) else []
            if part not in [piece for piece, _ in pieces]:
                others.append((effect, values))
                continue
            pieces = [(piece, values_of_part if piece == part else share) for piece, share in pieces]
            others += [(piece, share) for piece, share in pieces if np.any(share)]
        return replace(self, others=tuple(others))

    def _apart(self, effect: Effect, values: np.ndarray) -> list[Pair]:
        parts = effect.apart(self.robot)
        return list(zip(parts, np.split(values, len(parts)), strict=True))


def robot_law(robot: Robot, drive_gain: np.ndarray) -> ServoLaw | None:
    """Law of a robot's position servos at drive gains (n,) [N m/A]; None without servos.

    Their damping is part of the viscous friction.
    """
    if robot.servo is None:
        return None
    gain, none = np.abs(drive_gain), np.zeros(robot.dof)
    return ServoLaw.of(gain * robot.servo.gain, none, gain * robot.servo.limit, none)


def _solid(model: Model, payload: str) -> tuple[Model, tuple[str, ...]]:
    """Model with consistent bodies and the payload in its robot, and remarks on changed bodies."""
    robot, nominal = model.robot, np.zeros((model.robot.dof, 10))
    for effect, values in model.shares(model.nominal_values):
        if effect.of_links:
            nominal = nominal + values.reshape(robot.dof, 10)
    nominal[-1] += _carried(model, payload)
    largest = float(np.max(np.abs(nominal))) or 1.0
    bodies = np.array([possible(body, largest) for body in nominal])
    moved = [name for name, old, new in zip(robot.joints, nominal, bodies, strict=True) if np.any(old != new)]
    remarks = (f"mass and moments of the link behind {', '.join(moved)} are physically inconsistent: "
               "replaced by the nearest consistent ones",) if moved else ()  # fmt: skip
    effects = tuple(e for e in model.effects if not payload or e.payload != payload)
    names = [p.name for effect in effects if not effect.of_links for p in effect.parameters(robot)]
    stated = {name: prior for name, prior in model.stated.items() if name in names}
    solid = Model(with_bodies(robot, bodies), effects, stated, measurements=model.measurements)
    return solid, remarks


def _carried(model: Model, payload: str) -> np.ndarray:
    """Ten parameters of a payload in the frame of the last link, shape (10,)."""
    if not payload:
        return np.zeros(10)
    if payload not in model.payloads:
        names = ", ".join(model.payloads) or "none"
        raise RobotError(f"{model.robot.name}: no payload '{payload}'. Payloads of the model: {names}")
    [shares] = [values for effect, values in model.shares(model.nominal_values) if effect.payload == payload]
    for body in model.payloads[payload].bodies(model.robot, shares, payload).values():
        return inertial_parameters(body)
    raise RobotError(
        f"{model.robot.name}: payload '{payload}' has a mass of 0 or less; identify or state its mass"
    )


NOTHING = 1e-6
"""Smallest mass of a link, relative to the largest parameter of the arm's bodies."""
EXTENT = 1e-3
"""Minimum rms distance of the mass from its center in each direction [m]; values identified under physical
consistency satisfy it."""
ENOUGH = 0.5
"""Share of the smallest mass and moment above which a body is not changed. A body at the limit is computed
again with rounding errors that differ between processors: cancellation about the center of mass leaves about
machine precision times the largest moment, a billionth of the smallest moment of usual links. Half is far
from that, and simulators still accept such a body."""


def possible(values: np.ndarray, largest: float) -> np.ndarray:
    """Nearest ten parameters of a body with mass and extent in all directions; unchanged if they are valid.

    Mass and center are kept unless there is no mass. Second moments that are too small are raised, with the
    smallest sum of squared changes. `largest` is the largest parameter of all bodies of the arm.
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
