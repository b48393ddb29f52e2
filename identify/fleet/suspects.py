"""Suspects: possible events on an arm, each with all parameters that it changes at once.

A bearing changes one parameter, a gear all friction of its joint, a tool ten parameters of the last link, and
another arm under the same name changes everything. They compete in one model: a suspect that changes more
parameters has to explain more, by the Occam factor of its prior.
"""

from typing import NamedTuple

import numpy as np

from .kind import Cause
from .learned import Learned
from .runs import UNITS_DIFFER

GEAR, TOOL, EXCHANGE = "gear", "tool", "exchange"
CARRIES = 0.1
"""Typical payload relative to the mass of the arm: payloads are 5 % to 30 % [-]."""
DENSITY = 1000.0
"""Density of a tool including cavities, about that of water [kg/m^3]; it determines size and distance."""


class Suspect(NamedTuple):
    """A possible event.

    Attributes:
        name: `GEAR`, `TOOL` or `EXCHANGE`; empty for a single cause.
        causes: Indices of the k causes that change; empty for an exchange of the whole arm.
        columns: Change of the unknowns in the frame's units for an amount of one of each, shape (k, m).
        std: Prior standard deviation of the amounts, shape (k,).
        steps_only: Whether it cannot creep, as the exchange of a tool.
    """

    name: str
    causes: tuple[int, ...]
    columns: np.ndarray
    std: np.ndarray
    steps_only: bool = False


def suspects(learned: Learned) -> list[Suspect]:
    """All suspects: single causes, gears, a tool, another arm."""
    frame = learned.frame
    wearing = [k for k, cause in enumerate(frame.causes) if cause.wears]
    stds = _typical_amounts(learned)
    candidates = [_suspect(learned, "", [k], stds[[k]]) for k in wearing]
    for joint in range(frame.kind.model.robot.dof):
        here = [k for k in wearing if frame.causes[k].joint == joint and frame.causes[k].thermal]
        if len(here) > 1:
            candidates.append(_suspect(learned, GEAR, here, stds[here]))
    tool = [k for k, cause in enumerate(frame.causes) if cause.effect == "payload"]
    if tool:
        std = np.array([_typical_tool(frame.causes[k], _typical_payload(learned)) for k in tool])
        candidates.append(_suspect(learned, TOOL, tool, std, steps_only=True))
    between_units = np.sqrt(2.0 * learned.units.variance[: len(frame.scale)])
    return [*candidates, Suspect(EXCHANGE, (), np.eye(len(between_units)), between_units, True)]


def _suspect(
    learned: Learned, name: str, causes: list[int], std: np.ndarray, steps_only: bool = False
) -> Suspect:
    return Suspect(name, tuple(causes), learned.frame.directions[causes], std, steps_only)


def _typical_amounts(learned: Learned) -> np.ndarray:
    """Typical amount of each cause: the spread between units, or a third of friction if that is more."""
    frame = learned.frame
    variance = learned.units.variance[: len(frame.scale)]
    amounts = 1.0 / np.sqrt(np.sum(frame.directions**2 / variance, axis=1))
    sizes = frame.sizes(learned.units.mean[: len(frame.scale)])
    thermal = list(frame.thermal)
    amounts[thermal] = np.maximum(amounts[thermal], UNITS_DIFFER * sizes[thermal])
    return amounts


def _typical_payload(learned: Learned) -> float:
    """Typical mass of a payload of such an arm [kg]."""
    model = learned.frame.kind.model
    names = [name for columns in model.inertias for name in model.names[columns]]
    values = [value for columns in model.inertias for value in model.nominal_values[columns]]
    masses = [value for name, value in zip(names, values, strict=True) if name.rstrip("0123456789") == "M"]
    return CARRIES * sum(masses)


def _typical_tool(cause: Cause, mass: float) -> float:
    """Typical value of a tool's parameter, whose center is as far from the flange as the tool is large."""
    size = np.cbrt(mass / DENSITY)
    return float(mass * size ** {"M": 0, "MX": 1, "MY": 1, "MZ": 1}.get(cause.parameter, 2))
