"""Sizes: torque of each finding with its interval, and the parameters that the data do not determine."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...effects import name_of
from ...positive_definite import solve
from ...quantity import Quantity
from ...text_table import NORMAL_95
from ..blocks.prediction import factored, rms_torque
from ..candidates import kind_of
from ..findings.axes import AXES, Axis
from ..findings.evidence import Trace
from ..findings.size import LeftOut, Point, Size, sign_known
from ..questions.candidate import UNNAMED, Candidate
from ..runs.driven import Driven
from ..search.search import SearchResult
from .evidence import Spread, around, places_of

NEAR = 0.02
"""Share of the rows over which a torque is averaged [-]."""
FEWEST = 5
"""Smallest number of rows over which a torque is averaged."""
BINS = 16
"""Largest number of bins of a curve."""
FOLLOWS = 0.1
"""Largest share of the squared torque that may deviate from its curve over an axis [-]."""
TOGETHER = 0.25
"""Variance of a number given another one, relative to its full variance, up to which the two count as
correlated [-]: the interval is then at most half as wide."""
MUCH = 0.25
"""Share of an effect's torque above which a parameter of unknown sign matters [-]."""
SIZES, SIGNED = ("smallest", "usual", "largest"), ("lowest", "middle", "highest")


class FindingUnknowns(NamedTuple):
    """Unknowns of one finding among all unknowns."""

    joint: int  # index of the joint on which it acts that shows it best, from 0
    unknowns: np.ndarray  # indices of its unknowns, coefficients before shape numbers, shape (q,)
    names: tuple[str, ...]  # names of its unknowns, length q
    values: np.ndarray  # coefficients, shape (p,)

    @property
    def shape(self) -> tuple[str, ...]:
        """Names of the shape numbers that may be refined."""
        return self.names[len(self.values) :]


def unknowns_of(result: SearchResult, spread: Spread, place: int) -> FindingUnknowns:
    """Unknowns of one finding."""
    answer, (unknowns, names) = result.selected[place].answer, spread.of(result, place)
    values, acting = result.prediction.values[places_of(result, place)], answer.columns.joints
    # Another joint may show it better, without a torque of it.
    joint = int(acting[np.argmax(answer.by_joint[acting])])
    return FindingUnknowns(joint, unknowns, (*answer.candidate.names, *names), values)


def size(result: SearchResult, spread: Spread, traces: Sequence[Trace], place: int) -> Size | None:
    """Size of a finding; None for an effect that is either completely present or absent."""
    answer, finding = result.selected[place].answer, unknowns_of(result, spread, place)
    if np.all(answer.columns.whole):
        return None
    runs = result.problem.fitted
    slopes = np.concatenate([_slopes(answer.candidate, finding, run) for run in runs])
    covariance = spread.covariance[np.ix_(finding.unknowns, finding.unknowns)]
    axes = kind_of(answer.candidate.effect).drawn_against
    sizes = (_over(name, slopes, finding, covariance, traces) for name in axes)
    first = next((size for size in sizes if size is not None), Size(finding.joint, 0.0, 0.0))
    rms, std = _beside(spread, finding, covariance, sum(run.rows for run in runs))
    return replace(first, beside_rms=rms, beside_std=std)


def _slopes(candidate: Candidate, finding: FindingUnknowns, run: Driven) -> np.ndarray:
    """Derivative of the unfiltered torque by each unknown, shape (r, q)."""

    def torque(shaped: Candidate) -> np.ndarray:
        return np.asarray(shaped.columns(run)[run.centres][:, finding.joint])

    parts = [torque(candidate)]
    for name in finding.shape:
        less, more, apart = around(candidate, name)
        parts.append(((torque(more) - torque(less)) @ finding.values / apart)[:, None])
    return np.concatenate(parts, axis=1)


class _Along(NamedTuple):
    """Torque along an axis, in the rows in which the joint does not stick."""

    x: np.ndarray  # values of the axis, shape (r,)
    # derivative of the torque by each unknown, shape (r, q); positive against the motion if the axis is
    # `braking`
    slopes: np.ndarray
    bins: list[np.ndarray]  # indices of the rows in each bin of the curve

    @classmethod
    def of(cls, axis: Axis, slopes: np.ndarray, joint: int, traces: Sequence[Trace]) -> "_Along":
        """Rows of the traces, which have these slopes (r, q)."""
        x = np.concatenate([axis.values(trace, joint) for trace in traces])
        velocity = np.concatenate([trace.velocity[:, joint] for trace in traces])
        slides = np.concatenate([trace.weight[:, joint] for trace in traces]) > 0
        used = slides & np.isfinite(x) & np.all(np.isfinite(slopes), axis=1)
        turned = slopes * np.sign(velocity)[:, None] if axis.braking else slopes
        x, turned = x[used], turned[used]
        # bins of equal size
        bins = np.array_split(np.argsort(x, kind="stable"), int(np.clip(len(x) // FEWEST, 1, BINS)))
        return cls(x, turned, bins)

    def means(self, groups: Sequence[np.ndarray]) -> tuple[list[float], np.ndarray]:
        """Means of axis values and slopes over each group of rows."""
        at = [float(self.x[rows].mean()) for rows in groups]
        return at, np.array([self.slopes[rows].mean(axis=0) for rows in groups])

    def followed(self, values: np.ndarray) -> bool:
        """Whether the torque for these coefficients (p,) follows its curve."""
        torque = self.slopes[:, : len(values)] @ values
        apart = sum(len(rows) * float(np.var(torque[rows])) for rows in self.bins)
        return apart <= FOLLOWS * float(np.sum(torque**2))


def _over(
    name: str, slopes: np.ndarray, finding: FindingUnknowns, covariance: np.ndarray, traces: Sequence[Trace]
) -> Size | None:
    """Size over one axis; None if the torque does not follow that axis."""
    axis = AXES[name]
    along = _Along.of(axis, slopes, finding.joint, traces)
    if len(along.x) < FEWEST or not along.followed(finding.values):
        return None
    places, at = along.means([_nearest(along.x, target) for target in _targets(along.x, axis)])
    middles, curve = along.means(along.bins)
    last, apart = (_variance(row, covariance) for row in (at[-1:], at[-1:] - at[0]))
    if change := bool(apart[0] < TOGETHER * last[0]):
        curve, at = curve - at[0], at - at[0]
    labels = SIZES if axis.size else SIGNED
    points = _points(labels, places, at, finding, covariance)
    drawn = _points(("",) * len(middles), middles, curve, finding, covariance)
    return Size(finding.joint, 0.0, 0.0, name, points, drawn, change)


def _targets(x: np.ndarray, axis: Axis) -> tuple[float, ...]:
    if axis.size:
        return float(x.min()), float(np.sqrt(np.mean(x**2))), float(x.max())
    return float(x.min()), float(np.median(x)), float(x.max())


def _nearest(x: np.ndarray, target: float) -> np.ndarray:
    """Indices of the rows with the nearest values."""
    return np.argsort(np.abs(x - target), kind="stable")[: max(FEWEST, int(NEAR * len(x)))]


def _points(
    labels: Sequence[str],
    at: Sequence[float],
    slopes: np.ndarray,
    finding: FindingUnknowns,
    covariance: np.ndarray,
) -> tuple[Point, ...]:
    """Points with torque and standard deviation for slopes (k, q)."""
    torque = slopes[:, : len(finding.values)] @ finding.values
    std = np.sqrt(_variance(slopes, covariance))
    rows = zip(labels, at, torque.tolist(), std.tolist(), strict=True)
    return tuple(Point(*row) for row in rows)


def _variance(slopes: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Variance of the torque for slopes (k, q), shape (k,)."""
    return np.maximum(np.einsum("kp,pq,kq->k", slopes, covariance, slopes), 0.0)


def _beside(
    spread: Spread, finding: FindingUnknowns, covariance: np.ndarray, rows: int
) -> tuple[float, float]:
    """RMS torque that no other parameter can absorb in a new fit, and its standard deviation [N m]."""
    rows_of_all, normal = spread.prediction.rows, spread.prediction.normal[0]
    columns, weight = rows_of_all.columns[:rows, finding.joint], rows_of_all.weight[:rows, finding.joint]
    others = np.setdiff1d(np.arange(len(normal)), finding.unknowns)
    absorbed = solve(factored(normal[np.ix_(others, others)]), normal[np.ix_(others, finding.unknowns)])
    slopes = (columns[:, finding.unknowns] - columns[:, others] @ absorbed) * weight[:, None]
    torque, count = slopes[:, : len(finding.values)] @ finding.values, max(float(weight.sum()), 1.0)
    value = float(np.sqrt(np.sum(torque**2) / count))
    slope = slopes.T @ torque / max(count * value, np.finfo(float).tiny)
    return value, float(np.sqrt(max(slope @ covariance @ slope, 0.0)))


def left_out(
    result: SearchResult, spread: Spread, place: int, parameters: Mapping[str, Quantity]
) -> dict[str, LeftOut]:
    """Parameters of a finding whose interval contains zero and that are correlated with others, with reasons.

    A parameter counts as correlated if the torque of its 95 % interval alone exceeds a quarter of the
    effect's torque, or twice the uncertainty of that torque.
    """
    finding, prediction = unknowns_of(result, spread, place), spread.prediction
    rows = sum(run.rows for run in result.problem.fitted)
    columns = prediction.rows.columns_at(finding.unknowns)[:rows]
    covariance = spread.covariance[np.ix_(finding.unknowns, finding.unknowns)]
    torques = columns[:, :, : len(finding.values)] @ finding.values
    [torque] = rms_torque(torques[:, :, None])
    uncertain = np.sqrt(np.einsum("rnp,pq,rnq->", columns, covariance, columns) / max(rows, 1))
    # Over all likely shapes, a number may be less certain than near the best one.
    known_std = [parameters[name].std if name in parameters else 0.0 for name in finding.names]
    alone = np.fmax(np.sqrt(np.diag(covariance)), known_std) * rms_torque(columns)
    unknown = (NORMAL_95 * alone > MUCH * torque) | (TOGETHER * alone**2 > uncertain**2)
    numbers = {
        name: _beside_what(result, spread, finding, int(unknown_place))
        for name, open_, unknown_place in zip(finding.names, unknown, finding.unknowns, strict=True)
        if open_
    }
    # A derived result of unknown sign is not determined, unless its interval is small among its kind.
    numbers |= {
        name: LeftOut()
        for name in result.selected[place].answer.candidate.reported
        if name in parameters and _wide(parameters[name], parameters.values())
    }
    known = {name: sign_known(number.value, number.std) for name, number in parameters.items()}
    return {name: reason for name, reason in numbers.items() if name in known and not known[name]}


def _wide(number: Quantity, numbers: Iterable[Quantity]) -> bool:
    """Whether an interval is wide relative to the largest number of its kind, such as vector components."""
    largest = max(abs(other.value) for other in numbers if other.unit == number.unit)
    return not NORMAL_95 * number.std < MUCH * largest


def _beside_what(result: SearchResult, spread: Spread, finding: FindingUnknowns, unknown: int) -> LeftOut:
    """The parameter that is most correlated with an unknown."""
    covariance = solve(spread.prediction.factor, np.eye(len(spread.prediction.rows.names)))
    variance = np.maximum(np.diag(covariance), np.finfo(float).tiny)
    common = covariance[unknown] ** 2 / (variance * variance[unknown])
    common[unknown] = 0.0
    other = int(np.argmax(common))
    name = dict(zip(finding.unknowns, finding.names, strict=True)).get(
        other, spread.prediction.rows.names[other]
    )
    if 1.0 - common[other] > TOGETHER or name.startswith(UNNAMED):
        return LeftOut()
    return LeftOut(name, "" if other in finding.unknowns else _effect_of(result, spread, other))


def _effect_of(result: SearchResult, spread: Spread, unknown: int) -> str:
    """Effect to which an unknown belongs; empty if it belongs to none."""
    for place, selected in enumerate(result.selected):
        if unknown in spread.of(result, place)[0]:
            return selected.answer.candidate.effect
    name, model = spread.prediction.rows.names[unknown], result.problem.model
    effects = {
        parameter.name: name_of(effect)
        for effect in model.effects
        for parameter in effect.parameters(model.robot)
    }
    return effects.get(name, "")
