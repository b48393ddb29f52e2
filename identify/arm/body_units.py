"""Whether the described bodies of an arm can be real: their masses and inertias against the arm's size."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ..text_table import digits

SMALLEST = 0.5
"""Smallest length of an arm for its mass, and of half a body for its inertia [m]: a short turntable may carry
a load that is wider than the distances between its joints."""
LONGEST = 100.0
"""Length of an arm above which its lengths are in millimeters [m]: the longest cranes reach 60 m."""
WATER = 1000.0
"""Mass of an arm per cube of its length above which it is impossible [kg/m^3]: as heavy as a cube of water as
wide as the arm is long. Real arms have 4 to 300; a turntable may have more, but is not denser than metal."""
TOKEN = 0.1
"""The same ratio below which masses are tokens, as generators of descriptions write them [kg/m^3]."""
DENSEST = 22600.0
"""Density of the densest metal, osmium [kg/m^3]. No body of a mass has a smaller moment of inertia than a
sphere of that metal."""
USUAL, SPREAD = 250.0, 20.0
"""Usual density of a sphere with a link's mass and largest moment of inertia [kg/m^3], and the factor within
which the median of an arm's links is: 20 for a Panda, 1500 for a Staubli."""
UNITS = {"g m²": 1e3, "kg cm²": 1e4, "kg mm²": 1e6, "g cm²": 1e7, "g mm²": 1e9}
"""Unit in which inertias may be stated by mistake -> its numbers for 1 kg m^2."""


class Body(NamedTuple):
    """A described link."""

    link: str
    mass: float  # [kg]
    moment: float  # largest principal moment of inertia about the center of mass [kg m^2]

    @property
    def radius(self) -> float:
        """Radius of gyration [m]."""
        return float(np.sqrt(self.moment / self.mass))

    @property
    def density(self) -> float:
        """Density of the sphere with this mass and moment of inertia [kg/m^3]."""
        return float(self.mass / (4.0 / 3.0 * np.pi * (2.5 * self.moment / self.mass) ** 1.5))


class BodyUnits(NamedTuple):
    """Findings about the described bodies.

    Attributes:
        informative: Whether masses and inertias are plausible, so that they say something about the arm.
        doubts: Implausible values, one sentence each.
    """

    informative: bool
    doubts: tuple[str, ...]


def body_units(kinematics: pin.Model) -> BodyUnits:
    """Compare masses and inertias of an arm with its length and with the density of solids."""
    length, total = arm_length(kinematics), sum(body.mass for body in list(kinematics.inertias)[1:])
    if length > LONGEST:
        return BodyUnits(False, (f"an arm {digits(length, 2)} m long: lengths in millimeters?",))
    bodies, token = _bodies(kinematics, 1.0), total < TOKEN * length**3
    grams = total > WATER * max(length, SMALLEST) ** 3 and (
        kinematics.nv > 1 or any(body.density > DENSEST for body in bodies)
    )
    bodies = _bodies(kinematics, 1e-3) if grams else bodies
    wide = [body for body in bodies if body.radius > max(length, 2.0 * SMALLEST)]
    dense = [body for body in bodies if body.density > DENSEST]
    masses = f"masses of {digits(total)} kg in all, on an arm {digits(length, 2)} m long"
    doubts = [f"{masses}: in grams?"] * grams
    doubts += [f"{masses}: placeholders, which say nothing about the arm"] * (token and total > 0.0)
    doubts += _wide_words(wide, length) + _dense_words(dense)
    return BodyUnits(total > 0.0 and not (grams or token or wide), tuple(doubts))


def arm_length(kinematics: pin.Model) -> float:
    """Longest way along the joints to a center of mass, from the first joint on [m]."""
    ways = np.zeros(kinematics.njoints)
    farthest = 0.0
    for joint in range(1, kinematics.njoints):
        parent = kinematics.parents[joint]
        step = np.linalg.norm(kinematics.jointPlacements[joint].translation)
        ways[joint] = ways[parent] + (step if parent else 0.0)
        farthest = max(farthest, ways[joint] + np.linalg.norm(kinematics.inertias[joint].lever))
    return float(farthest)


def _bodies(kinematics: pin.Model, scale: float) -> list[Body]:
    """Bodies with a mass and a moment of inertia; `scale` is the factor from stated masses to kilograms."""
    links = {f.parentJoint: f.name for f in reversed(list(kinematics.frames)) if f.type == pin.FrameType.BODY}
    bodies = [
        Body(
            links.get(joint, kinematics.names[joint]),
            scale * kinematics.inertias[joint].mass,
            float(np.linalg.eigvalsh(kinematics.inertias[joint].inertia)[-1]),
        )
        for joint in range(1, kinematics.njoints)
    ]
    return [body for body in bodies if body.mass > 0.0 and body.moment > 0.0]


def _wide_words(wide: list[Body], length: float) -> list[str]:
    """A sentence on bodies whose inertia requires them to be wider than the arm is long."""
    if not wide:
        return []
    body = max(wide, key=lambda each: each.radius)
    unit = _inertia_unit(wide)
    return [
        f"link '{body.link}'{_others(wide)}: radius of gyration {digits(body.radius, 2)} m "
        f"({digits(body.moment)} kg m² at {digits(body.mass)} kg), on an arm {digits(length, 2)} m long: "
        f"inertia in {unit or 'another unit'}?"
    ]


def _inertia_unit(bodies: list[Body]) -> str:
    """Units that would make the bodies as dense as real links are; empty if none does."""
    density = float(np.median([body.density for body in bodies]))
    off = {unit: abs(np.log(density * factor**1.5 / USUAL)) for unit, factor in UNITS.items()}
    return " or ".join(unit for unit in sorted(off, key=lambda name: off[name]) if off[unit] < np.log(SPREAD))


def _dense_words(dense: list[Body]) -> list[str]:
    """A sentence on bodies whose inertia is smaller than that of solid metal."""
    if not dense:
        return []
    body = max(dense, key=lambda each: each.density)
    low = (body.density / DENSEST) ** (2.0 / 3.0)
    return [
        f"link '{body.link}'{_others(dense)}: inertia {digits(body.moment)} kg m² at {digits(body.mass)} kg, "
        f"{digits(low, 2)} times less than that of solid metal: a placeholder, or mass or inertia in another "
        "unit?"
    ]


def _others(bodies: list[Body]) -> str:
    """Words for the number of other links with the same fault."""
    return f" and {len(bodies) - 1} more" if len(bodies) > 1 else ""
