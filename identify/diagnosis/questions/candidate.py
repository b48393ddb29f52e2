"""Candidate: one physical effect on certain joints, as columns that may explain the residual."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...effects import Effect, Shape
from ...errors import NotRecorded
from ...text_table import digits
from ..runs.driven import Driven

SIZE = 0.1
"""Expected torque of an effect, share of the joint's usual torque [-]; evidence depends only on its
logarithm."""
KNOWN = 0.01
"""Largest relative deviation of a coefficient that counts as known by definition [-]."""
UNNAMED = "unnamed"
"""Name of coefficients that only give an effect its freedom, and are not reported."""

Columns = Callable[[Driven], np.ndarray]
"""Motor torque of a run per unit of each coefficient, at full rate (t, n, p) [N m / unit]."""

Reported = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Converts fitted coefficients and their standard deviations, each (p,), to the reported ones."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """One effect on certain joints, in a certain shape."""

    effect: str  # name in the vocabulary
    joints: tuple[int, ...]  # joints it acts on, from 0; empty if it acts on the whole arm
    columns: Columns  # torque per unit of its coefficients in a run
    names: tuple[str, ...]  # names of its coefficients
    units: tuple[str, ...]  # units of its coefficients
    lower: tuple[float, ...]  # smallest value that physics allows each coefficient, not above 0
    shape: Mapping[str, float] = field(default_factory=dict)  # nonlinear parameters
    bounds: Mapping[str, Shape] = field(default_factory=dict)  # bounds for refining these
    reshape: Callable[[Mapping[str, float]], "Candidate"] | None = None  # the same effect in another shape
    instance: Effect | None = None  # effect to add to a model, if there is one
    rows: tuple[int, ...] | None = None  # joints whose motors carry its torque; None for all
    smooth: bool = False  # whether its torque is as smooth as the motion
    # expected size of its coefficients relative to the first, if physics gives it
    proportion: tuple[float, ...] | None = None
    cancels: bool = False  # whether coefficients may cancel, each far larger than their sum suggests
    size: float = np.inf  # expected torque over the joint's usual torque, if its cause gives it [-]
    led: int = 0  # number of leading coefficients, at least one of which must be free
    # mean and standard deviation of each coefficient, where physics gives its size; an infinite deviation
    # stands for one that gives the joint's usual torque
    expected: tuple[tuple[float, float], ...] | None = None
    among: int = 1  # number of shapes from which a first look chose it
    prior: float = 1.0  # prior weight relative to other hypotheses [-]
    everywhere: bool = False  # whether every joint must be predicted better
    covers: bool = False  # whether it includes this effect on every joint, so that none is tested with it
    # name and joints of the group of effects with the same torque to which it belongs
    same_torque: tuple[str, tuple[int, ...]] | None = None
    kind: str = ""  # distinguishes it from others of its effect, such as the frequency of a ripple
    # quantities that follow from the shape: name -> value and unit
    reported: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    reported_as: Reported = lambda values, std: (values, std)  # converts its coefficients for the report
    # standard deviations of quantities that another sensor measured
    known: Mapping[str, float] = field(default_factory=dict)
    loaded: bool = False  # whether its columns depend on motor torque or gear load
    carried: bool = False  # whether the gears transmit its torque
    reloads: bool = False  # whether the torque of all motors is fitted again with it
    by_run: bool = False  # whether each run has coefficients of its own, so that no other run shows it
    # unknowns of the dry friction that it varies, the joint's in the model first: their sum must not push
    varies: tuple[str, ...] = ()
    listed: bool = True  # whether the vocabulary has a name for it
    span: float = 0.0  # smallest range of its first joint's position that shows it [rad]
    gear_ratio: float = 1.0  # gear ratio of its first joint; 1 if unknown [-]

    @property
    def key(self) -> tuple[str, tuple[int, ...], str]:
        """Effect, joints and kind; all shapes with one key are one hypothesis."""
        return self.effect, self.joints, self.kind

    def covered(self, others: Iterable["Candidate"]) -> bool:
        """Whether one of the other candidates already includes this effect on its joints."""
        return any(other.covers and other.effect == self.effect and self.joints for other in others)

    def reshaped(self, shape: Mapping[str, float]) -> "Candidate":
        """The same hypothesis in another shape; its key does not depend on the shape."""
        if self.reshape is None:
            raise TypeError(f"{self.effect} has no shape")
        return replace(self.reshape(shape), effect=self.effect, joints=self.joints, kind=self.kind)

    @property
    def which(self) -> str:
        """Text that distinguishes it from others of its effect on its joints: its shape, or its kind."""
        numbers = ((name, value) for name, value in self.shape.items() if name != "reversal")
        return ", ".join(f"{name} {digits(value, 3)}" for name, value in numbers) or self.kind


@dataclass(frozen=True, eq=False)
class Thinned:
    """Columns of a candidate over all runs, decimated."""

    joints: np.ndarray  # joints it gives torque to, shape (k,)
    # torque per unit of each coefficient, shape (r, k, p); in single precision, since there are thousands
    values: np.ndarray
    std: np.ndarray  # expected deviation of each coefficient from its mean, shape (p,)
    mean: np.ndarray  # expected value, shape (p,); zero where the size of an effect is unknown
    usual: np.ndarray | None = None  # RMS torque of its joints, shape (k,) [N m]; None with `expected`

    @classmethod
    def of(cls, candidate: Candidate, runs: Sequence[Driven]) -> "Thinned":
        """Evaluate a candidate over runs, at the rate at which rows are compared."""
        dof = runs[0].torque.shape[1]
        joints = np.array(range(dof) if candidate.rows is None else candidate.rows)
        nothing = cls(joints[:0], np.zeros((0, 0, 0)), np.zeros(0), np.zeros(0))
        if candidate.span and covered_range(candidate, runs) < candidate.span:
            return nothing
        try:
            sampled = [run.coarse if candidate.smooth else run for run in runs]
            thinned = [run.thinned(_of_joints(candidate.columns(run), joints)) for run in sampled]
        except NotRecorded:
            return nothing
        # The rows of each column are contiguous in memory, because sums run over them.
        values = np.concatenate([np.moveaxis(part, 0, -1) for part in thinned], axis=-1)
        values = np.moveaxis(values, -1, 0)
        usual = np.sqrt(np.mean(np.concatenate([run.torque[:, joints] ** 2 for run in runs]), axis=0))
        strength = np.sqrt(np.mean(values**2, axis=0))
        values = values.astype(np.float32)
        # The joint on which a coefficient acts most limits its size.
        share = np.max(strength / np.maximum(usual[:, None], np.finfo(float).tiny), axis=0, initial=0.0)
        if candidate.expected is not None:
            mean, deviation = np.array(candidate.expected).T
            std = np.where(np.isfinite(deviation), deviation, 1.0 / np.maximum(share, 1e-12))
            return cls(joints, values, std, mean)
        std = SIZE / np.maximum(share, 1e-12)
        if candidate.proportion is not None:
            proportion = np.array(candidate.proportion)
            std = SIZE / max(float(np.max(share * proportion)), 1e-12) * proportion
        return cls(joints, values, std, np.zeros(len(std)), usual)

    @property
    def whole(self) -> np.ndarray:
        """Which coefficients are known in advance, (p,): such an effect is there in full or not at all."""
        return self.std < KNOWN * np.abs(self.mean)

    @property
    def empty(self) -> bool:
        """Whether the runs cannot show it."""
        return not len(self.joints) or not np.all(np.isfinite(self.values))

    def everywhere(self, dof: int) -> np.ndarray:
        """Columns on all joints, shape (r, n, p)."""
        columns = np.zeros((len(self.values), dof, self.values.shape[2]))
        columns[:, self.joints] = self.values
        return columns


def _of_joints(columns: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) of some joints, without a copy if these are all joints."""
    return columns if len(joints) == columns.shape[1] else columns[:, joints]


def covered_range(candidate: Candidate, runs: Sequence[Driven]) -> float:
    """Range of its first joint's position over all runs [rad]; infinite without a joint."""
    if not candidate.joints:
        return float("inf")
    return float(np.ptp(np.concatenate([run.motion.position[:, candidate.joints[0]] for run in runs])))
