"""Fit: a model with the values that runs gave it, and all warnings about them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..errors import FitError
from ..model import Model
from ..notebook import InNotebook, counted, optional
from ..preparation.prepare import Filtering, Prepared
from ..text_table import NORMAL_95
from .agreement import Agreement, Scores, agreement, figure
from .base_parameters import BaseParameters
from .equations import decimated_regressor
from .estimators import Estimate
from .methods import FitMethods


class Moved(NamedTuple):
    """A base parameter that export and simulation take otherwise than the data say, beyond its 95 %.

    `deviations` is how far the exported value is from that of the data, in its standard deviations.
    """

    name: str
    value: float
    exported: float
    deviations: float


@dataclass(frozen=True)
class Unclear:
    """A base parameter that runs leave open: its deviation over its value [%], and what would settle it."""

    name: str
    std_percent: float
    hint: str


@dataclass(frozen=True, eq=False)
class Fit(FitMethods, InNotebook):
    """Base parameters and drive gains of a model.

    Attributes:
        model: Robot and effects, payloads of the runs included.
        base: Base parameters, those that were dropped left out.
        estimate: Values, gains and covariance.
        runs: Names of the runs used.
        filtering: Filters that were used, chosen ones filled in.
        condition: Condition number of the regressor with weighted rows and unit columns [-].
        rows: Decimated samples times joints used.
        prior: Base values before the data, shape (b,), and their deviation, shape (b,).
        dropped: Base parameters that the data do not support, with the value they had.
        unclear: Base parameters that remain uncertain, and what would settle them.
        agreement: With each run used.
        validation: With runs held out.
        warnings: Sentences about recordings and fit that the user should read.
        suspicions: Mistakes in the recordings that are likely, in sentences.
        structure: Base parameters before any was dropped; None if none was.
        measures: "current" or "torque": what was recorded in the runs used.
        scores: Residuals by run, of a fit that was read from its file and has no samples.
        noise: Noise level of currents or torques of its runs behind its filter, shape (n,) [A] or [N m], by
            which all runs are judged that it predicts; None in files of before the key.
        noise_source: Where that is from, as of `Prepared`.
        carried: Run -> name of its payload, of the runs used.
        simulations: Runs used that were simulated.
        apart: Runs that it predicts and that do not judge it: simulated, jogs, with a body it does not know.
        edits: Run held out -> its payload, empty for none, of runs whose payload no run used carries.
        exported: Base values that export and simulation take, those nearest that an arm can have, shape (b,);
            None where there are none, or in files of before the key.
    """

    model: Model
    base: BaseParameters
    estimate: Estimate
    runs: tuple[str, ...]
    filtering: Filtering
    condition: float
    rows: int
    prior: tuple[np.ndarray, np.ndarray]
    dropped: dict[str, float] = field(default_factory=dict)
    unclear: tuple[Unclear, ...] = ()
    agreement: tuple[Agreement, ...] = ()
    validation: tuple[Agreement, ...] = ()
    warnings: tuple[str, ...] = ()
    suspicions: tuple[str, ...] = ()
    structure: BaseParameters | None = None
    measures: str = "torque"
    scores: tuple[Scores, ...] = ()
    noise: np.ndarray | None = None
    noise_source: str = ""
    carried: Mapping[str, str] = field(default_factory=dict)
    simulations: tuple[str, ...] = ()
    apart: tuple[Agreement, ...] = ()
    exported: np.ndarray | None = None
    edits: Mapping[str, str] = field(default_factory=dict)

    @property
    def gains_unstated(self) -> bool:
        """Whether currents were recorded, and the robot's description gives the drive gain of no joint."""
        return self.measures == "current" and bool(np.all(self.model.robot.drive_gain == 1.0))

    @property
    def unscaled(self) -> bool:
        """Whether what counts as torque is really current: gains neither stated nor estimated."""
        return self.gains_unstated and not np.any(self.estimate.gain_estimated)

    @property
    def names(self) -> list[str]:
        """Base parameters, in the order of `estimate.values`."""
        return self.base.names

    @property
    def moved(self) -> tuple[Moved, ...]:
        """Base parameters that are exported beyond their own 95 %, in their order."""
        if self.exported is None:
            return ()
        rows = zip(self.names, self.estimate.values, self.exported, self.estimate.std, strict=True)
        return tuple(
            Moved(name, float(value), float(taken), float(abs(taken - value) / std) if std > 0.0 else np.inf)
            for name, value, taken, std in rows
            if abs(taken - value) > NORMAL_95 * std
        )

    def value(self, name: str) -> float:
        """Value of one base parameter, with or without the R of regrouping.

        Raises:
            KeyError: No such parameter, or it was dropped; the message lists the valid ones.
        """
        if name in self.dropped or f"{name}R" in self.dropped:
            raise KeyError(
                f"the data do not support base parameter '{name}': it was dropped; drop=False keeps it"
            )
        plain = [n.removesuffix("R") for n in self.names]
        for candidates in (self.names, plain):
            if name in candidates:
                return float(self.estimate.values[candidates.index(name)])
        raise KeyError(f"no base parameter '{name}'. Valid: {', '.join(self.names)}")

    def __repr__(self) -> str:
        runs = counted(len(self.runs), "run")
        gains = "drive gains estimated" if np.any(self.estimate.gain_estimated) else "drive gains as stated"
        lines = [f"Fit of {self.model.robot.name}: {len(self.names)} base parameters from {runs}, {gains}"]
        for run in (self.validation or self.agreement)[:3]:
            ratios = ", ".join(f"{ratio:.3g}" for ratio in run.over_noise)
            lines.append(f"  {run.run}: residual over noise, by joint: {ratios}")
        lines += [f"  condition number {self.condition:.3g}; dropped: {', '.join(self.dropped) or 'none'}"]
        if self.warnings:
            number = counted(len(self.warnings), "warning")
            lines.append(f"  {number}, the first: {self.warnings[0]}")
        return "\n".join(lines)

    def to_dataframe(self) -> Any:
        """Base parameters as a pandas table: value and standard deviation, and the nominal ones before.

        Raises:
            MissingPackage: pandas is not installed.
        """
        nominal, nominal_std = self.prior
        columns = {
            "value": self.estimate.values,
            "std": self.estimate.std,
            "nominal": nominal,
            "nominal_std": nominal_std,
        }
        return optional("pandas", "a table").DataFrame(columns, index=self.names)

    def plot(self, run: str = "") -> Any:
        """Measured and predicted torque of each joint of one run, as a matplotlib figure.

        Args:
            run: Its name; the first held out, or else the first, by default.

        Raises:
            MissingPackage: matplotlib is not installed.
            FitError: The fit has no samples of such a run.
        """
        every = {one.run: one for one in (*self.validation, *self.agreement)}
        if not every or (run and run not in every):
            raise FitError(
                f"plot: no samples of run '{run}'. Runs with samples: {', '.join(every) or 'none'}"
            )
        return figure(every[run] if run else next(iter(every.values())), self.model.robot)

    def noise_of(self, measures: str) -> np.ndarray | None:
        """Its noise level in currents or torques, shape (n,); None where it has none of these."""
        if measures == self.measures or self.noise is None:
            return self.noise
        return np.abs(self.estimate.gain) * self.noise if self.measures == "current" else None

    def agree(self, run: Prepared) -> Agreement:
        """Compare the fit with a prepared run."""
        return agreement(run, self.estimate, *decimated_regressor(self.model, self.base, run, run.motion))
