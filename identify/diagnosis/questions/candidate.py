"""Candidate: one physical effect on certain joints, as columns that might explain what remains."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...effects import Effect, Shape
from ...errors import NotRecorded
from ...text_table import digits
from ..runs.driven import Driven

SIZE = 0.1
"""How large an effect is expected to be, share of the joint's usual torque [-]; evidence depends on its
logarithm only."""
KNOWN = 0.01
"""Share by which a coefficient may be wrong that is known by definition, and not by what was measured [-]."""
UNNAMED = "unnamed"
"""How coefficients are called that only give an effect its freedom, and are not reported."""

Columns = Callable[[Driven], np.ndarray]
"""Torque of the motors per unit of each coefficient in one run, at full rate (t, n, p) [N m / unit]."""

Reported = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Coefficients and their standard deviations, each (p,), as those that were fitted are reported."""


def as_fitted(values: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reported as they are."""
    return values, std


@dataclass(frozen=True, eq=False)
class Candidate:
    """One effect, on certain joints, of a certain shape."""

    effect: str  # name in the vocabulary
    joints: tuple[int, ...]  # where it acts, from 0; empty where it has no joint
    columns: Columns  # its torque in a run
    names: tuple[str, ...]  # of its coefficients
    units: tuple[str, ...]  # of its coefficients
    lower: tuple[float, ...]  # smallest value that physics allows each coefficient, not above 0
    shape: Mapping[str, float] = field(default_factory=dict)  # nonlinear parameters
    bounds: Mapping[str, Shape] = field(default_factory=dict)  # their bounds, where they may be refined
    reshape: Callable[[Mapping[str, float]], "Candidate"] | None = None  # the same effect in another shape
    instance: Effect | None = None  # what to add to a model, if an effect of its kind
    rows: tuple[int, ...] | None = None  # joints whose motors it moves; None for all
    smooth: bool = False  # whether its torque is no more abrupt than the motion
    # how large its coefficients are expected to be beside the first, where physics gives it
    proportion: tuple[float, ...] | None = None
    cancels: bool = False  # whether coefficients may far exceed what they give together
    size: float = np.inf  # torque over the joint's usual one, if its cause gives it [-]
    led: int = 0  # leading coefficients without any of which it is not there
    # mean and deviation of each coefficient, where physics gives its size; infinite of those that may give
    # as much torque as the joint usually has
    expected: tuple[tuple[float, float], ...] | None = None
    among: int = 1  # number of shapes of which it is the choice of a quick look
    prior: float = 1.0  # how much likelier than others before the data [-]
    most: float = np.inf  # largest coefficient for which its columns are right
    everywhere: bool = False  # whether every joint must be predicted better
    covers: bool = False  # whether it holds the same effect of each joint: none is asked for beside it
    # name and joints of what it is with other effects, all of which have the same torque
    same_torque: tuple[str, tuple[int, ...]] | None = None
    kind: str = ""  # what sets it apart from others of its effect, as frequencies of ripple
    # what follows from the shape, in the field's words: name -> value and unit
    reported: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    reported_as: Reported = as_fitted  # how its coefficients are reported
    # standard deviations of what was measured otherwise
    known: Mapping[str, float] = field(default_factory=dict)
    loaded: bool = False  # whether columns depend on motors' torque or gears' load
    carried: bool = False  # whether gears transmit its torque
    reloads: bool = False  # whether all motors' torque is fitted anew beside it
    by_run: bool = False  # whether each fitted run has coefficients of its own, so that no other run shows it
    listed: bool = True  # whether the vocabulary has a name for it
    span: float = 0.0  # least range of its first joint's position that shows it [rad]
    gear_ratio: float = 1.0  # of its first joint; 1 if not given [-]

    @property
    def key(self) -> tuple[str, tuple[int, ...], str]:
        """What it is and where; shapes of one key are one hypothesis."""
        return self.effect, self.joints, self.kind

    def covered(self, others: Iterable["Candidate"]) -> bool:
        """Whether one of some others holds this effect of its joints already."""
        return any(other.covers and other.effect == self.effect and self.joints for other in others)

    def reshaped(self, shape: Mapping[str, float]) -> "Candidate":
        """The same hypothesis in another shape: what identifies it never depends on the shape."""
        if self.reshape is None:
            raise TypeError(f"{self.effect} has no shape")
        return replace(self.reshape(shape), effect=self.effect, joints=self.joints, kind=self.kind)

    @property
    def which(self) -> str:
        """What sets it apart from others of its effect on its joints, in words: its shape, or its kind."""
        numbers = ((name, value) for name, value in self.shape.items() if name != "reversal")
        return ", ".join(f"{name} {digits(value, 3)}" for name, value in numbers) or self.kind


@dataclass(frozen=True, eq=False)
class Thinned:
    """Columns of a candidate over all runs."""

    joints: np.ndarray  # those it gives torque to, shape (k,)
    values: np.ndarray  # shape (r, k, p)
    std: np.ndarray  # how large each coefficient is expected to be, shape (p,)
    mean: np.ndarray  # about what, shape (p,); zero where the size of an effect is unknown
    usual: np.ndarray | None = None  # RMS torque of its joints, shape (k,) [N m]; None where it is no torque

    @classmethod
    def of(cls, candidate: Candidate, runs: Sequence[Driven]) -> "Thinned":
        """Columns as they are compared."""
        dof = runs[0].torque.shape[1]
        joints = np.array(range(dof) if candidate.rows is None else candidate.rows)
        nothing = cls(joints[:0], np.zeros((0, 0, 0)), np.zeros(0), np.zeros(0))
        if candidate.span and _span(candidate, runs) < candidate.span:
            return nothing
        try:
            given = [run.coarse if candidate.smooth else run for run in runs]
            thinned = [run.thinned(_of_joints(candidate.columns(run), joints)) for run in given]
        except NotRecorded:
            return nothing
        # Each column's rows lie side by side, as they are summed.
        values = np.concatenate([np.moveaxis(part, 0, -1) for part in thinned], axis=-1)
        values = np.moveaxis(values, -1, 0)
        usual = np.sqrt(np.mean(np.concatenate([run.torque[:, joints] ** 2 for run in runs]), axis=0))
        strength = np.sqrt(np.mean(values**2, axis=0))
        # A coefficient is as large as the joint that it moves most allows.
        share = np.max(strength / np.maximum(usual[:, None], np.finfo(float).tiny), axis=0, initial=0.0)
        if candidate.expected is not None:
            mean, deviation = np.array(candidate.expected).T
            std = np.where(np.isfinite(deviation), deviation, 1.0 / np.maximum(share, 1e-12))
            return cls(joints, values, std, mean)
        std = SIZE / np.maximum(share, 1e-12)
        if candidate.proportion is not None:
            together = np.array(candidate.proportion)
            std = SIZE / max(float(np.max(share * together)), 1e-12) * together
        return cls(joints, values, std, np.zeros(len(std)), usual)

    @property
    def whole(self) -> np.ndarray:
        """Which coefficients are known beforehand, (p,): an effect that is there whole or not at all."""
        return self.std < KNOWN * np.abs(self.mean)

    @property
    def empty(self) -> bool:
        """Whether the runs contain nothing of it."""
        return not len(self.joints) or not np.all(np.isfinite(self.values))

    def everywhere(self, dof: int) -> np.ndarray:
        """Columns of all joints, shape (r, n, p)."""
        whole = np.zeros((len(self.values), dof, self.values.shape[2]))
        whole[:, self.joints] = self.values
        return whole


def _of_joints(columns: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Columns (t, n, p) of some joints, without a copy where those are all."""
    return columns if len(joints) == columns.shape[1] else columns[:, joints]


def _span(candidate: Candidate, runs: Sequence[Driven]) -> float:
    """Range of the position of its first joint over all runs [rad]; without a joint, any."""
    if not candidate.joints:
        return float("inf")
    return float(np.ptp(np.concatenate([run.motion.position[:, candidate.joints[0]] for run in runs])))
