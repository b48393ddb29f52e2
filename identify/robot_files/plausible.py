"""What no arm has: refused where it cannot be meant, and a warning where files that are used have it."""

import warnings
from collections.abc import Iterable, Iterator
from xml.etree.ElementTree import Element

import numpy as np

from ..effects import Effect
from ..errors import RobotError, RobotWarning
from ..model import Model
from .toml_fields import numbers

STRONGEST_GRAVITY = 30.0
"""Size of gravity under which no arm is [m/s^2]: three times the Earth's, and more than Jupiter's 24.8."""
FARTHEST_CENTER = 10.0
"""Distance of a body's centre of mass from its frame that no arm has [m]: the largest reach 5 m."""
FLAT = 0.02
"""By how much the largest principal moment may exceed the sum of the others [-]: what two digits make of a
flat plate, of which the two are equal."""


def read_gravity(value: object) -> np.ndarray:
    """Gravity in the frame of the base, shape (3,) [m/s^2].

    Raises:
        RobotError: It is no vector, or larger than that of a planet with ground to stand on.
    """
    if not isinstance(value, list | tuple):
        raise RobotError(
            f"gravity: expected a vector in the frame of the base, such as [0.0, 0.0, -9.81]; found {value!r}"
        )
    gravity = numbers(value, 3, "gravity")
    if (size := float(np.linalg.norm(gravity))) > STRONGEST_GRAVITY:
        raise RobotError(
            f"gravity: {size:g} m/s^2; an arm is under at most {STRONGEST_GRAVITY:g}. On the Earth it is 9.81"
        )
    return gravity


def check_center(mass: float, center_of_mass: np.ndarray, where: str) -> None:
    """Refuse a body whose centre of mass (3,) [m] is farther away than an arm is long.

    Raises:
        RobotError: It is.
    """
    distance = float(np.linalg.norm(center_of_mass))
    if mass > 0.0 and distance > FARTHEST_CENTER:
        raise RobotError(
            f"{where}: centre of mass {distance:g} m from its frame; in an arm it is at most "
            f"{FARTHEST_CENTER:g} m away. Is it in millimetres?"
        )


def inertia_doubt(inertia: np.ndarray, where: str) -> str:
    """Why no body has an inertia (3, 3) about its centre of mass [kg m^2]; empty where one can."""
    low, middle, high = np.linalg.eigvalsh(inertia)
    if high - low - middle <= FLAT * abs(high) and low >= -FLAT * abs(high):
        return ""
    moments = f"principal moments of inertia {low:.3g}, {middle:.3g}, {high:.3g} kg m^2"
    why = "none can be negative" if low < 0.0 else "the largest can be at most the sum of the others"
    return f"{where}: {moments}; {why}"


def check_urdf_centers(root: Element, where: str) -> None:
    """Refuse a link whose centre of mass is farther away than an arm is long, whatever is fixed to it.

    Raises:
        RobotError: There is one.
    """
    for link in root.findall("link"):
        mass, origin = link.find("inertial/mass"), link.find("inertial/origin")
        if mass is not None and origin is not None:
            center = np.array([float(word) for word in origin.get("xyz", "0 0 0").split()])
            check_center(float(mass.get("value", 0.0)), center, f"{where}: link '{link.get('name')}'")


def urdf_doubts(root: Element, where: str) -> Iterator[str]:
    """Why no body has the inertia of a link, link by link."""
    for link in root.findall("link"):
        element = link.find("inertial/inertia")
        if element is not None:
            xx, xy, xz, yy, yz, zz = (
                float(element.get(f"i{axes}", 0.0)) for axes in ("xx", "xy", "xz", "yy", "yz", "zz")
            )
            inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            if doubt := inertia_doubt(inertia, f"{where}: link '{link.get('name')}'"):
                yield doubt


def value_doubts(model: Model, where: str) -> Iterator[str]:
    """Which nominal values are below what physics allows."""
    for effect in model.effects:
        for name, unit, value, minimum in _stated(effect, model):
            if value < minimum:
                yield f"{where}: {name} = {value:g} {unit}; it is at least {minimum:g}, as {_why(effect)}"


def _stated(effect: Effect, model: Model) -> Iterator[tuple[str, str, float, float]]:
    for parameter in effect.parameters(model.robot):
        if parameter.name in model.stated:
            yield parameter.name, parameter.unit, model.stated[parameter.name].value, parameter.minimum


def _why(effect: Effect) -> str:
    friction = "friction" in type(effect).__name__.lower()
    return "friction takes energy out of a motion" if friction else "no body or spring has less"


def warn_of(doubts: Iterable[str]) -> None:
    """Warn of each, in a line."""
    for doubt in doubts:
        warnings.warn(doubt, RobotWarning, stacklevel=3)
