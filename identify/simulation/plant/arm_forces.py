"""What all effects of a model ask for, in the plant's coordinates.

Rigid bodies are left to Pinocchio, which takes microseconds; all others are asked for their columns. What
passes through the gears acts on the links, the rest on the motors.
"""

import numpy as np
import pinocchio as pin

from ...effects import Effect
from ...errors import WrongShape
from ...model import Model
from .effect_sum import EffectSum, Joints
from .gears import Transmission
from .steps import Forces


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


class ArmForces:
    """The sum of a model's effects, for one state after the other.

    Args:
        model: The arm as it is.
        values: Its parameters, shape (p,).
        payload: Name of the body that is carried; empty for none.
        transmission: What is between motors and links.
    """

    def __init__(self, model: Model, values: np.ndarray, payload: str, transmission: Transmission) -> None:
        self._rigid = len(transmission.elastic) == 0
        self._links, self._motors = transmission.links, transmission.motors
        self._kinematics, others = bodies_apart(model, values, payload)
        groups: dict[bool, list[tuple[Effect, np.ndarray]]] = {True: [], False: []}
        for effect, own in others:
            groups[effect.transmitted].append((effect, own))
        self._data = self._kinematics.createData()
        self._on_links, self._on_motors = (EffectSum(model.robot, groups[t], payload) for t in (True, False))
        self.loaded = any(effect.needs_load for effect, _ in groups[False])
        self._none, self._massless = np.zeros(model.robot.dof), np.zeros((model.robot.dof,) * 2)
        self.friction = self._none

    def at(self, state: Joints, later: np.ndarray, temperature: np.ndarray) -> tuple[Forces, np.ndarray]:
        """Forces in a state, and inertia (x, x) [kg m^2] somewhat later.

        Sets `friction`, the torque on the motors' side of the gears, shape (n,) [N m].

        Args:
            state: In the plant's coordinates; its acceleration matters to the load of the gears only.
            later: Where the inertia is wanted, shape (x,) [rad].
            temperature: Shape (n,) [degC].
        """
        if self._rigid:
            force, slope, inertia, load = self._link_side(state, later, temperature)
            self.friction, steep, mass = self._motor_side(state, later, load, temperature)
            return Forces(force + self.friction, slope + steep, state.velocity), inertia + mass
        links, motors = self._links, self._motors
        link, motor = (Joints(*(side @ one for one in state)) for side in (links, motors))
        force, slope, inertia, load = self._link_side(link, links @ later, temperature)
        self.friction, steep, mass = self._motor_side(motor, motors @ later, load, temperature)
        force, slope = links.T @ force + motors.T @ self.friction, links.T @ slope + motors.T @ steep
        return Forces(force, slope, state.velocity), links.T @ inertia @ links + motors.T @ mass @ motors

    def holding(
        self, links: np.ndarray, motors: np.ndarray, temperature: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Torque on links and on motors that it takes to stand there, each (n,) [N m]."""
        none = self._none
        load = self._link_side(Joints(links, none, none), links, temperature)[0]
        return load, self._motor_side(Joints(motors, none, none), motors, load, temperature)[0]

    def remember(self, position: np.ndarray) -> None:
        """Go on to a position (x,) [rad], in what has a memory: where the arm has really come to."""
        for side, where in ((self._on_links, self._links), (self._on_motors, self._motors)):
            if not side.forgets:
                side.remember(where @ position)

    def _link_side(
        self, link: Joints, later: np.ndarray, temperature: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
        """Torque, slope and inertia of what the gears carry, and their load where it is needed."""
        inertia, slope = pin.crba(self._kinematics, self._data, later), self._none
        force = pin.nonLinearEffects(self._kinematics, self._data, link.position, link.velocity)
        if not self._on_links.empty:
            more, slope, mass = self._on_links.at(link, later, None, temperature)
            force, inertia = force + more, inertia + mass
        return force, slope, inertia, force + inertia @ link.acceleration if self.loaded else None

    def _motor_side(
        self, motor: Joints, later: np.ndarray, load: np.ndarray | None, temperature: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if self._on_motors.empty:
            return self._none, self._none, self._massless
        return self._on_motors.at(motor, later, load, temperature)
