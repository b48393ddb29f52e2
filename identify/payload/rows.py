"""Equations of the runs: what the arm and the payload contribute to each joint's torque.

Unknowns are the base parameters of the arm, ten parameters of the payload, changes of friction and offsets in
runs with the payload, and a relative error of each drive gain. A run without the payload has zeros in the
columns of the payload and of the changes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arm.rigid_regressor import INERTIAL
from ..effects import Payload, Prior
from ..effects.load_dependent_friction import LoadDependentFriction
from ..fit.base_parameters import BaseParameters, base_parameters
from ..fit.equations import Equations, assemble
from ..fit.gear_friction_bias import REVERSAL
from ..model import Model
from ..preparation.prepare import Prepared

TOOL = "tool"
"""Name of the payload to identify in models and recordings."""
GEAR_FRICTION = 0.2
"""Standard deviation of the friction per transmitted torque if the model has no such friction [-]. Harmonic
drives and planetary gears lose 5 to 20 % of the torque that they transmit, hobby servos 15 to 25 %."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Equations of all runs, with the columns of each kind of unknown."""

    equations: Equations  # equations; the regressor has the columns of the arm, then those of the payload
    arm: int  # number of base parameters of the arm
    changing: np.ndarray  # base parameters of the arm that may differ between runs: friction and offsets
    loaded: np.ndarray  # whether the run of a row carries the payload, shape (r,)

    @property
    def payload(self) -> slice:
        """Columns of the payload in the regressor."""
        return slice(self.arm, self.arm + len(INERTIAL))

    @property
    def columns(self) -> np.ndarray:
        """Torque per unit of arm, payload and changes, shape (r, n, b + 10 + c) [N m / unit]."""
        regressor = self.equations.regressor
        changes = regressor[:, :, self.changing] * self.loaded[:, None, None]
        return np.concatenate([regressor, changes], axis=2)


def with_tool(model: Model) -> Model:
    """The model with an unknown payload, and with friction that grows with the load if it has none.

    A payload loads the gears, which then have more friction. Without that friction in the model, it would
    appear as mass.
    """
    if not any(isinstance(effect, LoadDependentFriction) for effect in model.effects):
        friction = LoadDependentFriction(reversal=REVERSAL)
        stated = {p.name: Prior(0.0, GEAR_FRICTION) for p in friction.parameters(model.robot)}
        model = replace(model + friction, stated={**stated, **model.stated})
    return model + Payload(TOOL)


def with_columns(base: BaseParameters, model: Model) -> BaseParameters:
    """Base parameters of an arm, then those of `model` that the arm's base does not have.

    `model` is from `with_tool`. The base is that of the model alone, or of a fit, whose model had fewer
    parameters: then friction that grows with the load comes after its base parameters. The payload is last.
    """
    places = np.array([model.names.index(parameter.name) for parameter in base.parameters])
    new = np.setdiff1d(np.arange(len(model.names)), places)
    regrouping = np.zeros((len(base.kept) + len(new), len(model.names)))
    regrouping[: len(base.kept), places] = base.regrouping
    regrouping[len(base.kept) + np.arange(len(new)), new] = 1.0
    return BaseParameters(
        tuple(model.parameters), np.concatenate([places[base.kept], new]), regrouping, base.gap
    )


def arm_base(model: Model) -> BaseParameters:
    """Base parameters of an arm without payload, for `with_columns`; `model` is from `with_tool`."""
    base = base_parameters(model, ("",))
    arm = [k for k, parameter in enumerate(base.parameters) if not parameter.name.endswith(TOOL)]
    return replace(
        base, parameters=tuple(base.parameters[k] for k in arm), regrouping=base.regrouping[:, arm]
    )


def rows_of(model: Model, base: BaseParameters, runs: Sequence[Prepared]) -> Rows:
    """Equations of runs for a base from `with_payload_columns`.

    Raises:
        RecordingError: The runs measure different quantities, or are filtered differently.
    """
    equations = assemble(model, base, runs)
    loaded = np.zeros(len(equations.current), bool)
    for rows, run in zip(equations.runs, runs, strict=True):
        loaded[rows] = run.motion.payload == TOOL
    arm = len(base.kept) - len(INERTIAL)
    changing = {
        column
        for effect, columns in zip(model.effects, model.columns, strict=True)
        if (effect.greased or effect.guessed) and not isinstance(effect, LoadDependentFriction)
        for column in range(columns.start, columns.stop)
    }
    places = [k for k, column in enumerate(base.kept[:arm]) if int(column) in changing]
    return Rows(equations, arm, np.array(places, int), loaded)
