"""Runs of one arm as arrays, in units in which its unknowns are about one, and sums of their normal matrices.

A run's normal matrix A and right-hand side b stand for exp(-(x' A x)/2 + b' x): what two runs say is their
sum.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .kind import Cause, Kind, causes
from .summary import Summary

ROUNDS = 12
"""Of expectation and maximisation; each brings spreads some half of the way."""
UNITS_DIFFER = 0.3
"""Usual spread of friction between units of a type, over its value, where its file states none [-]."""
BY_TEMPERATURE = (0.3, 0.1, 0.02)
"""Share of friction by which 10 K, their square and their cube change it [-]: viscosity of greases falls by
2 to 4 % a kelvin; these are about twice the terms of that exponential."""
TEN_KELVIN = 10.0
WARM_UP = 0.5 / 24.0
"""Time constant with which gears warm up [d]: half an hour."""
COLD = 5.0 * WARM_UP
"""Pause after which an arm is cold again [d]: less than a hundredth of the warmth is left."""
LOOSE = 1e3
"""Deviation of what nobody states, over what a run would leave if all else were known, to begin with."""
LEAST_TOLERANCE = 1e-6
"""Share of the value that what is stated exactly may be off, so that all can be inverted."""


def scattered(
    normal: np.ndarray, right: np.ndarray, directions: np.ndarray, variance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What runs say of unknowns that each run has moved at random along directions, by Woodbury's identity.

    Normal matrices are (r, m, m), right-hand sides (r, m), directions (k, m); the variance of the amounts is
    (r, k) or (k,), above zero.
    """
    along = normal @ directions.T
    inner = directions @ along
    places = np.arange(len(directions))
    inner[:, places, places] += 1.0 / variance
    taken = np.linalg.solve(
        inner, np.concatenate([np.swapaxes(along, 1, 2), (right @ directions.T)[..., None]], 2)
    )
    less = along @ taken
    return normal - less[:, :, :-1], right - less[:, :, -1]


class Population(NamedTuple):
    """Arms of one type: mean (d,) and variance (d,) between units of each unknown, independent."""

    mean: np.ndarray
    variance: np.ndarray

    def posterior(self, normal: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean (d,) and covariance (d, d) of one unit of which runs say this."""
        precision = normal + np.diag(1.0 / self.variance)
        covariance = np.linalg.inv(precision)
        covariance = 0.5 * (covariance + covariance.T)
        return covariance @ (right + self.mean / self.variance), covariance


def population(normals: np.ndarray, rights: np.ndarray, before: Population) -> Population:
    """Mean and spread of units (a, d, d), (a, d), by empirical Bayes.

    What was held true before counts as one more unit beside one, and for less the more there are: it is known
    by its order of magnitude, and what temperature does would else seem to differ by that between many units.
    """
    found, units, weight = before, len(normals), 1.0 / len(normals)
    for _ in range(ROUNDS):
        means, covariances = zip(*map(found.posterior, normals, rights), strict=True)
        mean = (weight * before.mean + np.sum(means, axis=0)) / (weight + units)
        square = np.square(means - mean) + np.diagonal(covariances, axis1=1, axis2=2)
        found = Population(mean, (weight * before.variance + square.sum(axis=0)) / (weight + units))
    return found


class Run(NamedTuple):
    """A run of an arm: content hash, day since 1970 in UTC with its fraction, and what the run says."""

    key: str
    day: float
    summary: Summary


@dataclass(frozen=True, eq=False)
class Frame:
    """What all arms of a type share: causes, and the units in which unknowns are about one.

    Attributes:
        kind: The type.
        causes: What may change, k.
        before: Mean (m,) and variance (m,) of the unknowns before any unit is compared, in SI units.
        directions: Directions of the causes, in the frame's units, shape (k, m).
        thermal: Causes that depend on temperature, f places.
        reference: Temperature at which values are stated, shape (n,) [degC]; NaN where warm-up stands for it.
    """

    kind: Kind
    causes: tuple[Cause, ...]
    before: Population
    directions: np.ndarray
    thermal: tuple[int, ...]
    reference: np.ndarray

    @classmethod
    def of(cls, kind: Kind, runs: Sequence[Run]) -> "Frame":
        """From the robot file; from runs what it does not state."""
        found = tuple(causes(kind))
        before = _before(kind, found, [run for run in runs if run.summary.known] or runs)
        directions = np.stack([one.direction for one in found]) / np.sqrt(before.variance)
        thermal = tuple(place for place, one in enumerate(found) if one.thermal)
        return cls(
            kind, found, before, directions, thermal, np.median([r.summary.temperature for r in runs], axis=0)
        )

    @property
    def scale(self) -> np.ndarray:
        """SI units in one of the frame's, shape (m,)."""
        return np.sqrt(self.before.variance)

    @property
    def start(self) -> Population:
        """Unknowns of an arm before anything is learned: m of its own, then f a power of temperature."""
        own = self.before.mean / self.scale
        spread = np.repeat(BY_TEMPERATURE, len(self.thermal))
        mean = np.concatenate([own, np.zeros(len(spread))])
        return Population(mean, np.concatenate([np.ones(len(own)), spread**2]))

    @property
    def by_warmth(self) -> np.ndarray:
        """Direction of each thermal cause for a share of one of its usual value, shape (f, m)."""
        sizes = self.sizes(self.before.mean / self.scale)[list(self.thermal)]
        return sizes[:, None] * self.directions[list(self.thermal)]

    def sizes(self, values: np.ndarray) -> np.ndarray:
        """Amount of each cause that counts as all of it, shape (k,), for values (m,) in the frame's units.

        Of friction its value, or the spread of units where that is less; of all else one.
        """
        found = np.ones(len(self.causes))
        for k in self.thermal:
            place = self.causes[k].place
            found[k] = max(abs(values[place]), 1.0) * self.scale[place]
        return found


def _before(kind: Kind, found: Sequence[Cause], runs: Sequence[Run]) -> Population:
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
    most = np.full(len(nominal), np.inf)
    for one in found:
        if one.place >= 0:
            most[one.place] = min(most[one.place], one.plausible)
    first = Population(nominal, np.where(known, stated, np.minimum(LOOSE * alone, most)) ** 2)
    scale = np.sqrt(first.variance)
    values = scale * np.linalg.solve(
        normal * np.outer(scale, scale) + np.eye(len(scale)), scale * right + nominal / scale
    )
    mean = np.where(known, nominal, values)
    between = np.minimum(np.hypot(UNITS_DIFFER * values, alone), most)
    return Population(mean, np.where(known, stated, between) ** 2)


@dataclass(frozen=True, eq=False)
class ArmRuns:
    """Runs of one arm, by date.

    Attributes:
        frame: What the values of its type of arm are expressed in.
        runs: In order.
        days: Shape (r,) [d].
        normal: Shape (r, m, m), and
        right: shape (r, m): what each says of the unknowns, in the frame's units.
        about: Unknowns about which these are linearised, in the frame's units, shape (m,).
        design: Unknowns of a run per unknown of the arm, shape (r, m, d).
        loose: Runs with a body of which not all is known, shape (r,).
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
        """Linearised about values (b,) and gains (n,)."""
        ordered = tuple(sorted(runs, key=lambda run: (run.day, run.key)))
        says = [run.summary.normal(frame.kind, values, gain) for run in ordered]
        scale = frame.scale
        return cls(
            frame,
            ordered,
            np.array([run.day for run in ordered]),
            np.stack([normal for normal, _ in says]) * np.outer(scale, scale),
            np.stack([right for _, right in says]) * scale,
            np.append(values, np.log(gain / frame.kind.gain)) / scale,
            design_of(frame, ordered),
            np.array([not run.summary.known for run in ordered]),
        )

    def __getitem__(self, rows: np.ndarray | slice) -> "ArmRuns":
        places = np.arange(len(self.runs))[rows]
        arrays = {
            name: getattr(self, name)[places] for name in ("days", "normal", "right", "design", "loose")
        }
        return replace(self, runs=tuple(self.runs[k] for k in places), **arrays)


def design_of(frame: Frame, runs: Sequence[Run]) -> np.ndarray:
    """Unknowns of each run, by date, per unknown of the arm, shape (r, m, d)."""
    joints = [frame.causes[k].joint for k in frame.thermal]
    warmth, by = _warmth(frame, runs)[:, joints, None], frame.by_warmth
    powers = [warmth ** (1 + k) for k in range(len(BY_TEMPERATURE))]
    own = np.broadcast_to(np.eye(by.shape[1]), (len(runs), by.shape[1], by.shape[1]))
    return np.concatenate([own, *(np.swapaxes(w * by, 1, 2) for w in powers)], axis=2)


def _warmth(frame: Frame, runs: Sequence[Run]) -> np.ndarray:
    """Temperature over the reference in tens of kelvin, shape (r, n); without one, how warmed up it is."""
    if np.all(np.isfinite(frame.reference)):
        return (np.stack([run.summary.temperature for run in runs]) - frame.reference) / TEN_KELVIN
    warm, begin = np.zeros(len(runs)), runs[0].day
    for place in range(1, len(runs)):
        begin = runs[place].day if runs[place].day - runs[place - 1].day > COLD else begin
        warm[place] = 1.0 - np.exp(-(runs[place].day - begin) / WARM_UP)
    return np.repeat(warm[:, None], len(frame.reference), axis=1)
