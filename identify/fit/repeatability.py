"""Repeatability: which base parameters agree between the parts of the runs, and what the others follow.

Each part is fitted alone, at the drive gains and payloads of the fit of all runs. If a parameter is the same
in all parts, its k estimates scatter as their standard deviations say: the sum of squares of the standardized
deviations from their weighted mean, over k - 1, is F-distributed (Cochran's test of homogeneity; F rather
than chi-squared, since the standard deviations are estimates themselves). The deviation that remains between
parts is estimated by the method of moments (DerSimonian and Laird 1986). A parameter that differs is then
regressed on one condition at a time: temperature, speed, time, and numbers in the settings that differ
between runs.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..errors import FitError, NotExcited
from ..model import Model
from ..preparation.prepare import Prepared
from ..recordings.recording import Recording
from .equations import Equations
from .estimators import weighted
from .estimators.covariance import BLOCK, FEWEST_BLOCKS

SHORTEST = FEWEST_BLOCKS * BLOCK
"""Least duration of a part [s]: shorter ones have no estimate of their scatter."""
PARTS = 8
"""Number of parts into which few runs are split: six degrees of freedom for a slope."""
SPEED, TIME, TEMPERATURE = "speed", "time", "temperature"
"""Names of conditions: rms velocity [rad/s], minutes since the first run began, temperature [degC]."""
STAMP = "_ns"
"""End of the names of settings that are times of a clock, which are no conditions."""


@dataclass(frozen=True)
class Part:
    """A run or part of a run."""

    run: str  # name of the run
    start: float  # time of its first row [s]
    end: float  # time of its last row [s]
    # Name of a condition -> its mean, one number per joint or one for all joints.
    conditions: dict[str, tuple[float, ...]]


class RunPart(NamedTuple):
    """A part and its rows in the equations."""

    part: Part
    rows: slice


def run_parts(
    used: Sequence[Prepared], recordings: Sequence[Recording], equations: Equations
) -> list[RunPart]:
    """Runs that last `SHORTEST` or longer; few runs are split into up to `PARTS` such parts."""
    begins, settings = _begins(recordings), _settings(recordings)
    parts = []
    for run, run_rows, begin, numbers in zip(used, equations.runs, begins, settings, strict=True):
        time = run.decimated_time
        for first, last in _split(len(time), equations.rate, len(used)):
            start, end = float(time[first]), float(time[last - 1])
            conditions = {name: (value,) for name, value in numbers.items()} | _measured(run, start, end)
            if begin is not None:
                conditions[TIME] = ((begin + 0.5 * (start + end)) / 60,)
            rows = slice(run_rows.start + first, run_rows.start + last)
            parts.append(RunPart(Part(run.name, start, end, conditions), rows))
    return parts


def _split(count: int, rate: float, runs: int) -> Iterator[tuple[int, int]]:
    """First row of each part of a run, and that after its last."""
    number = min(int(count / (SHORTEST * rate)), max(1, PARTS // runs))
    return pairwise(np.linspace(0, count, number + 1).astype(int).tolist() if number else [])


def _measured(run: Prepared, start: float, end: float) -> dict[str, tuple[float, ...]]:
    """Speed, and temperature if it was measured, of each joint between two times."""
    inside = (run.motion.time >= start) & (run.motion.time <= end)
    means = {SPEED: np.sqrt(np.mean(run.motion.velocity[inside] ** 2, axis=0))}
    temperature = run.motion.temperature[inside]
    if np.all(np.any(np.isfinite(temperature), axis=0)):
        means[TEMPERATURE] = np.nanmean(temperature, axis=0)
    return {name: tuple(map(float, values)) for name, values in means.items()}


def _begins(recordings: Sequence[Recording]) -> list[float | None]:
    """Time at which each run began after the first one [s]; None if several runs do not state it."""
    stamps = [run.host_time for run in recordings]
    known = [int(stamp[0]) for stamp in stamps if stamp is not None and len(stamp)]
    if len(known) < len(recordings):
        return [0.0] if len(recordings) == 1 else [None] * len(recordings)
    return [(stamp - min(known)) * 1e-9 for stamp in known]


def _settings(recordings: Sequence[Recording]) -> list[dict[str, float]]:
    """Numbers in the settings of each run, such as a controller's gains, that all state and that differ."""
    numbers = [
        {name: value for name, text in run.settings.items() if (value := _number(text)) is not None}
        for run in recordings
    ]
    names = [
        name
        for name in numbers[0]
        if not name.endswith(STAMP)
        and all(name in run for run in numbers)
        and len({run[name] for run in numbers}) > 1
    ]
    return [{f"setting {name}": run[name] for name in names} for run in numbers]


def _number(text: str) -> float | None:
    """The number that a setting states; None if it states words."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


FEWEST = 4
"""Number of parts from which a slope is tried: two degrees of freedom are left for the scatter about it."""
SURE = 0.05
"""Probability that any parameter of a repeatable arm is said to differ, or that a parameter is said to follow
any condition that does not matter; Bonferroni's correction divides it by the number of tests."""


@dataclass(frozen=True)
class Trend:
    """How a parameter changes with a condition."""

    condition: str  # name of the condition, as in `Part.conditions`
    slope: float  # change of the parameter per unit of the condition
    std: float  # standard deviation of the slope
    probability: float  # probability of a slope at least as steep if the condition does not matter


@dataclass(frozen=True)
class Repeated:
    """Estimates of one base parameter in the parts."""

    name: str  # name of the base parameter
    unit: str  # its unit
    # Estimate in each part; None where its motion does not determine the parameter.
    values: tuple[float | None, ...]
    std: tuple[float | None, ...]  # standard deviation of each estimate
    mean: float  # weighted mean of the estimates
    deviation: float  # standard deviation between parts beyond that of the estimates
    probability: float  # probability of at least this scatter if the parameter is the same in all parts
    differs: bool = False  # whether the parameter differs between parts; `SURE` counts all parameters
    follows: tuple[Trend, ...] = ()  # conditions that explain the differences, the most probable first


@dataclass(frozen=True)
class Repeatability:
    """Agreement of base parameters between parts of the runs."""

    parts: tuple[Part, ...]  # the parts
    parameters: tuple[Repeated, ...]  # base parameters that at least two parts determine

    @property
    def conditions(self) -> list[str]:
        """Names of the conditions that all parts have and that are not the same in all of them."""
        return list(_of_joint(self.parts, None)) if self.parts else []

    @property
    def differing(self) -> list[Repeated]:
        """Parameters that differ between parts, the least probable scatter first."""
        return sorted((p for p in self.parameters if p.differs), key=lambda p: p.probability)


def repeatability(
    model: Model,
    equations: Equations,
    gain: np.ndarray,
    values: np.ndarray,
    used: Sequence[Prepared],
    recordings: Sequence[Recording],
) -> Repeatability:
    """Compare the base parameters of runs, or of parts of few runs, each fitted alone.

    Args:
        model: Model of the equations.
        equations: Equations of all runs.
        gain: Drive gains that hold in each part, shape (n,).
        values: Base parameters from all runs, shape (b,); those of payloads hold in each part.
        used: The prepared runs, in the order of the equations.
        recordings: Recordings of these runs.
    """
    shared = _at_payloads(model, replace(equations, gain=gain, gain_tolerance=0.0), values)
    parts = run_parts(used, recordings, equations)
    fits = [_alone(shared, part.rows) for part in parts]
    shape = len(fits), len(equations.base.kept)  # no parts of runs that are too short
    values, std = (np.reshape([fit[k] for fit in fits], shape) for k in (0, 1))
    columns = np.flatnonzero(np.sum(np.isfinite(std), axis=0) >= 2)
    joints = [joint for effect in model.effects for joint in effect.parameter_joints(model.robot)]
    parameters = []
    for column in columns:
        name, unit = equations.base.names[column], equations.base.units[column]
        repeated = _repeated(name, unit, values[:, column], std[:, column], SURE / len(columns))
        if repeated.differs:
            conditions = _of_joint([part.part for part in parts], joints[equations.base.kept[column]])
            repeated = replace(repeated, follows=_follows(values[:, column], std[:, column], conditions))
        parameters.append(repeated)
    return Repeatability(tuple(part.part for part in parts), tuple(parameters))


def _at_payloads(model: Model, equations: Equations, values: np.ndarray) -> Equations:
    """Equations with the torque of the payloads among base values (b,) as known torque."""
    carried = [
        np.arange(columns.start, columns.stop)
        for effect, columns in zip(model.effects, model.columns, strict=True)
        if effect.payload
    ]
    payload = np.isin(equations.base.kept, np.concatenate(carried) if carried else [])
    values = np.where(payload, values, 0.0)
    known = equations.known + equations.regressor @ values
    return replace(equations, known=known, regressor=np.where(payload, 0.0, equations.regressor))


def _alone(equations: Equations, rows: slice) -> tuple[np.ndarray, np.ndarray]:
    """Base parameters (b,) and standard deviations (b,) from some rows, NaN where undetermined."""
    values, std = np.full((2, equations.regressor.shape[2]), np.nan)
    part = replace(
        equations,
        regressor=equations.regressor[rows],
        current=equations.current[rows],
        known=equations.known[rows],
        weight=equations.weight[rows],
        first=equations.first[rows],
        runs=(slice(0, rows.stop - rows.start),),
    )
    absent = np.flatnonzero(~np.any(part.regressor, axis=(0, 1)))
    try:
        with np.errstate(divide="ignore", invalid="ignore"):
            estimate = weighted(part.without(absent.tolist()))
    except (NotExcited, FitError, np.linalg.LinAlgError):
        return values, std
    present = np.setdiff1d(np.arange(len(values)), absent)
    values[present], std[present] = estimate.values, estimate.std
    return values, std


def _repeated(name: str, unit: str, values: np.ndarray, std: np.ndarray, level: float) -> Repeated:
    """Whether estimates (k,) with standard deviations (k,) are of one value, at a level of probability."""
    usable = np.isfinite(std) & (std > 0.0)
    weight, count = std[usable] ** -2.0, int(np.sum(usable))
    mean = float(np.sum(weight * values[usable]) / np.sum(weight))
    scatter = float(np.sum(weight * (values[usable] - mean) ** 2))
    probability = float(stats.f.sf(scatter / (count - 1), count - 1, FEWEST_BLOCKS - 1))
    scale = np.sum(weight) - np.sum(weight**2) / np.sum(weight)
    deviation = float(np.sqrt(max(0.0, (scatter - (count - 1)) / scale)))
    return Repeated(
        name, unit, _or_none(values), _or_none(std), mean, deviation, probability, probability < level
    )


def _or_none(values: np.ndarray) -> tuple[float | None, ...]:
    return tuple(float(value) if np.isfinite(value) else None for value in values)


def _of_joint(parts: Sequence[Part], joint: int | None) -> dict[str, np.ndarray]:
    """Conditions of the parts that differ, name -> (k,): those of a joint, or means over all joints."""
    names = [name for name in parts[0].conditions if all(name in part.conditions for part in parts)]
    arrays = {name: [np.array(part.conditions[name]) for part in parts] for name in names}
    conditions = {
        name: np.array([np.mean(v) if joint is None or len(v) == 1 else v[joint] for v in rows])
        for name, rows in arrays.items()
    }
    return {name: values for name, values in conditions.items() if np.ptp(values) > 0.0}


def _follows(values: np.ndarray, std: np.ndarray, conditions: dict[str, np.ndarray]) -> tuple[Trend, ...]:
    """Conditions with which estimates (k,) change, by weighted regression on one condition at a time.

    The scatter about the line, where it exceeds the standard deviations, widens the interval of the slope.
    """
    usable = np.isfinite(std) & (std > 0.0)
    freedom = int(np.sum(usable)) - 2
    trends = []
    if freedom + 2 >= FEWEST:
        for name, condition in conditions.items():
            weight, x, y = std[usable] ** -2.0, condition[usable], values[usable]
            x, y = x - np.average(x, weights=weight), y - np.average(y, weights=weight)
            spread = float(np.sum(weight * x**2))
            if spread == 0.0:
                continue
            slope = float(np.sum(weight * x * y) / spread)
            excess = max(1.0, float(np.sum(weight * (y - slope * x) ** 2)) / freedom)
            deviation = float(np.sqrt(excess / spread))
            probability = 2 * float(stats.t.sf(abs(slope) / deviation, freedom))
            trends.append(Trend(name, slope, deviation, probability))
    limit = SURE / max(len(conditions), 1)
    return tuple(sorted((t for t in trends if t.probability < limit), key=lambda t: t.probability))
