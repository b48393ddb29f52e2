"""Base parameters: the combinations of standard parameters that joint torque can distinguish.

Columns of the regressor over a random rich motion are visited in an order of preference; a column in the span
of earlier columns is regrouped into them (Gautier and Khalil 1990, here by numerical orthogonalization). The
order gives the names usual in the field: YY, MZ and M of a link are regrouped into the preceding link.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arm.motion import Motion
from ..effects import Parameter, Prior
from ..errors import RobotError
from ..model import Model

DEPENDENT = 1e-3
"""A unit column is dependent if its share outside the span of the others is smaller than this. Rounding gives
1e-12, a right angle written as 1.5708 gives 4e-6, and the weakest truly independent column of an arm about
1e-2. A column that is independent only by a milliradian depends on the accuracy of the drawing."""
ROUNDING = 1e-5
"""Regrouping weights below this share are set to zero: geometry rounded to five digits causes them."""


@dataclass(frozen=True)
class BaseParameters:
    """Which combinations of parameters a motion can distinguish."""

    parameters: tuple[Parameter, ...]  # all p parameters of the model
    kept: np.ndarray  # parameter column of each base parameter, shape (b,)
    regrouping: np.ndarray  # base values = regrouping @ parameter values, shape (b, p)
    # Share of a column outside the span of the others: the smallest of an independent column, and the largest
    # of a dependent column.
    gap: tuple[float, float]

    @property
    def names(self) -> list[str]:
        """Names of the base parameters; an R such as in "ZZ1R" marks regrouping with other parameters."""
        regrouped = np.count_nonzero(self.regrouping, axis=1) != 1
        leading = [self.parameters[column].name for column in self.kept]
        return [name + "R" * int(more) for name, more in zip(leading, regrouped, strict=True)]

    @property
    def units(self) -> list[str]:
        """Unit of each base parameter."""
        return [self.parameters[column].unit for column in self.kept]

    @property
    def expressions(self) -> list[str]:
        """How each base parameter is composed, such as "ZZ1R = ZZ1 + Ia1 + 0.1225 M2"."""
        return [
            f"{name} = {self._sum(row)}"
            for row, name in enumerate(self.names)
            if name != self.parameters[self.kept[row]].name
        ]

    def _sum(self, row: int) -> str:
        weights = self.regrouping[row]
        order = [self.kept[row], *(c for c in np.flatnonzero(weights) if c != self.kept[row])]
        text = ""
        for column in order:
            weight = weights[column]
            size = "" if abs(abs(weight) - 1) < 1e-6 else f"{abs(weight):.4g} "
            sign = "-" if weight < 0 else "+"
            text += f" {sign} {size}{self.parameters[column].name}"
        return re.sub(r"^ \+ ", "", text)

    def before(self, model: Model) -> tuple[np.ndarray, np.ndarray]:
        """Nominal base values (b,) and their standard deviations (b,), infinite if any part has no prior."""
        std = np.array([prior.std for prior in model.priors])
        parts = np.where(self.regrouping != 0.0, std, 0.0) * self.regrouping
        return self.regrouping @ model.nominal_values, np.linalg.norm(parts, axis=1)

    def applied_to(self, model: Model, values: np.ndarray) -> Model:
        """The model with nominal values that give the base values (b,), so that gears carry the right load.

        Standard parameters that are in no base parameter, or only regrouped, keep their nominal values.
        """
        nominal = model.nominal_values.copy()
        nominal[self.kept] += values - self.regrouping @ nominal
        priors = zip(model.names, nominal, model.priors, strict=True)
        stated = {name: Prior(float(value), before.std) for name, value, before in priors}
        return replace(model, stated={**model.stated, **stated})

    @property
    def without_effect(self) -> list[str]:
        """Parameters that no motion of this arm reveals, alone or regrouped."""
        unseen = ~np.any(self.regrouping != 0, axis=0)
        return [p.name for p, hidden in zip(self.parameters, unseen, strict=True) if hidden]


def rich_motion(model: Model, samples: int = 400, payload: str = "", seed: int = 0) -> Motion:
    """Random positions within the limits, with velocities and accelerations of a few rad/s and rad/s^2."""
    random = np.random.default_rng(seed)
    limits, n = model.robot.limits, model.robot.dof
    lower = np.maximum(limits.position_lower, -np.pi)
    upper = np.minimum(limits.position_upper, np.pi)
    position = random.uniform(lower, upper, (samples, n))
    velocity, acceleration = random.normal(size=(2, samples, n)) * np.array([2.0, 6.0])[:, None, None]
    temperature = random.uniform(20.0, 50.0, (samples, n))
    time = np.arange(samples) * 1.0
    load = random.normal(size=(samples, n)) * 100.0
    return Motion.of(time, position, velocity, acceleration, load, temperature, payload)


def base_parameters(model: Model, payloads: Sequence[str] = ("",)) -> BaseParameters:
    """Structural base parameters of a model; `payloads` names the bodies carried in the runs, "" for none.

    Raises:
        RobotError: The model has no parameters, or none of them causes torque.
    """
    if not model.names:
        raise RobotError(f"{model.robot.name}: the model has no effects, and so no parameters to identify")
    motions = [rich_motion(model, payload=payload, seed=k) for k, payload in enumerate(payloads)]
    columns = np.concatenate([model.regressor(m).reshape(-1, len(model.names)) for m in motions])
    if not np.any(columns):
        raise RobotError(f"{model.robot.name}: no parameter of the model makes any torque")
    return from_columns(tuple(model.parameters), columns)


def from_columns(parameters: tuple[Parameter, ...], columns: np.ndarray) -> BaseParameters:
    """Base parameters from regressor columns, shape (rows, p)."""
    size = np.linalg.norm(columns, axis=0)
    order = sorted(range(len(parameters)), key=lambda c: (parameters[c].regroup, c))
    seen = size > ROUNDING * np.median(size[size > 0])
    basis = np.empty((len(columns), 0))
    independent, shares = [], []
    for column in order:
        orthogonal = columns[:, column] / size[column] if seen[column] else np.zeros(len(columns))
        for _ in range(2):  # twice is enough (Kahan, Parlett)
            orthogonal = orthogonal - basis @ (basis.T @ orthogonal)
        share = float(np.linalg.norm(orthogonal))
        shares.append(share)
        if share > DEPENDENT:
            independent.append(column)
            basis = np.column_stack([basis, orthogonal / share])
    kept_columns = np.array(sorted(independent))
    gap = min(s for s in shares if s > DEPENDENT), max([s for s in shares if s <= DEPENDENT], default=0.0)
    return BaseParameters(parameters, kept_columns, _regrouping(columns, kept_columns, size, seen), gap)


def _regrouping(columns: np.ndarray, kept: np.ndarray, size: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Weights of every parameter in the base parameters, shape (b, p), with rounding noise set to zero."""
    scaled = columns[:, kept] / size[kept]
    dependent = [c for c in np.flatnonzero(seen) if c not in set(kept)]
    weights = np.zeros((len(kept), columns.shape[1]))
    weights[np.arange(len(kept)), kept] = 1.0
    if dependent:
        share = np.linalg.lstsq(scaled, columns[:, dependent] / size[dependent], rcond=None)[0]
        share[np.abs(share) < ROUNDING] = 0.0
        weights[:, dependent] = share * size[dependent] / size[kept][:, None]
    return weights
