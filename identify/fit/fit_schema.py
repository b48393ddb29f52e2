"""Schema of fit.json: types of the fields and consistency conditions between them."""

from dataclasses import asdict
from typing import Literal

from msgspec import Struct

from ..model import Model
from ..preparation.prepare import Filtering
from ..schema import (
    LARGEST,
    Count,
    Name,
    Number,
    Size,
    SizeWritten,
    check,
    check_covariance,
    check_different,
    check_known,
    check_length,
    check_rows,
)
from .agreement import Scores
from .fit import Unclear
from .repeatability import Repeatability


class BaseParameterRow(Struct, frozen=True, kw_only=True):
    """A base parameter; only dropped ones have no `prior`, the nominal value and its standard deviation."""

    name: Name
    unit: str
    kept: bool
    value: Number
    column: Count
    sum_of: dict[str, Number]
    std: Size | None = None
    exported: Number | None = None
    prior: tuple[Number, SizeWritten] | None = None

    def __post_init__(self) -> None:
        check(not self.kept or self.prior is not None, "prior", None, "nominal value and standard deviation")
        check(len(self.sum_of) > 0, "sum_of", self.sum_of, "standard parameters with their weights")


class FullEstimate(Struct, frozen=True, kw_only=True):
    """The estimate of all base parameters, before any was dropped; see `Fit.full_estimate`."""

    values: tuple[Number, ...]
    drive_gain: tuple[Number, ...]
    noise: tuple[SizeWritten, ...]
    covariance: tuple[tuple[Number, ...], ...]


SCORES = ("relative", "r_squared", "residual_rms", "noise", "over_noise")
"""Scores that the file stores for each run, one number per joint."""
SAME = (
    "runs", "measures", "rows", "condition", "filtering", "carried", "edits", "simulations", "unclear",
    "warnings", "suspicions", "repeatability",
)  # fmt: skip
"""Fields that a fit has as the file has them."""


class FitFile(Struct, frozen=True, kw_only=True):
    """A fit."""

    method: Name
    runs: tuple[str, ...]
    measures: Literal["current", "torque"]
    rows: Count
    condition: float
    filtering: Filtering
    joints: tuple[str, ...]
    drive_gain: tuple[Number, ...]
    drive_gain_std: tuple[SizeWritten, ...]
    drive_gains_nominal: bool
    noise: tuple[SizeWritten, ...]
    noise_floor: tuple[SizeWritten, ...]
    noise_floor_from: str
    standstill: tuple[Size, ...]
    gear_friction_bias: tuple[tuple[Number, ...], ...] | None
    carried: dict[str, str]
    edits: dict[str, str]
    simulations: tuple[str, ...]
    base_parameters: tuple[BaseParameterRow, ...]
    dropped: tuple[str, ...]
    full_estimate: FullEstimate | None
    gap: tuple[Size, Size]
    covariance: tuple[tuple[Number, ...], ...]
    standard_parameters: tuple[Number, ...] | None
    unclear: tuple[Unclear, ...]
    warnings: tuple[str, ...]
    agreement: tuple[Scores, ...]
    validation: tuple[Scores, ...]
    model: tuple[str, ...]
    suspicions: tuple[str, ...]
    repeatability: Repeatability | None

    def __post_init__(self) -> None:
        check(self.condition >= 1.0, "condition", self.condition, "a condition number, at least 1")
        for name, value in asdict(self.filtering).items():
            check(value is None or 0.0 < value <= LARGEST, f"filtering.{name}", value, "a number above zero")
        check(len(self.kept) > 0, "base_parameters", 0, "at least one with kept = true")
        for place, gain in enumerate(self.drive_gain):
            check(gain != 0.0, f"drive_gain[{place}]", gain, "a number other than zero")
        self._check_names()
        self._check_lengths()
        check_covariance(self.covariance, "covariance")

    @property
    def kept(self) -> list[BaseParameterRow]:
        """Base parameters that were not dropped."""
        return [row for row in self.base_parameters if row.kept]

    def _check_names(self) -> None:
        names = [row.name for row in self.base_parameters]
        check_different(names, "base parameters' names")
        check_different([row.column for row in self.base_parameters], "base parameters' columns")
        dropped = [row.name for row in self.base_parameters if not row.kept]
        matches = sorted(self.dropped) == sorted(dropped)
        check(matches, "dropped", list(self.dropped), f"those with kept = false, {dropped}")
        check_known([row.name for row in self.unclear], "names in unclear", names, "a base parameter")
        check_known(list(self.carried), "runs in carried", self.runs, "one of runs")
        check_known(self.simulations, "simulations", self.runs, "one of runs")
        held_out = [run.run for run in self.validation]
        check_known(list(self.edits), "runs in edits", held_out, "a run in validation")

    def _check_lengths(self) -> None:
        joints, size = len(self.drive_gain), len(self.kept) + len(self.drive_gain)
        per_joint = "one per joint, as drive_gain has"
        for name in ("joints", "drive_gain_std", "noise", "noise_floor", "standstill"):
            check_length(getattr(self, name), name, joints, per_joint)
        for key in ("agreement", "validation"):
            for place, run in enumerate(getattr(self, key)):
                for name in SCORES:
                    check_length(getattr(run, name), f"{key}[{place}].{name}", joints, per_joint)
        unknowns = "the kept base parameters and the joints"
        check_length(self.covariance, "covariance", size, unknowns)
        check_rows(self.covariance, "covariance", size, unknowns)
        if self.gear_friction_bias is not None:
            size, expected = len(self.base_parameters) + joints, "one per base parameter and joint"
            check_length(self.gear_friction_bias, "gear_friction_bias", size, expected)
            for place, row in enumerate(self.gear_friction_bias):
                check_length(row, f"gear_friction_bias[{place}]", joints, per_joint)
        if self.full_estimate is not None:
            self._check_full_estimate(self.full_estimate, joints)
        exported = sum(row.exported is not None for row in self.kept)
        expected = "a value of every kept base parameter, or none"
        check(exported in (0, len(self.kept)), "exported", exported, expected)

    def _check_full_estimate(self, full: FullEstimate, joints: int) -> None:
        key, parameters = "full_estimate", len(self.base_parameters)
        size, unknowns = parameters + joints, "the base parameters and the joints"
        check(len(self.kept) < parameters, key, "an estimate", "null, since no parameter was dropped")
        check_length(full.values, f"{key}.values", parameters, "one per base parameter")
        for name in ("drive_gain", "noise"):
            check_length(getattr(full, name), f"{key}.{name}", joints, "one per joint, as drive_gain has")
        for place, gain in enumerate(full.drive_gain):
            check(gain != 0.0, f"{key}.drive_gain[{place}]", gain, "a number other than zero")
        check_length(full.covariance, f"{key}.covariance", size, unknowns)
        check_rows(full.covariance, f"{key}.covariance", size, unknowns)
        check_covariance(full.covariance, f"{key}.covariance")


def check_with_model(file: FitFile, model: Model) -> None:
    """Check that a fit agrees with its model.

    Raises:
        Disagreement: They do not agree; the message names the field.
    """
    parameters, joints = model.parameters, model.robot.joints
    names, of_model = [parameter.name for parameter in parameters], "a parameter of the model"
    check_length(file.drive_gain, "drive_gain", len(joints), "one per joint of the model")
    check(file.joints == joints, "joints", file.joints, f"those of the model, {list(joints)}")
    per_parameter = "one per parameter of the model"
    check_length(file.standard_parameters, "standard_parameters", len(names), per_parameter)
    for place, row in enumerate(file.base_parameters):
        where, weights = f"base_parameters[{place}]", row.sum_of
        valid = f"{of_model}, from 0 to {len(names) - 1}"
        check(row.column < len(names), f"{where}.column", row.column, valid)
        check_known(list(weights), f"{where}.sum_of", names, of_model)
        leading = parameters[row.column]
        included = weights.get(leading.name, 0.0) != 0.0
        check(included, f"{where}.sum_of", list(weights), f"{leading.name} among them")
        alone = sum(weight != 0.0 for weight in weights.values()) == 1
        name = leading.name if alone else f"{leading.name}R"
        check(row.name == name, f"{where}.name", row.name, f"'{name}', by its column and sum_of")
        unit = f"'{leading.unit}', the unit of {leading.name}"
        check(row.unit == leading.unit, f"{where}.unit", row.unit, unit)
