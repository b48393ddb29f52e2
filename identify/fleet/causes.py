"""Causes: what may change on an arm, each a direction in the space of its unknowns.

Links do not wear: their inertias stay, but for the last link's mass and first moments, which a tool changes.
"""

from typing import NamedTuple

import numpy as np

from ..arm.rigid_regressor import INERTIAL
from ..effects import Effect, name_of
from .kind import Kind


class Cause(NamedTuple):
    """Something that may change.

    Attributes:
        effect: Its name in the vocabulary of the diagnosis.
        joint: On which it acts, from 0.
        parameter: What changes.
        unit: Of the amount; empty where it is a share of the value.
        direction: Change of the unknowns of `Kind` for an amount of one, shape (m,).
        place: Of the unknown that is the value of which a change is a share; -1 where the amount is a share
            itself, or there is none.
        thermal: Whether it depends on temperature.
        plausible: Size of the amount, at most with 68 %, where nothing is stated.
    """

    effect: str
    joint: int
    parameter: str
    unit: str
    direction: np.ndarray
    place: int = -1
    thermal: bool = False
    plausible: float = np.inf

    @property
    def scatters(self) -> bool:
        """Whether it may differ from run to run: all but a tool."""
        return self.effect != "payload"


def causes(kind: Kind) -> list[Cause]:
    """All of them, joint effects first, then drive gains where currents were recorded, then a tool."""
    model, unknowns = kind.model, len(kind.names)
    found: list[Cause] = []
    for effect, own in zip(model.effects, model.columns, strict=True):
        if not effect.inertial:
            found += _of_effect(kind, effect, own)
    if kind.measures == "current":
        directions = np.eye(unknowns)[len(kind.base.kept) :]
        found += [Cause("drive_gain", joint, "gain", "", one) for joint, one in enumerate(directions)]
    return found + _tool(kind)


def _of_effect(kind: Kind, effect: Effect, own: slice) -> list[Cause]:
    """One a parameter, joint 0 where it has none; all together besides, as of a spring whose gas leaks."""
    robot, name = kind.model.robot, name_of(effect)
    parameters, joints = effect.parameters(robot), [joint or 0 for joint in effect.parameter_joints(robot)]
    found = [
        Cause(
            name,
            joint,
            parameter.name,
            parameter.unit,
            _direction(kind, own.start + k),
            _place(kind, own.start + k),
            effect.greased,
            effect.plausible,
        )
        for k, (parameter, joint) in enumerate(zip(parameters, joints, strict=True))
        if np.any(kind.base.regrouping[:, own.start + k])
    ]
    if effect.together:
        values = kind.model.nominal_values[own]
        whole = sum(value * _direction(kind, own.start + k) for k, value in enumerate(values))
        found.append(Cause(name, joints[0], effect.together, "", np.asarray(whole)))
    return found


def _tool(kind: Kind) -> list[Cause]:
    """What a tool adds: mass and first moments of the last link."""
    last = kind.model.inertias[-1].start
    joint, units = kind.model.robot.dof - 1, {"M": "kg"}
    return [
        Cause("payload", joint, name, units.get(name, "kg m"), _direction(kind, last + INERTIAL.index(name)))
        for name in ("M", "MX", "MY", "MZ")
        if np.any(kind.base.regrouping[:, last + INERTIAL.index(name)])
    ]


def _direction(kind: Kind, column: int) -> np.ndarray:
    return np.pad(kind.base.regrouping[:, column], (0, kind.model.robot.dof))


def _place(kind: Kind, column: int) -> int:
    """Where a parameter is an unknown by itself, or with others regrouped into it; -1 where it is not."""
    [place] = [*np.flatnonzero(kind.base.kept == column), -1][:1]
    return int(place)
