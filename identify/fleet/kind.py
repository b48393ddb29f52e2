"""Kind: a type of arm, by what its runs are reduced so that they can be compared, and what may change on it.

Each cause of a change is a direction in the space of the arm's unknowns. Links do not wear: their inertias
stay, but for the last link's, which a tool changes.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple
from zlib import crc32

import numpy as np

from ..arm.rigid_regressor import INERTIAL
from ..effects import Effect, LoadDependentFriction, name_of
from ..file_names import file_stem
from ..fit.base_parameters import BaseParameters, base_parameters
from ..model import Model
from ..preparation.prepare import Filtering, choose
from ..recordings.recording import Recording


@dataclass(frozen=True, eq=False)
class Kind:
    """One type of arm.

    Unknowns of an arm are its b base parameters, then the logarithms of n drive gains over the nominal ones,
    m = b + n together.

    Attributes:
        model: As `fleet_model` gives it.
        filtering: Filters of all runs, nothing left open.
        measures: "current" or "torque".
    """

    model: Model
    filtering: Filtering
    measures: str

    @classmethod
    def of(cls, recording: Recording) -> "Kind":
        """The type that a recording is of, filters chosen from it.

        Raises:
            RecordingError: Too short to choose filters from.
        """
        model = fleet_model(recording.model)
        return cls(model, choose(replace(recording, model=model), Filtering()), measures_of(recording))

    @cached_property
    def base(self) -> BaseParameters:
        """Its base parameters."""
        return base_parameters(self.model)

    @property
    def body(self) -> np.ndarray:
        """What the ten parameters of a body on the flange change in the base parameters, shape (b, 10)."""
        return self.base.regrouping[:, self.model.inertias[-1]]

    @cached_property
    def gain(self) -> np.ndarray:
        """Nominal torque per unit of what was measured, shape (n,)."""
        robot = self.model.robot
        return np.ones(robot.dof) if self.measures == "torque" else robot.drive_gain

    @property
    def names(self) -> list[str]:
        """Unknowns of an arm, in order, m names."""
        return [*self.base.names, *(f"gain{joint + 1}" for joint in range(self.model.robot.dof))]


def measures_of(recording: Recording) -> str:
    """Which of the two a recording has; `prepare` takes the current where both were recorded."""
    return "current" if "current" in recording.signals else "torque"


def fleet_model(model: Model) -> Model:
    """The model as a fleet uses it: load apart, temperature from run to run, bodies on the flange left out.

    Without a column of its own, friction by load would count as dry friction and change with every payload.
    In 20 s an arm does not warm up: how friction changes with temperature is seen between runs.
    """
    effects = tuple(e for e in model.effects if not (e.needs_temperature or e.payload))
    if not any(effect.needs_load for effect in effects):
        effects += (LoadDependentFriction(),)
    return replace(model, effects=effects)


def kind_key(recording: Recording) -> str:
    """Name of the type a recording is of, fit for a file: arms of one have the same unknowns."""
    model = fleet_model(recording.model)
    unknowns = "\n".join([measures_of(recording), *model.robot.joints, *model.names])
    return f"{file_stem(model.robot.name, 'arm')}-{crc32(unknowns.encode()):08x}"


class Cause(NamedTuple):
    """Something that may change.

    Attributes:
        effect: Its name in the vocabulary of the diagnosis.
        joint: On which it acts, from 0.
        parameter: What changes.
        unit: Unit of the amount; empty where it is a share of the value.
        direction: Change of the unknowns of `Kind` for an amount of one, shape (m,).
        place: Index of the unknown of whose value a change is a share; -1 where the amount is a share
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

    @property
    def wears(self) -> bool:
        """Whether it may change on an arm by itself: links and tools do not."""
        return self.effect not in ("payload", "link_inertia")


def causes(kind: Kind) -> list[Cause]:
    """All: joint effects, drive gains where currents were recorded, a tool, base parameters of links."""
    model, unknowns = kind.model, len(kind.names)
    found: list[Cause] = []
    for effect, own in zip(model.effects, model.columns, strict=True):
        if not effect.inertial:
            found += _of_effect(kind, effect, own)
    if kind.measures == "current":
        directions = np.eye(unknowns)[len(kind.base.kept) :]
        found += [Cause("drive_gain", joint, "gain", "", one) for joint, one in enumerate(directions)]
    return found + _tool(kind) + _links(kind, {one.place for one in found})


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
    """What a tool adds to the last link: mass, first moments and inertia."""
    last = kind.model.inertias[-1].start
    joint, units = kind.model.robot.dof - 1, {"M": "kg", "MX": "kg m", "MY": "kg m", "MZ": "kg m"}
    return [
        Cause("payload", joint, name, units.get(name, "kg m^2"), _direction(kind, last + place))
        for place, name in enumerate(INERTIAL)
        if np.any(kind.base.regrouping[:, last + place])
    ]


def _links(kind: Kind, taken: Collection[int]) -> list[Cause]:
    """Base parameters of the links, as far as no effect is one: they stay as long as the arm is the same."""
    base, size = kind.base, len(kind.names)
    return [
        Cause("link_inertia", -1, base.names[k], base.units[k], np.eye(size)[k], k)
        for k in range(len(base.kept))
        if k not in taken
    ]


def _direction(kind: Kind, column: int) -> np.ndarray:
    return np.pad(kind.base.regrouping[:, column], (0, kind.model.robot.dof))


def _place(kind: Kind, column: int) -> int:
    """Where a parameter is an unknown by itself, or with others regrouped into it; -1 where it is not."""
    [place] = [*np.flatnonzero(kind.base.kept == column), -1][:1]
    return int(place)
