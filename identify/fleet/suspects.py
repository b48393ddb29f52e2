"""Suspects: what may have happened to an arm, each with all that it changes at once.

A bearing changes one parameter, a gear all friction of its joint, a tool ten parameters of the last link, and
another arm under the same name everything. They compete in one model: a suspect that changes more has to
explain more, by the factor that its prior loses (Occam's).
"""

from typing import NamedTuple

import numpy as np

from .kind import Cause
from .learned import Learned
from .runs import UNITS_DIFFER

GEAR, TOOL, EXCHANGE = "gear", "tool", "exchange"
CARRIES = 0.1
"""Mass that an arm carries over its own, usually: payloads are 5 % to 30 % of the masses of arms [-]."""
DENSITY = 1000.0
"""Of a tool with its cavities, about that of water [kg/m^3]; its size and its distance follow from it."""


class Suspect(NamedTuple):
    """What may have happened.

    Attributes:
        name: `GEAR`, `TOOL`, `EXCHANGE`; empty for a single cause.
        causes: Places of the causes that change, shape (k,); none where the whole arm is another.
        columns: Change of the unknowns, in the frame's units, for an amount of one of each, shape (k, m).
        std: Usual size of the amounts, shape (k,).
        steps_only: Whether it does not creep: nobody screws on a tool for weeks.
    """

    name: str
    causes: tuple[int, ...]
    columns: np.ndarray
    std: np.ndarray
    steps_only: bool = False


def suspects(learned: Learned) -> list[Suspect]:
    """All: single causes, gears, a tool, another arm."""
    frame = learned.frame
    wearing = [k for k, one in enumerate(frame.causes) if one.wears]
    usual = _usual(learned)
    found = [_suspect(learned, "", [k], usual[[k]]) for k in wearing]
    for joint in range(frame.kind.model.robot.dof):
        here = [k for k in wearing if frame.causes[k].joint == joint and frame.causes[k].thermal]
        if len(here) > 1:
            found.append(_suspect(learned, GEAR, here, usual[here]))
    tool = [k for k, one in enumerate(frame.causes) if one.effect == "payload"]
    if tool:
        std = np.array([_of_a_tool(frame.causes[k], _mass(learned)) for k in tool])
        found.append(_suspect(learned, TOOL, tool, std, steps_only=True))
    apart = np.sqrt(2.0 * learned.units.variance[: len(frame.scale)])  # one unit over another
    return [*found, Suspect(EXCHANGE, (), np.eye(len(apart)), apart, True)]


def _suspect(
    learned: Learned, name: str, places: list[int], std: np.ndarray, steps_only: bool = False
) -> Suspect:
    return Suspect(name, tuple(places), learned.frame.directions[places], std, steps_only)


def _usual(learned: Learned) -> np.ndarray:
    """Amount of each cause that is no surprise: what units differ by, or a third of friction if more."""
    frame = learned.frame
    variance = learned.units.variance[: len(frame.scale)]
    found = 1.0 / np.sqrt(np.sum(frame.directions**2 / variance, axis=1))
    sizes = frame.sizes(learned.units.mean[: len(frame.scale)])
    thermal = list(frame.thermal)
    found[thermal] = np.maximum(found[thermal], UNITS_DIFFER * sizes[thermal])
    return found


def _mass(learned: Learned) -> float:
    """Of what such an arm carries [kg]."""
    model = learned.frame.kind.model
    names = [name for own in model.inertias for name in model.names[own]]
    values = [value for own in model.inertias for value in model.nominal_values[own]]
    return CARRIES * sum(v for n, v in zip(names, values, strict=True) if n.rstrip("0123456789") == "M")


def _of_a_tool(cause: Cause, mass: float) -> float:
    """Usual size of a tool's parameter, whose centre is as far from the flange as it is large."""
    size = np.cbrt(mass / DENSITY)
    return float(mass * size ** {"M": 0, "MX": 1, "MY": 1, "MZ": 1}.get(cause.parameter, 2))
