"""Kind: a type of arm, and by what all its runs are reduced, so that they can be compared."""

from dataclasses import dataclass, replace
from functools import cached_property
from zlib import crc32

import numpy as np

from ..effects import LoadDependentFriction
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
        filtering: Of all runs, nothing left open.
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
