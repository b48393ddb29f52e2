"""Runs of one arm as arrays, in units in which its unknowns are near one, and sums of their normal matrices.

A run's normal matrix A and right-hand side b represent the likelihood exp(-(x' A x)/2 + b' x), so runs are
combined by adding these.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .kind import Cause, Kind, causes
from .summary import Summary

ROUNDS = 12
"""Iterations of expectation-maximization; each reduces the error of spreads by about half."""
UNITS_DIFFER = 0.3
"""Relative spread of friction between units of a type, if the robot file states none [-]."""
BY_TEMPERATURE = (0.3, 0.1, 0.02)
"""Prior relative change of friction by 10 K, and by its square and cube [-]: the viscosity of grease falls by
2 to 4 % per kelvin, and these are about twice the terms of that exponential."""
TEN_KELVIN = 10.0
WARM_UP = 0.5 / 24.0
"""Time constant of warm-up of gears [d]: half an hour."""
COLD = 5.0 * WARM_UP
"""Pause after which an arm is cold again [d]: less than one percent of the warm-up remains."""
LOOSE = 1e3
"""Initial standard deviation of values without a stated tolerance, relative to their uncertainty from one run
if everything else were known."""
LEAST_TOLERANCE = 1e-6
"""Minimum relative tolerance of values stated as exact, so that matrices can be inverted."""


def scattered(
    normal: np.ndarray, right: np.ndarray, directions: np.ndarray, variance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Normal equations of runs whose unknowns vary at random along directions, by Woodbury's identity.

    Normal matrices are (r, m, m), right-hand sides (r, m), and directions (k, m). The variance of the amounts
    is (r, k) or (k,) and positive.
    """
    along = normal @ directions.T
    inner = directions @ along
    diagonal = np.arange(len(directions))
    inner[:, diagonal, diagonal] += 1.0 / variance
    solution = np.linalg.solve(
        inner, np.concatenate([np.swapaxes(along, 1, 2), (right @ directions.T)[..., None]], 2)
    )
    reduction = along @ solution
    return normal - reduction[:, :, :-1], right - reduction[:, :, -1]


class Population(NamedTuple):
    """Arms of one type: mean (d,) and variance (d,) of each unknown between units, independent."""

    mean: np.ndarray
    variance: np.ndarray

    def posterior(self, normal: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean (d,) and covariance (d, d) of one unit, by the normal equations of its runs."""
        precision = normal + np.diag(1.0 / self.variance)
        covariance = np.linalg.inv(precision)
        covariance = 0.5 * (covariance + covariance.T)
        return covariance @ (right + self.mean / self.variance), covariance


def population(normals: np.ndarray, rights: np.ndarray, before: Population) -> Population:
    """Mean and spread of units, by empirical Bayes from their normal equations (a, d, d), (a, d).

    The prior counts as one additional unit beside a single one, and for less beside many. It is known only to
    its order of magnitude, and would otherwise make temperature effects seem to differ between many units.
    """
    estimate, units, weight = before, len(normals), 1.0 / len(normals)
    for _ in range(ROUNDS):
        means, covariances = zip(*map(estimate.posterior, normals, rights), strict=True)
        mean = (weight * before.mean + np.sum(means, axis=0)) / (weight + units)
        square = np.square(means - mean) + np.diagonal(covariances, axis1=1, axis2=2)
        estimate = Population(mean, (weight * before.variance + square.sum(axis=0)) / (weight + units))
    return estimate


class Run(NamedTuple):
    """A run of an arm: content hash, days since 1970 in UTC with a fraction, and summary."""

    key: str
    day: float
    summary: Summary


@dataclass(frozen=True, eq=False)
class Frame:
    """Causes and units that all arms of a type share; in these units, unknowns are near one.

    Attributes:
        kind: The type.
        causes: The k possible causes of change.
        before: Prior mean (m,) and variance (m,) of the unknowns, in SI units.
        directions: Directions of the causes, in the frame's units, shape (k, m).
        thermal: Indices of the f causes that depend on temperature.
        reference: Reference temperature, shape (n,) [degC]; NaN if warm-up takes its place.
    """

    kind: Kind
    causes: tuple[Cause, ...]
    before: Population
    directions: np.ndarray
    thermal: tuple[int, ...]
    reference: np.ndarray

    @classmethod
    def of(cls, kind: Kind, runs: Sequence[Run]) -> "Frame":
        """The frame by the robot file, and by runs where the file states no tolerance."""
        changing = tuple(causes(kind))
        before = _prior(kind, changing, [run for run in runs if run.summary.known] or runs)
        directions = np.stack([cause.direction for cause in changing]) / np.sqrt(before.variance)
        thermal = tuple(index for index, cause in enumerate(changing) if cause.thermal)
        reference = np.median([run.summary.temperature for run in runs], axis=0)
        return cls(kind, changing, before, directions, thermal, reference)

    @property
    def scale(self) -> np.ndarray:
        """Size of the frame's units in SI units, shape (m,)."""
        return np.sqrt(self.before.variance)

    @property
    def start(self) -> Population:
        """Prior of an arm's unknowns: m values, then f temperature coefficients for each power."""
        values = self.before.mean / self.scale
        spread = np.repeat(BY_TEMPERATURE, len(self.thermal))
        mean = np.concatenate([values, np.zeros(len(spread))])
        return Population(mean, np.concatenate([np.ones(len(values)), spread**2]))

    def unknown_of(self, cause: Cause) -> int:
        """Index of the unknown that a cause changes by itself; -1 if there is none."""
        return len(self.kind.base.kept) + cause.joint if cause.effect == "drive_gain" else cause.place

    @property
    def by_warmth(self) -> np.ndarray:
        """Change of the unknowns by each thermal cause for a relative change of one, shape (f, m)."""
        sizes = self.sizes(self.before.mean / self.scale)[list(self.thermal)]
        return sizes[:, None] * self.directions[list(self.thermal)]

    def sizes(self, values: np.ndarray) -> np.ndarray:
        """Amount of each cause that corresponds to 100 %, shape (k,), for values (m,) in the frame's units.

        For friction it is the value, or the spread between units if that is larger; otherwise it is one.
        """
        sizes = np.ones(len(self.causes))
        for k in self.thermal:
            place = self.causes[k].place
            sizes[k] = max(abs(values[place]), 1.0) * self.scale[place]
        return sizes


def _prior(kind: Kind, changing: Sequence[Cause], runs: Sequence[Run]) -> Population:
    model, joints = kind.model, kind.model.robot.dof
    values, std = kind.base.before(model)
    nominal = np.append(values, np.zeros(joints))
    gains = model.robot.drive_gain_tolerance if kind.measures == "current" else np.zeros(joints)
    stated = np.append(std, np.maximum(gains, LEAST_TOLERANCE))
    stated = np.maximum(stated, LEAST_TOLERANCE * np.abs(nominal))
    sums = [run.summary.normal(kind, nominal[:-joints], kind.gain) for run in runs]
    normal, right = np.sum([n for n, _ in sums], axis=0), np.sum([r for _, r in sums], axis=0)
    alone = 1.0 / np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny) / len(runs))
    known = np.isfinite(stated) & (stated > 0.0)
    limit = np.full(len(nominal), np.inf)
    for cause in changing:
        if cause.place >= 0:
            limit[cause.place] = min(limit[cause.place], cause.plausible)
    first = Population(nominal, np.where(known, stated, np.minimum(LOOSE * alone, limit)) ** 2)
    scale = np.sqrt(first.variance)
    values = scale * np.linalg.solve(
        normal * np.outer(scale, scale) + np.eye(len(scale)), scale * right + nominal / scale
    )
    mean = np.where(known, nominal, values)
    between = np.minimum(np.hypot(UNITS_DIFFER * values, alone), limit)
    return Population(mean, np.where(known, stated, between) ** 2)


@dataclass(frozen=True, eq=False)
class ArmRuns:
    """Runs of one arm, by date.

    Attributes:
        frame: Causes and units of the type of arm.
        runs: Runs in order.
        days: Day of each run, shape (r,) [d].
        normal: Normal matrix of each run in the frame's units, shape (r, m, m).
        right: Right-hand side of each run in the frame's units, shape (r, m).
        about: Linearization point in the frame's units, shape (m,).
        design: Unknowns of a run per unknown of the arm, shape (r, m, d).
        loose: Whether each run has a payload that is not completely known, shape (r,).
    """

    frame: Frame
    runs: tuple[Run, ...]
    days: np.ndarray
    normal: np.ndarray
    right: np.ndarray
    about: np.ndarray
    design: np.ndarray
    loose: np.ndarray

    @classmethod
    def of(cls, frame: Frame, runs: Sequence[Run], values: np.ndarray, gain: np.ndarray) -> "ArmRuns":
        """Runs, linearized about values (b,) and gains (n,)."""
        ordered = tuple(sorted(runs, key=lambda run: (run.day, run.key)))
        equations = [run.summary.normal(frame.kind, values, gain) for run in ordered]
        scale = frame.scale
        return cls(
            frame,
            ordered,
            np.array([run.day for run in ordered]),
            np.stack([normal for normal, _ in equations]) * np.outer(scale, scale),
            np.stack([right for _, right in equations]) * scale,
            np.append(values, np.log(gain / frame.kind.gain)) / scale,
            design_of(frame, ordered),
            np.array([not run.summary.known for run in ordered]),
        )

    def __getitem__(self, rows: np.ndarray | slice) -> "ArmRuns":
        indices = np.arange(len(self.runs))[rows]
        arrays = {
            name: getattr(self, name)[indices] for name in ("days", "normal", "right", "design", "loose")
        }
        return replace(self, runs=tuple(self.runs[k] for k in indices), **arrays)


def design_of(frame: Frame, runs: Sequence[Run]) -> np.ndarray:
    """Unknowns of each run, by date, per unknown of the arm, shape (r, m, d)."""
    joints = [frame.causes[k].joint for k in frame.thermal]
    warmth, by_warmth = _warmth(frame, runs)[:, joints, None], frame.by_warmth
    powers = [warmth ** (1 + k) for k in range(len(BY_TEMPERATURE))]
    identity = np.broadcast_to(
        np.eye(by_warmth.shape[1]), (len(runs), by_warmth.shape[1], by_warmth.shape[1])
    )
    return np.concatenate([identity, *(np.swapaxes(power * by_warmth, 1, 2) for power in powers)], axis=2)


def _warmth(frame: Frame, runs: Sequence[Run]) -> np.ndarray:
    """Temperature above the reference in tens of kelvin, or else the degree of warm-up, shape (r, n)."""
    if np.all(np.isfinite(frame.reference)):
        return (np.stack([run.summary.temperature for run in runs]) - frame.reference) / TEN_KELVIN
    warmth, begin = np.zeros(len(runs)), runs[0].day
    for index in range(1, len(runs)):
        begin = runs[index].day if runs[index].day - runs[index - 1].day > COLD else begin
        warmth[index] = 1.0 - np.exp(-(runs[index].day - begin) / WARM_UP)
    return np.repeat(warmth[:, None], len(frame.reference), axis=1)
