"""Remedies: what would distinguish two models that a run of the arm as it stands cannot.

Each is computed by the same separation as the run itself: the run is made once as it is and once more with
something changed, and what the rival has learned in the first binds it in the second.
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

from ..search.unknowns import DriveGains
from .separation import Hypothesis, Observation

TILT = np.deg2rad(15.0)
"""Of the base [rad]: a quarter of the weight across, and still within what wedges under a base plate do."""
BODY = "known body"
"""Name of the run that carries the known payload."""
PAYLOAD_SHARE = 0.1
"""Mass of the known payload over that of the links: most arms carry a quarter of their own or more."""
REACH = np.array([0.05, 0.0, 0.1])
"""Its centre of mass from the flange [m]: out of the last axis, so that every joint feels it."""
RADIUS = 0.05
"""Of gyration of the known payload [m]."""
TWIST_ERROR = 0.006
"""Of a link-side encoder's reading, over the gear's twist at full torque: 20 bits are 6 microradians, and a
gear twists a milliradian."""
STIFFNESS_TOLERANCE = 0.3
"""Relative standard deviation of a gear's stiffness from its catalogue."""


class Case(NamedTuple):
    """Another run of the same motion.

    Attributes:
        name: What is changed, as "with ..." would be continued.
        hypotheses: What they are then; the first parameters are those that the hypotheses have now.
        observation: What is then seen.
    """

    name: str
    hypotheses: tuple[Hypothesis, ...]
    observation: Observation


Remedy = Callable[[Sequence[Hypothesis], Motion, Observation], Case]


def known_payload(hypotheses: Sequence[Hypothesis], motion: Motion, observation: Observation) -> Case:
    """A body whose mass, centre of mass and inertia are known; the motion may need smaller torque limits."""
    robot = hypotheses[0].model.robot
    links = sum(inertia.mass for inertia in tuple(robot.kinematics.inertias)[1:])
    mass = PAYLOAD_SHARE * links if links > 0 else 1.0  # a kilogram where the links' masses are unknown
    inertia = mass * RADIUS**2
    body = Payload(BODY, known_parameters(mass, REACH.tolist(), (inertia, 0.0, 0.0, inertia, 0.0, inertia)))
    changed = tuple(one.changed(lambda model: model + body) for one in hypotheses)
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
        return Case(name, tuple(one.changed(tilt) for one in hypotheses), observation)

    return case


def link_encoders(hypotheses: Sequence[Hypothesis], motion: Motion, observation: Observation) -> Case:
    """Encoders behind the gears.

    Beside the motor's, one shows the gear's twist, which is the torque that the gear transmits over a
    stiffness known but roughly: gravity, inertia and springs, but neither friction nor drive gain. It
    distinguishes what sits before the gear from what sits behind it, and no two causes on the same side.
    """
    full = hypotheses[0].model.robot.limits.torque
    torque = observation.seen(hypotheses[0], motion).torque * observation.noise
    peak = np.where(np.isfinite(full), full, np.max(np.abs(torque), axis=0))
    noise = np.where(peak > 0, TWIST_ERROR * peak, np.inf)  # a joint without torque shows no twist
    behind = tuple(_behind_gears(one) for one in hypotheses)
    return Case("link-side encoders", behind, replace(observation, noise=noise))


def _behind_gears(hypothesis: Hypothesis) -> Hypothesis:
    """The same parameters, in what the gears transmit, and the stiffness of every gear."""
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
    """What a gear transmits of an effect: all of it, or nothing.

    Attributes:
        effect: As the motor feels it.
    """

    effect: Effect

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
    """Relative errors of the gears' compliances: as a gain's, they scale all that is seen of a joint."""

    def parameters(self, robot: Robot) -> list[Parameter]:
        return [Parameter(f"compliance{joint + 1}", "1") for joint in range(robot.dof)]


REMEDIES: tuple[Remedy, ...] = (known_payload, tilted(0), tilted(1), link_encoders)
"""What is asked where a run does not do."""
