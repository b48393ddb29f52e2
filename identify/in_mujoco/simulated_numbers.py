"""Numbers of joints and servos by simulation of the runs, each kept only if it helps in other runs.

First the servos of all joints change alike, since a file is usually wrong about all of them; then each joint
by itself. A joint keeps a version if its own windows of the held-out runs get better.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from ..text_table import NORMAL_95
from .distances import HORIZONS, MATERIAL, SURE
from .joint_numbers import ACCURACY, ARMATURE, CYCLE, DAMPING, DELAY, DETERMINED, DRY, KP, LIMIT, JointNumbers
from .other_masses import MOST, joints_with_other_masses
from .replay import POSITION, Run
from .rollouts import SECONDS, Rollouts
from .trial import Trial
from .tuning import LOGARITHMIC, Tuning, to_coordinates

TINY = np.finfo(float).tiny
SHORT = 0.5
"""Duration of a window with commanded torque [s], which holds no position."""
FACTORS = tuple(2.0**power for power in range(-8, 4))
"""Factors on the file's stiffness with which simulations are tried: files state gains that are wrong by a
hundred, of which a hobby servo is softer."""
LAGS = (0.05,)
"""Damping over stiffness with which simulations are tried besides the file's damping [s]."""
SHARES = (0.0, 0.5)
"""Dry friction over the usual torque of a servo, with which simulations are tried besides the file's."""
SEARCHES = 2
"""Number of stiffnesses from which a search starts, besides the file's."""
FEW, BRIEF = 16, 4
"""Number of windows and of steps of such a search."""
SLOW = 0.005
"""Sampling period above which it matters whether commands are held or interpolated [s]: half of it is longer
than a step of a simulation."""
FINER = 0.25
"""Accuracy of friction and armature over that of stiffness: they do not depend on when a command arrives."""
QUANTILES, LIMITS = (0.5, 0.999), 16
"""Quantiles of the torque that a servo without a limit would have, and number of limits between them."""
FRICTION = (DAMPING, DRY, ARMATURE)


class Simulated(NamedTuple):
    """Numbers of joints, by simulation."""

    values: np.ndarray  # numbers, shape (6, n); those of the file where the runs do not require others
    halves: np.ndarray  # halves of their 95 % intervals, shape (6, n); infinite if they were not fitted
    held: bool  # whether commands are held from sample to sample; otherwise they are interpolated
    undetermined: np.ndarray  # whether the runs leave the stiffness of each servo open, shape (n,)


def simulated_numbers(
    numbers: JointNumbers, training: Trial, judging: Trial, text: bytes, known: Sequence[int] = ()
) -> Simulated:
    """Fit joint numbers to the training runs, and keep those of which the judging runs get better.

    `text` is the version of the file whose bodies are simulated, and with whose numbers the fit starts; the
    rows in `known` are not fitted.
    """
    version = JointNumbers(numbers.source._replace(text=text), numbers.robot, training.commands)
    return _Search(numbers, training, judging, text, known).result(version.values)


@dataclass
class _Search:
    """Search for the numbers of a file."""

    numbers: JointNumbers  # the numbers of the file
    training: Trial  # runs to which numbers are fitted
    judging: Trial  # other runs
    text: bytes  # version of the file that is simulated
    known: Sequence[int]  # rows that are not fitted

    def __post_init__(self) -> None:
        self.simulator = self.training.simulator(self.text)
        self.doubtful = np.zeros(self.numbers.robot.dof, bool)
        self.file, runs = self.numbers.values, self.training.runs
        self.period = max(float(np.median(np.diff(run.time))) for run in runs)
        self.size, self.floor = usual_sizes(runs, self.training), np.zeros(self.file.shape)
        positions = self.training.commands == POSITION
        moved = np.std(np.concatenate([run.position for run in runs]), axis=0) + TINY
        self.usual = self.size[DRY] if positions else moved
        accuracy = 0.5 * ACCURACY * self.period
        self.floor[LOGARITHMIC], self.floor[DELAY] = accuracy, CYCLE * self.period
        self.floor[list(FRICTION)] = FINER * accuracy * self.file[list(FRICTION)]
        self.floor[ARMATURE] = np.hypot(self.floor[ARMATURE], self.training.numerical_inertia)
        self.fits = self._tuning(runs, seconds=SECONDS if positions else SHORT)
        self.others = self._tuning(self.judging.runs, seconds=HORIZONS[-1] if positions else SHORT)

    def _tuning(self, runs: Sequence[Run], **windows: float) -> Tuning:
        rollouts = Rollouts(self.simulator, self.numbers, runs, self.usual, **windows)
        return Tuning(rollouts, self.file, self.size, self.floor, held=self.training.held)

    def result(self, start: np.ndarray) -> Simulated:
        """Numbers that the runs require."""
        free = self._rows(KP, DELAY, *FRICTION)
        values, fitted = self.file, np.zeros(free.shape, bool)
        if KP not in self.known:
            start = self._beginning(free)
        tied = [row for row in (KP, DELAY) if row not in self.known]
        common = self.fits.fitted(start, free, tied)
        if KP not in self.known:
            # Other masses may stand for the stiffness of a servo that changes little.
            near = np.abs(np.log(common[KP] / self.file[KP])) < MOST
            runs, model = self.training.runs, self.training.model
            self.doubtful = near & joints_with_other_masses(runs, model, common[DELAY])
        if np.any(self.doubtful):
            free = self._rows(KP, DELAY, *FRICTION)
            common = self.fits.fitted(np.where(free, common, self.file), free, tied)
        # First a delay alone, rather than damping and armature that do nearly the same.
        few = self._rows(KP, DELAY)
        simple = self.fits.fitted(np.where(few, common, self.file), few, tied) if few.any() else self.file
        for version, rows in ((simple, few), (common, free)):
            alike = self._pooled(version)
            harmless = alike & few.any() & ~self._worse(values, version) & ~fitted.any(axis=0)
            kept = self._better(values, version) | harmless
            values, fitted = np.where(kept, version, values), np.where(kept, rows, fitted)
        self.fits = replace(self.fits, expected=common if alike else self.file)
        values, fitted, alone = self._stage(values, values, fitted, free)
        if LIMIT not in self.known:
            start, reached = self._with_limits(values)
            values, fitted, _ = self._stage(start, values, fitted, self._rows(LIMIT) & reached)
            limited = (free | self._rows(LIMIT)) & fitted[LIMIT]
            values, fitted, _ = self._stage(values, values, fitted, limited)
        values, fitted, std = self._needed(values, fitted)
        halves = NORMAL_95 * std
        halves[LOGARITHMIC] *= np.where(fitted, values, 1.0)[LOGARITHMIC]
        spread = self.fits.deviations(values, free)[KP]
        uncertain = np.isfinite(spread) & (spread > DETERMINED)
        # Or left as in the file, though the training runs ask for another stiffness.
        far = np.abs(alone[KP] - self.file[KP]) > DETERMINED * self.file[KP]
        uncertain |= free[KP] & far & (values[KP] == self.file[KP])
        return Simulated(values, halves, self.fits.held, uncertain)

    def _stage(
        self, start: np.ndarray, values: np.ndarray, fitted: np.ndarray, free: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Numbers of each joint by itself where its other windows get better, and those that were tried."""
        if not free.any():
            return values, fitted, values
        new = self.fits.fitted(start, free)
        kept = self._better(values, new)
        return np.where(kept, new, values), np.where(kept, fitted | free, fitted), new

    def _needed(self, values: np.ndarray, fitted: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Numbers without changes that the runs do not require, which of them differ, and deviations."""
        fewer, std = self.fits.needed(values, fitted)
        changed = fitted & (fewer != self.file)
        fewer = self.fits.fitted(fewer, changed) if changed.any() else fewer
        more = self._worse(values, fewer)
        std = np.where(more, self.fits.deviations(values, fitted), std) if more.any() else std
        values, fitted = np.where(more, values, fewer), np.where(more, fitted, changed)
        with np.errstate(invalid="ignore"):  # infinite limits
            alike = np.abs(to_coordinates(values) - to_coordinates(self.file)) <= NORMAL_95 * std
        values = np.where(alike & ~more, self.file, values)
        useful = self._better(self.file, values)
        useful |= self._pooled(values) & ~self._worse(self.file, values)
        return np.where(useful, values, self.file), fitted & useful, std

    def _rows(self, *rows: int) -> np.ndarray:
        """Which numbers are free, shape (6, n)."""
        free = np.zeros(self.file.shape, bool)
        free[[row for row in rows if row not in self.known]] = True
        free[KP] &= ~self.doubtful
        return free

    def _better(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Whether the second version is nearer to the judging runs, for each joint by itself, shape (n,).

        Its error has decreased with 95 % confidence, by `MATERIAL` and by the noise of the encoder.
        """
        before, after = self.others.sizes(first), self.others.sizes(second)
        gain = np.mean(before - after, axis=0)
        spread = np.std(before - after, axis=0) / np.sqrt(len(before))
        noise = np.max([run.noise for run in self.judging.runs], axis=0) / self.usual
        return np.asarray(gain > np.max([SURE * spread, MATERIAL * np.mean(before, axis=0), noise], axis=0))

    def _worse(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Whether the second version is farther from the judging runs, for each joint by itself, shape (n,).

        The growth counts beside the usual error of the joint: a joint that rests tells little.
        """
        growth = self.others.sizes(second) - self.others.sizes(first)
        spread, mean = np.std(growth, axis=0) / np.sqrt(len(growth)), np.mean(growth, axis=0)
        return np.asarray((mean > SURE * spread) & (mean > MATERIAL))

    def _pooled(self, values: np.ndarray) -> bool:
        """Whether a version is nearer to the judging runs than the file, over all joints."""
        before, after = (self.others.sizes(version) for version in (self.file, values))
        usual = np.mean(before, axis=0) + TINY
        gain = np.mean((before - after) / usual, axis=1)
        return bool(np.mean(gain) > max(SURE * np.std(gain) / np.sqrt(len(gain)), MATERIAL))

    def _beginning(self, free: np.ndarray) -> np.ndarray:
        """Numbers near the best ones, by searches from several stiffnesses in few windows."""
        few = self._tuning(self.training.runs, most=FEW)
        versions = [self._guess(few, factor) for factor in FACTORS]
        versions.sort(key=lambda each: float(few.cost(each).sum()))
        starts = [self.file, *versions[:SEARCHES]]
        tied = [row for row in (KP, DELAY) if row not in self.known]
        searches = [few.fitted(each, free, tied, BRIEF) for each in starts]
        found = [(few, min(searches, key=lambda each: float(few.cost(each).sum())))]
        if self.period > SLOW:
            held = replace(few, held=True)
            found.append((held, held.fitted(found[0][1], free, tied, BRIEF)))
        best, values = min(found, key=lambda pair: float(pair[0].cost(pair[1]).sum()))
        self.fits, self.others = (replace(of, held=best.held) for of in (self.fits, self.others))
        return values

    def _guess(self, fits: Tuning, factor: float) -> np.ndarray:
        """Numbers with a factor on the stiffness, and for each joint the best of some frictions."""
        versions = []
        for lag, share in product((None, *LAGS), SHARES):
            values = self.file.copy()
            values[KP] *= factor
            if lag is not None:
                values[DAMPING] = lag * values[KP]
            values[DRY] = np.maximum(values[DRY], share * values[KP] * self.usual)
            versions.append(values)
        return self._best(fits, versions)[0]

    def _best(self, fits: Tuning, versions: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """For each joint by itself, numbers of the best version, and its index."""
        best = np.argmin([fits.cost(version) for version in versions], axis=0)
        return np.array(versions)[best, :, np.arange(len(best))].T, best

    def _with_limits(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers with the best of some torque limits, and for which joints one is better than the file's."""
        free = []
        for run in self.training.runs:
            assert run.command is not None
            acting = self.simulator.inputs_at(run, run.time, values[DELAY], self.fits.held)
            free.append(values[KP] * (acting - run.position) - values[DAMPING] * run.velocity)
        low, high = np.quantile(np.abs(np.concatenate(free)), QUANTILES, axis=0)
        limits = np.geomspace(low, high, LIMITS)
        versions = [values.copy() for _ in range(1 + LIMITS)]
        for version, limit in zip(versions[1:], limits, strict=True):
            version[LIMIT] = limit
        chosen, best = self._best(self.fits, versions)
        return chosen, best > 0


def usual_sizes(runs: Sequence[Run], trial: Trial) -> np.ndarray:
    """Size of numbers that shows in the motion of each joint, shape (6, n), over its stiffness if it has one.

    It is the torque that moves the joint, at its rms acceleration and velocity.
    """
    torques = [
        run.torque(trial.model) if run.command is None or trial.commands != POSITION
        else run.command - run.position for run in runs
    ]  # fmt: skip
    torque, velocity, acceleration = (
        np.std(np.concatenate(parts), axis=0) + TINY
        for parts in (
            torques,
            [run.velocity for run in runs],
            [np.gradient(run.velocity, run.time, axis=0) for run in runs],
        )
    )
    ones = np.ones(len(torque))
    return np.array([ones, torque / velocity, torque, torque / acceleration, ones, ones])
