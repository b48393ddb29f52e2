"""Arms as they truly are, and what wears on some of them."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from exidyn.identification.effects import LoadDependentFriction, Prior
from exidyn.identification.effects.rigid_body import with_bodies
from exidyn.identification.model import Model
from exidyn.identification.robot_files.robot_file import read_model

LINKS, FRICTION, GAINS = 0.03, 0.2, 0.02
"""Relative deviations between units of a type of links, friction and drive gains [-]."""
SCATTER = 0.005
"""The same of friction from run to run."""
LOAD = 0.05
"""Friction over load of every joint [-]."""
BY_KELVIN = {"Fv": 0.025, "Fc": 0.004}
"""Share by which viscous and Coulomb friction fall a kelvin, the first exponentially."""
REFERENCE = 30.0
"""Temperature of the values [degC]."""
NOISE = (0.005, 0.01, 0.02)
"""Current noise over the usual current, one arm after the other [-]."""


class Wear(NamedTuple):
    """What changes on an arm.

    Attributes:
        effect: In the vocabulary.
        joint: From 1.
        parameters: That change in proportion.
        share: By how much [-], in all or, where it creeps, in `weeks`.
        weeks: In which it creeps so far; 0 for at once.
    """

    effect: str
    joint: int
    parameters: tuple[str, ...]
    share: float
    weeks: float = 0.0

    def at(self, weeks: float) -> float:
        """Share, so many weeks after it began."""
        if weeks <= 0.0:
            return 0.0
        return self.share * weeks / self.weeks if self.weeks else self.share


WORN: dict[str, tuple[Wear, ...]] = {
    "cobot": (
        Wear("coulomb_friction", 3, ("Fc3",), 0.1, 8.0),
        Wear("drive_gain", 4, ("gain4",), 0.02),
        Wear("viscous_friction", 2, ("Fv2",), 0.1),
        Wear("viscous_friction", 5, ("Fv5",), 0.1, 8.0),
        Wear("load_dependent_friction", 3, ("mu3",), 0.2),
    ),
    "kr270": (
        Wear("spring_balancer", 2, ("Kr", "K0"), -0.05),
        Wear("coulomb_friction", 2, ("Fc2",), 0.1, 8.0),
        Wear("drive_gain", 1, ("gain1",), -0.02),
        Wear("coulomb_friction", 5, ("Fc5",), 0.1),
        Wear("spring_balancer", 2, ("Kr", "K0"), -0.05, 8.0),
    ),
}
"""On the first arms of each type."""


@dataclass(frozen=True, eq=False)
class Arm:
    """One unit.

    Attributes:
        name: Of it.
        nominal: As its robot file has it.
        built: As it is, at the reference temperature.
        gain: Its drive gains, shape (n,) [N m/A].
        noise: Current noise over the usual current [-].
        wear: What changes; None for nothing.
    """

    name: str
    nominal: Model
    built: Model
    gain: np.ndarray
    noise: float
    wear: Wear | None = None

    def values(self, temperature: np.ndarray, worn: float, random: np.random.Generator) -> np.ndarray:
        """Its parameters (p,) at joint temperatures (n,) [degC], so many weeks into its wear."""
        found, warm = self.built.nominal_values.copy(), temperature - REFERENCE
        for place, name in enumerate(self.built.names):
            if name[:2] in BY_KELVIN:
                by = BY_KELVIN[name[:2]] * warm[int(name[2:]) - 1]
                found[place] *= np.exp(-by) if name[:2] == "Fv" else 1.0 - by
            if name[:2] in ("Fv", "Fc", "mu"):
                found[place] *= 1.0 + SCATTER * random.normal()
            if self.wear is not None and name in self.wear.parameters:
                found[place] *= 1.0 + self.wear.at(worn)
        return found

    def gains(self, worn: float) -> np.ndarray:
        """Its drive gains, so many weeks into its wear."""
        found = self.gain.copy()
        if self.wear is not None and self.wear.effect == "drive_gain":
            found[self.wear.joint - 1] *= 1.0 + self.wear.at(worn)
        return found


def arm(kind: str, number: int) -> Arm:
    """An arm of a type; the first ones wear."""
    random = np.random.default_rng([number, len(kind)])
    nominal = read_model(kind)
    worn = WORN[kind][number] if number < len(WORN[kind]) else None
    gain = nominal.robot.drive_gain * (1.0 + GAINS * random.normal(size=nominal.robot.dof))
    return Arm(
        f"{kind}-{number + 1:02}", nominal, _built(nominal, random), gain, NOISE[number % len(NOISE)], worn
    )


def _built(nominal: Model, random: np.random.Generator) -> Model:
    """The model with other links and friction, and friction by load, which no robot file states."""
    joints = range(1, nominal.robot.dof + 1)
    bodies = nominal.nominal_values[: 10 * nominal.robot.dof].reshape(-1, 10)
    bodies = bodies * (1.0 + LINKS * random.uniform(-1.0, 1.0, (len(bodies), 1)))
    model = replace(nominal, robot=with_bodies(nominal.robot, bodies)) + LoadDependentFriction()
    stated = {
        name: Prior(prior.value * (1.0 + FRICTION * random.uniform(-1.0, 1.0)))
        if name[:2] in ("Fv", "Fc", "Ia")
        else Prior(prior.value)
        for name, prior in nominal.stated.items()
    }
    stated |= {f"mu{joint}": Prior(LOAD * random.uniform(0.5, 1.5)) for joint in joints}
    return replace(model, stated=stated)
