"""Remedies: changes to the setup that distinguish two models if no run of the unchanged arm can.

Each is evaluated by the same separation as the run itself: the run is made once as planned and once with the
change, and the rival's parameters from the first constrain it in the second.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from exidyn.identification.arm.motion import Motion
from exidyn.identification.arm.robot import Robot
from exidyn.identification.effects import Effect, Parameter, Payload, Prior, known_parameters
from exidyn.identification.model import Model

from ..search.experiment import DriveGains
from .separation import Hypothesis, Observation

TILT = np.deg2rad(15.0)
"""Tilt of the base [rad]: a quarter of the weight acts across, and wedges under a base plate suffice."""
BODY = "known body"
"""Name of the run that carries the known payload."""
PAYLOAD_SHARE = 0.1
"""Mass of the known payload over that of the links: most arms can carry a quarter of their mass or more."""
REACH = np.array([0.05, 0.0, 0.1])
"""Center of mass of the known payload from the flange [m]: off the last axis, to load every joint."""
RADIUS = 0.05
"""Radius of gyration of the known payload [m]."""
TWIST_ERROR = 0.006
"""Error of a link-side encoder over the gear's twist at full torque: 20 bit are 6 microradians, and a gear
twists by a milliradian."""
STIFFNESS_TOLERANCE = 0.3
"""Relative standard deviation of a gear's stiffness from its catalogue."""


class Case(NamedTuple):
    """Another run of the same motion."""

    name: str  # name of the change, to follow "with"
    # Hypotheses with the change; their first parameters are those of the unchanged hypotheses.
    hypotheses: tuple[Hypothesis, ...]
    observation: Observation  # observation with the change


Remedy = Callable[[Sequence[Hypothesis], Motion, Observation], Case]


def known_payload(hypotheses: Sequence[Hypothesis], motion: Motion, observation: Observation) -> Case:
    """A payload of known mass, center of mass and inertia; the motion may then exceed torque limits."""
    robot = hypotheses[0].model.robot
    links = sum(inertia.mass for inertia in tuple(robot.kinematics.inertias)[1:])
    mass = PAYLOAD_SHARE * links if links > 0 else 1.0  # a kilogram where the links' masses are unknown
    inertia = mass * RADIUS**2
    body = Payload(BODY, known_parameters(mass, REACH.tolist(), (inertia, 0.0, 0.0, inertia, 0.0, inertia)))
    changed = tuple(hypothesis.changed(lambda model: model + body) for hypothesis in hypotheses)
    return Case(f"a known payload of {mass:.3g} kg", changed, replace(observation, payloads=(BODY,)))


def tilted(axis: int) -> Remedy:
    """The base tilted about its x (0) or y (1) axis."""

    def case(hypotheses: Sequence[Hypothesis], motion: Motion, observation: Observation) -> Case:
        def tilt(model: Model) -> Model:
            kinematics = model.robot.kinematics.copy()
            turn = pin.exp3(-TILT * np.eye(3)[axis])
            kinematics.gravity.linear = turn @ kinematics.gravity.linear
            return replace(model, robot=replace(model.robot, kinematics=kinematics))

        name = f"the base tilted by {np.rad2deg(TILT):.0f} degrees about {'xyz'[axis]}"
        return Case(name, tuple(hypothesis.changed(tilt) for hypothesis in hypotheses), observation)

    return case


def link_encoders(hypotheses: Sequence[Hypothesis], motion: Motion, observation: Observation) -> Case:
    """Encoders behind the gears.

    Together with the motor encoder, a link-side encoder measures the gear's twist, which is the transmitted
    torque over a roughly known stiffness. It contains gravity, inertia and springs, but neither friction nor
    drive gain. So it distinguishes causes on the motor side from causes on the link side, but not two causes
    on the same side.
    """
    full = hypotheses[0].model.robot.limits.torque
    torque = observation.seen(hypotheses[0], motion).torque * observation.noise
    peak = np.where(np.isfinite(full), full, np.max(np.abs(torque), axis=0))
    noise = np.where(peak > 0, TWIST_ERROR * peak, np.inf)  # a joint without torque shows no twist
    behind = tuple(_behind_gears(hypothesis) for hypothesis in hypotheses)
    return Case("link-side encoders", behind, replace(observation, noise=noise))


def _behind_gears(hypothesis: Hypothesis) -> Hypothesis:
    """The hypothesis in terms of transmitted torque, with the compliance of every gear as a parameter."""
    model, count = hypothesis.model, len(hypothesis.values)
    held = {name: Prior(value) for name, value in zip(model.names, hypothesis.values, strict=True)}
    behind = replace(model, effects=tuple(BehindGear(effect) for effect in model.effects), stated=held)
    joints = model.robot.dof
    precision = np.zeros((count + joints, count + joints))
    precision[:count, :count] = hypothesis.precision
    precision[count:, count:] = np.eye(joints) * STIFFNESS_TOLERANCE**-2
    values = np.append(hypothesis.values, np.zeros(joints))
    return Hypothesis(hypothesis.name, behind + Compliances(behind), values, precision)


@dataclass(frozen=True)
class BehindGear(Effect):
    """The part of an effect that a gear transmits: all of it, or nothing."""

    effect: Effect  # the effect on the motor side

    def parameters(self, robot: Robot) -> list[Parameter]:
        return self.effect.parameters(robot)

    def regressor(self, robot: Robot, motion: Motion) -> np.ndarray:
        if self.effect.transmitted:
            return self.effect.regressor(robot, motion)
        return np.zeros((*motion.position.shape, len(self.parameters(robot))))

    def known_torque(self, robot: Robot, motion: Motion) -> np.ndarray:
        if self.effect.transmitted:
            return self.effect.known_torque(robot, motion)
        return np.zeros_like(motion.position)


@dataclass(frozen=True, eq=False)
class Compliances(DriveGains):
    """Relative errors of the gear compliances; like gain errors, they scale a joint's observed torque."""

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter(f"compliance{joint + 1}", "1") for joint in range(robot.dof)]


REMEDIES: tuple[Remedy, ...] = (known_payload, tilted(0), tilted(1), link_encoders)
"""Remedies that are evaluated if a run does not distinguish a pair."""
