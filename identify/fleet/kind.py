"""Kind: a type of arm, which defines how its runs are reduced for comparison, and possible causes of change.

Each cause is a direction in the space of the arm's unknowns. Links do not wear: their inertias are constant,
except for the last link, which a tool changes.
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

    The m = b + n unknowns of an arm are its b base parameters and the logarithms of its n drive gains
    relative to the nominal ones.

    Attributes:
        model: Model of the type, from `fleet_model`.
        filtering: Filters of all runs, fully specified.
        measures: "current" or "torque".
    """

    model: Model
    filtering: Filtering
    measures: str

    @classmethod
    def of(cls, recording: Recording) -> "Kind":
        """The type of a recording's arm, with filters chosen from the recording.

        Raises:
            RecordingError: If the recording is too short to choose filters from.
        """
        model = fleet_model(recording.model)
        return cls(model, choose(replace(recording, model=model), Filtering()), measures_of(recording))

    @cached_property
    def base(self) -> BaseParameters:
        """Base parameters of the type."""
        return base_parameters(self.model)

    @property
    def body(self) -> np.ndarray:
        """Change of the base parameters per parameter of a payload on the flange, shape (b, 10)."""
        return self.base.regrouping[:, self.model.inertias[-1]]

    @cached_property
    def gain(self) -> np.ndarray:
        """Nominal torque per unit of the measured effort, shape (n,)."""
        robot = self.model.robot
        return np.ones(robot.dof) if self.measures == "torque" else robot.drive_gain

    @property
    def names(self) -> list[str]:
        """Names of the m unknowns of an arm, in order."""
        return [*self.base.names, *(f"gain{joint + 1}" for joint in range(self.model.robot.dof))]


def measures_of(recording: Recording) -> str:
    """The effort that a recording provides: "current", which `prepare` prefers if both exist, or "torque"."""
    return "current" if "current" in recording.signals else "torque"


def fleet_model(model: Model) -> Model:
    """The model for a fleet: with load-dependent friction, and without temperature effects and payloads.

    Without a separate column, load-dependent friction would count as dry friction and change with every
    payload. An arm does not warm up within 20 s, so temperature effects are determined between runs.
    """
    effects = tuple(effect for effect in model.effects if not (effect.needs_temperature or effect.payload))
    if not any(effect.needs_load for effect in effects):
        effects += (LoadDependentFriction(),)
    return replace(model, effects=effects)


def kind_key(recording: Recording) -> str:
    """File name for the type of a recording's arm; arms of one type have the same unknowns."""
    model = fleet_model(recording.model)
    unknowns = "\n".join([measures_of(recording), *model.robot.joints, *model.names])
    return f"{file_stem(model.robot.name, 'arm')}-{crc32(unknowns.encode()):08x}"


class Cause(NamedTuple):
    """A parameter that may change.

    Attributes:
        effect: Name of the effect in the vocabulary of the diagnosis.
        joint: Index of the joint on which it acts, from 0.
        parameter: Name of the parameter.
        unit: Unit of the amount; empty if it is a share of the value.
        direction: Change of the unknowns of `Kind` for an amount of one, shape (m,).
        place: Index of the unknown that is the reference of relative changes; -1 if the amount is a share
            itself, or there is no such unknown.
        thermal: Whether it depends on temperature.
        plausible: Upper bound of the amount with 68 % probability, if no tolerance is stated.
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
        """Whether it may differ from run to run: all except a tool."""
        return self.effect != "payload"

    @property
    def wears(self) -> bool:
        """Whether it may change by wear: links and tools do not."""
        return self.effect not in ("payload", "link_inertia")


def causes(kind: Kind) -> list[Cause]:
    """All causes: joint effects, drive gains if currents were recorded, a tool, base parameters of links."""
    model, unknowns = kind.model, len(kind.names)
    changing: list[Cause] = []
    for effect, columns in zip(model.effects, model.columns, strict=True):
        if not effect.inertial:
            changing += _effect_causes(kind, effect, columns)
    if kind.measures == "current":
        directions = np.eye(unknowns)[len(kind.base.kept) :]
        changing += [
            Cause("drive_gain", joint, "gain", "", direction) for joint, direction in enumerate(directions)
        ]
    return changing + _tool_causes(kind) + _link_causes(kind, {cause.place for cause in changing})


def _effect_causes(kind: Kind, effect: Effect, columns: slice) -> list[Cause]:
    """One cause for each parameter, with joint 0 if it has none, and one for all if they change together."""
    robot, name = kind.model.robot, name_of(effect)
    parameters, joints = effect.parameters(robot), [joint or 0 for joint in effect.parameter_joints(robot)]
    separate = [
        Cause(
            name,
            joint,
            parameter.name,
            parameter.unit,
            _direction(kind, columns.start + k),
            _place(kind, columns.start + k),
            effect.greased,
            effect.plausible,
        )
        for k, (parameter, joint) in enumerate(zip(parameters, joints, strict=True))
        if np.any(kind.base.regrouping[:, columns.start + k])
    ]
    if effect.together:
        values = kind.model.nominal_values[columns]
        direction = sum(value * _direction(kind, columns.start + k) for k, value in enumerate(values))
        separate.append(Cause(name, joints[0], effect.together, "", np.asarray(direction)))
    return separate


def _tool_causes(kind: Kind) -> list[Cause]:
    """Contribution of a tool to the last link: mass, first moments and inertia."""
    last = kind.model.inertias[-1].start
    joint, units = kind.model.robot.dof - 1, {"M": "kg", "MX": "kg m", "MY": "kg m", "MZ": "kg m"}
    return [
        Cause("payload", joint, name, units.get(name, "kg m^2"), _direction(kind, last + place))
        for place, name in enumerate(INERTIAL)
        if np.any(kind.base.regrouping[:, last + place])
    ]


def _link_causes(kind: Kind, used: Collection[int]) -> list[Cause]:
    """Base parameters of links, which no effect uses; they change only if the arm is exchanged."""
    base, size = kind.base, len(kind.names)
    return [
        Cause("link_inertia", -1, base.names[k], base.units[k], np.eye(size)[k], k)
        for k in range(len(base.kept))
        if k not in used
    ]


def _direction(kind: Kind, column: int) -> np.ndarray:
    return np.pad(kind.base.regrouping[:, column], (0, kind.model.robot.dof))


def _place(kind: Kind, column: int) -> int:
    """Index of the unknown that a parameter is, alone or with others regrouped into it; -1 if it is none."""
    [place] = [*np.flatnonzero(kind.base.kept == column), -1][:1]
    return int(place)
