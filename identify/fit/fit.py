"""`Fit`: a model with the values identified from runs, and all warnings about them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ..arm.motion import Motion
from ..errors import FitError, WrongShape
from ..model import Model
from ..notebook import InNotebook, counted, optional
from ..preparation.prepare import Filtering, Prepared
from ..quantity import Quantity
from ..text_table import NORMAL_95
from .agreement import Agreement, Scores, agreement, figure
from .base_parameters import BaseParameters
from .equations import decimated_regressor
from .estimators import Estimate
from .repeatability import Repeatability

if TYPE_CHECKING:
    from pathlib import Path

    from ..arm.robot import ServoLaw
    from ..feedforward.feedforward import Feedforward


class Moved(NamedTuple):
    """A base parameter whose exported value is outside the 95 % interval of the estimate.

    `deviations` is the distance of the exported value from the estimate, in standard deviations.
    """

    name: str
    value: float
    exported: float
    deviations: float


@dataclass(frozen=True)
class Unclear:
    """An undetermined base parameter: its relative standard deviation [%], and what would determine it."""

    name: str
    std_percent: float
    hint: str


@dataclass(frozen=True, eq=False)
class Fit(InNotebook):
    """Base parameters and drive gains of a model."""

    model: Model  # robot and effects, including the payloads of the runs
    base: BaseParameters  # base parameters, without those that were dropped
    estimate: Estimate  # values, gains and covariance
    runs: tuple[str, ...]  # names of the runs used
    filtering: Filtering  # filter settings of the fit, including those chosen automatically
    condition: float  # condition number of the regressor with weighted rows and unit columns [-]
    rows: int  # number of equations used: decimated samples in which a joint slides, summed over joints
    # Nominal base values, shape (b,), and their standard deviations, shape (b,).
    prior: tuple[np.ndarray, np.ndarray]
    # Noise floor of the filtered currents or torques, shape (n,) [A] or [N m], with which all predicted runs
    # are compared.
    noise: np.ndarray
    noise_source: str  # how the noise floor was determined; see `Prepared`
    # Speed below which each joint counted as standing still, the largest of all runs used, shape (n,)
    # [rad/s]; friction below it is not identified.
    standstill: np.ndarray
    # Base parameters that the data do not support -> estimate before they were dropped.
    dropped: dict[str, float] = field(default_factory=dict)
    # Base parameters with a large relative uncertainty, and what would determine them.
    unclear: tuple[Unclear, ...] = ()
    agreement: tuple[Agreement, ...] = ()  # comparison with each run used
    validation: tuple[Agreement, ...] = ()  # comparison with each held-out run
    warnings: tuple[str, ...] = ()  # sentences about recordings and fit that the user should read
    suspicions: tuple[str, ...] = ()  # sentences about likely mistakes in the recordings
    # Base parameters including the dropped ones; None if none was dropped.
    structure: BaseParameters | None = None
    # Estimate of all parameters of `structure`, before any was dropped; None if none was dropped.
    full_estimate: Estimate | None = None
    measures: str = "torque"  # quantity that was recorded in the runs used, "current" or "torque"
    # Residuals of each run, for a fit that was read from a file and has no samples.
    scores: tuple[Scores, ...] = ()
    carried: Mapping[str, str] = field(default_factory=dict)  # run used -> name of its payload
    simulations: tuple[str, ...] = ()  # names of the runs used that were simulated
    # Predicted runs that do not count as validation: simulations, jogs, unknown payloads.
    apart: tuple[Agreement, ...] = ()
    # Base values of the exported model, the nearest physically consistent ones, shape (b,); None if there are
    # none.
    exported: np.ndarray | None = None
    # Held-out run -> its payload, "" for none, if no run of the fit carries that payload.
    edits: Mapping[str, str] = field(default_factory=dict)
    # Bias of the values, before any was dropped, then of the gains, per friction over transmitted torque of
    # each joint, shape (b + n, n); None if the model has that friction.
    gear_friction_bias: np.ndarray | None = None
    # Agreement of the parameters between runs; None if it was not asked for.
    repeatability: Repeatability | None = None

    if TYPE_CHECKING:  # `exidyn.api` binds these functions of the layers above
        verdict: ClassVar[str]
        identified: ClassVar[Model]

        def save(self, path: Path | str) -> Path: ...
        def export(self, format: str, path: Path | str | None = None, payload: str = "") -> str: ...
        def report(self, path: Path | str) -> Path: ...
        def feedforward(
            self,
            payload: str = "",
            servo: ServoLaw | None = None,
            band: float | np.ndarray | None = None,
            share: float = ...,
        ) -> "Feedforward": ...

    @property
    def gains_unstated(self) -> bool:
        """Whether currents were recorded and the robot description has no drive gains."""
        return self.measures == "current" and bool(np.all(self.model.robot.drive_gain == 1.0))

    @property
    def unscaled(self) -> bool:
        """Whether "torque" is actually current, because gains are neither stated nor estimated."""
        return self.gains_unstated and not np.any(self.estimate.gain_estimated)

    @property
    def undropped(self) -> "Fit":
        """The fit before parameters were dropped; itself if none was."""
        if self.structure is None or self.full_estimate is None:
            return self
        return replace(
            self,
            base=self.structure,
            estimate=self.full_estimate,
            prior=self.structure.before(self.model),
            dropped={},
            structure=None,
            full_estimate=None,
            exported=None,
        )

    @property
    def names(self) -> list[str]:
        """Names of the base parameters, in the order of `estimate.values`."""
        return self.base.names

    @property
    def moved(self) -> tuple[Moved, ...]:
        """Base parameters whose exported value is outside their 95 % interval, in the order of `names`."""
        if self.exported is None:
            return ()
        rows = zip(self.names, self.estimate.values, self.exported, self.estimate.std, strict=True)
        return tuple(
            Moved(name, float(value), float(new), float(abs(new - value) / std) if std > 0.0 else np.inf)
            for name, value, new, std in rows
            if abs(new - value) > NORMAL_95 * std
        )

    def __getitem__(self, name: str) -> Quantity:
        """One base parameter by its name, with or without the R of regrouping.

        Example:
            >>> fit["Fv1"].value, fit["Fv1"].interval
            (3.02, (2.96, 3.08))

        Raises:
            KeyError: There is no such parameter, or it was dropped; the message lists the valid names.
        """
        if name in self.dropped or f"{name}R" in self.dropped:
            raise KeyError(
                f"the data do not support base parameter '{name}': it was dropped; drop=False keeps it"
            )
        for names in (self.names, [name.removesuffix("R") for name in self.names]):
            if name in names:
                place = names.index(name)
                value, std = float(self.estimate.values[place]), float(self.estimate.std[place])
                return Quantity(value, std, self.base.units[place])
        raise KeyError(f"no base parameter '{name}'. Valid: {', '.join(self.names)}")

    def value(self, name: str) -> float:
        """Value of one base parameter by its name; see `Fit[name]`."""
        return self[name].value

    @property
    def gains(self) -> dict[str, Quantity]:
        """Drive gain of each joint by its name [N m/A], estimated or nominal, with its standard deviation."""
        estimate, joints = self.estimate, self.model.robot.joints
        rows = zip(joints, estimate.gain, estimate.gain_std, strict=True)
        return {joint: Quantity(float(value), float(std), "N m/A") for joint, value, std in rows}

    def torque(
        self,
        q: np.ndarray,
        dq: np.ndarray,
        ddq: np.ndarray,
        payload: str = "",
        time: np.ndarray | None = None,
    ) -> np.ndarray:
        """Joint torque that the fit predicts for a motion, of the shape of `q` [N m].

        Args:
            q: Position, shape (t, n) [rad], or (n,) for one sample.
            dq: Velocity, same shape [rad/s].
            ddq: Acceleration, same shape [rad/s^2].
            payload: Name of the body on the flange; empty for none.
            time: Time of the samples, shape (t,) [s]; only friction with memory needs it.

        Raises:
            WrongShape: The arrays have different shapes, or do not have one column per joint.
        """
        position, velocity, acceleration = parts = [np.atleast_2d(np.asarray(p, float)) for p in (q, dq, ddq)]
        shape = (len(parts[0]), self.model.robot.dof)
        if any(part.shape != shape for part in parts):
            shapes = ", ".join(
                f"{name} {part.shape}" for name, part in zip(("q", "dq", "ddq"), parts, strict=True)
            )
            raise WrongShape(f"torque: shapes are {shapes}; expected {shape} (samples, joints) for each")
        time = np.arange(shape[0], dtype=float) if time is None else np.asarray(time, float)
        motion = self.model.loaded(Motion.of(time, position, velocity, acceleration, payload=payload))
        regressor = self.model.regressor(motion)[:, :, self.base.kept]
        torque = regressor @ self.estimate.values + self.model.known_torque(motion)
        return np.asarray(torque if np.ndim(q) > 1 else torque[0])

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
        """Base parameters as a pandas table: value, standard deviation, 95 % interval, unit; nominal values.

        Raises:
            MissingPackage: pandas is not installed.
        """
        nominal, nominal_std = self.prior
        columns = {
            "value": self.estimate.values,
            "std": self.estimate.std,
            "low": self.estimate.values - NORMAL_95 * self.estimate.std,
            "high": self.estimate.values + NORMAL_95 * self.estimate.std,
            "unit": self.base.units,
            "nominal": nominal,
            "nominal_std": nominal_std,
        }
        return optional("pandas", "a table").DataFrame(columns, index=self.names)

    def plot(self, run: str = "") -> Any:
        """Measured and predicted torque of each joint of one run, as a matplotlib figure.

        Args:
            run: Name of the run; by default the first held-out run, or else the first run.

        Raises:
            MissingPackage: matplotlib is not installed.
            FitError: The fit has no samples of this run.
        """
        runs = {agreement.run: agreement for agreement in (*self.validation, *self.agreement)}
        if not runs or (run and run not in runs):
            raise FitError(f"plot: no samples of run '{run}'. Runs with samples: {', '.join(runs) or 'none'}")
        return figure(runs[run] if run else next(iter(runs.values())), self.model.robot)

    def noise_of(self, measures: str) -> np.ndarray | None:
        """Noise floor in "current" or "torque", shape (n,); None if the fit does not have it."""
        if measures == self.measures:
            return self.noise
        return np.abs(self.estimate.gain) * self.noise if self.measures == "current" else None

    def agree(self, run: Prepared) -> Agreement:
        """Compare the fit with a prepared run."""
        return agreement(run, self.estimate, *decimated_regressor(self.model, self.base, run, run.motion))
