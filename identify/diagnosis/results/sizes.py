"""Sizes: torque of each finding with its interval, and which of its numbers the data do not determine."""

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
"""Share of the rows that a torque is the mean of [-]."""
FEWEST = 5
"""Rows that it is the mean of, at least."""
BINS = 16
"""Of a curve."""
FOLLOWS = 0.1
"""Share of a torque's square that may differ from its curve over what it depends on [-]."""
TOGETHER = 0.25
"""Variance that is left of a number once another is known, over what it was, up to which the two change
together [-]: its interval is half as wide then."""
MUCH = 0.25
"""Share of an effect's torque from which on it matters that a number's sign is not known [-]."""
SIZES, SIGNED = ("smallest", "usual", "largest"), ("lowest", "middle", "highest")


class Own(NamedTuple):
    """What is a finding's own among all unknowns.

    Attributes:
        place: Index of the finding.
        joint: On which it shows best.
        unknowns: Their places, coefficients before the numbers of its shape, shape (q,).
        names: Of these, (q,).
        values: Its coefficients, shape (p,).
    """

    place: int
    joint: int
    unknowns: np.ndarray
    names: tuple[str, ...]
    values: np.ndarray

    @property
    def shape(self) -> tuple[str, ...]:
        """Numbers of its shape that may be refined."""
        return self.names[len(self.values) :]


def own_of(result: SearchResult, spread: Spread, place: int) -> Own:
    """Unknowns of one finding."""
    answer, (unknowns, names) = result.selected[place].answer, spread.of(result, place)
    values = result.prediction.values[places_of(result, place)]
    return Own(place, int(np.argmax(answer.by_joint)), unknowns, (*answer.candidate.names, *names), values)


def size(result: SearchResult, spread: Spread, traces: Sequence[Trace], place: int) -> Size | None:
    """Size of a finding; None of what is there whole or not at all.

    Args:
        result: The search that found it.
        spread: Covariance of all unknowns.
        traces: Traces of the fitted runs, in order.
        place: Index of the finding.
    """
    answer, own = result.selected[place].answer, own_of(result, spread, place)
    if np.all(answer.columns.whole):
        return None
    runs = result.problem.fitted
    slopes = np.concatenate([_slopes(answer.candidate, own, run) for run in runs])
    covariance = spread.covariance[np.ix_(own.unknowns, own.unknowns)]
    axes = kind_of(answer.candidate.effect).drawn_against
    sizes = (_over(name, slopes, own, covariance, traces) for name in axes)
    first = next((size for size in sizes if size is not None), Size(own.joint, 0.0, 0.0))
    rms, std = _beside(spread, own, covariance, sum(run.rows for run in runs))
    return replace(first, beside_rms=rms, beside_std=std)


def _slopes(candidate: Candidate, own: Own, run: Driven) -> np.ndarray:
    """Torque by a little more of each unknown as the formula gives it, without a filter, shape (r, q)."""

    def torque(shaped: Candidate) -> np.ndarray:
        return np.asarray(shaped.columns(run)[run.centres][:, own.joint])

    parts = [torque(candidate)]
    for name in own.shape:
        less, more, apart = around(candidate, name)
        parts.append(((torque(more) - torque(less)) @ own.values / apart)[:, None])
    return np.concatenate(parts, axis=1)


class _Along(NamedTuple):
    """Torque along an axis, of the rows in which the joint does not stick.

    Attributes:
        x: Values of the axis, shape (r,).
        slopes: Torque by a little more of each unknown, shape (r, q); against the motion where that is drawn.
        bins: Rows of the curve.
    """

    x: np.ndarray
    slopes: np.ndarray
    bins: list[np.ndarray]

    @classmethod
    def of(cls, axis: Axis, slopes: np.ndarray, joint: int, traces: Sequence[Trace]) -> "_Along":
        """By the traces of the rows that have these slopes (r, q)."""
        x = np.concatenate([axis.values(trace, joint) for trace in traces])
        velocity = np.concatenate([trace.velocity[:, joint] for trace in traces])
        slides = np.concatenate([trace.weight[:, joint] for trace in traces]) > 0
        used = slides & np.isfinite(x) & np.all(np.isfinite(slopes), axis=1)
        turned = slopes * np.sign(velocity)[:, None] if axis.braking else slopes
        return cls(x[used], turned[used], _bins(x[used]))

    def means(self, groups: Sequence[np.ndarray]) -> tuple[list[float], np.ndarray]:
        """Of axis and slopes over some rows each."""
        at = [float(self.x[rows].mean()) for rows in groups]
        return at, np.array([self.slopes[rows].mean(axis=0) for rows in groups])

    def followed(self, values: np.ndarray) -> bool:
        """Whether the torque by coefficients (p,) is that of its curve."""
        torque = self.slopes[:, : len(values)] @ values
        apart = sum(len(rows) * float(np.var(torque[rows])) for rows in self.bins)
        return apart <= FOLLOWS * float(np.sum(torque**2))


def _over(
    name: str, slopes: np.ndarray, own: Own, covariance: np.ndarray, traces: Sequence[Trace]
) -> Size | None:
    """Size over one axis; None where the torque does not follow that."""
    axis = AXES[name]
    along = _Along.of(axis, slopes, own.joint, traces)
    if len(along.x) < FEWEST or not along.followed(own.values):
        return None
    places, at = along.means([_nearest(along.x, target) for target in _targets(along.x, axis)])
    middles, curve = along.means(along.bins)
    last, apart = (_variance(row, covariance) for row in (at[-1:], at[-1:] - at[0]))
    if change := bool(apart[0] < TOGETHER * last[0]):
        curve, at = curve - at[0], at - at[0]
    which = SIZES if axis.size else SIGNED
    points = _points(which, places, at, own, covariance)
    drawn = _points(("",) * len(middles), middles, curve, own, covariance)
    return Size(own.joint, 0.0, 0.0, name, points, drawn, change)


def _bins(x: np.ndarray) -> list[np.ndarray]:
    """Rows of bins that have as many each."""
    return np.array_split(np.argsort(x, kind="stable"), int(np.clip(len(x) // FEWEST, 1, BINS)))


def _targets(x: np.ndarray, axis: Axis) -> tuple[float, ...]:
    if axis.size:
        return float(x.min()), float(np.sqrt(np.mean(x**2))), float(x.max())
    return float(x.min()), float(np.median(x)), float(x.max())


def _nearest(x: np.ndarray, target: float) -> np.ndarray:
    """Rows whose value is nearest."""
    return np.argsort(np.abs(x - target), kind="stable")[: max(FEWEST, int(NEAR * len(x)))]


def _points(
    which: Sequence[str], at: Sequence[float], slopes: np.ndarray, own: Own, covariance: np.ndarray
) -> tuple[Point, ...]:
    """Torque with its deviation where slopes are (k, q)."""
    torque = slopes[:, : len(own.values)] @ own.values
    std = np.sqrt(_variance(slopes, covariance))
    rows = zip(which, at, torque.tolist(), std.tolist(), strict=True)
    return tuple(Point(*row) for row in rows)


def _variance(slopes: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Of the torque where slopes are (k, q), shape (k,)."""
    return np.maximum(np.einsum("kp,pq,kq->k", slopes, covariance, slopes), 0.0)


def _beside(spread: Spread, own: Own, covariance: np.ndarray, rows: int) -> tuple[float, float]:
    """Root mean square of what no other parameter takes over, fitted anew, and its deviation [N m]."""
    rows_of_all, normal = spread.prediction.rows, spread.prediction.normal[0]
    columns, weight = rows_of_all.columns[:rows, own.joint], rows_of_all.weight[:rows, own.joint]
    others = np.setdiff1d(np.arange(len(normal)), own.unknowns)
    absorbed = solve(factored(normal[np.ix_(others, others)]), normal[np.ix_(others, own.unknowns)])
    slopes = (columns[:, own.unknowns] - columns[:, others] @ absorbed) * weight[:, None]
    torque, count = slopes[:, : len(own.values)] @ own.values, max(float(weight.sum()), 1.0)
    value = float(np.sqrt(np.sum(torque**2) / count))
    slope = slopes.T @ torque / max(count * value, np.finfo(float).tiny)
    return value, float(np.sqrt(max(slope @ covariance @ slope, 0.0)))


def left_out(
    result: SearchResult, spread: Spread, place: int, parameters: Mapping[str, Quantity]
) -> dict[str, LeftOut]:
    """Numbers of a finding that are no size: zero is within their interval, and others change with them.

    They do where that 95 % interval alone is more than a quarter of the effect's torque, or twice what is
    uncertain of it.
    """
    own, prediction = own_of(result, spread, place), spread.prediction
    rows = sum(run.rows for run in result.problem.fitted)
    columns = prediction.rows.columns[:rows][:, :, own.unknowns]
    covariance = spread.covariance[np.ix_(own.unknowns, own.unknowns)]
    torques = columns[:, :, : len(own.values)] @ own.values
    [torque] = rms_torque(torques[:, :, None])
    uncertain = np.sqrt(np.einsum("rnp,pq,rnq->", columns, covariance, columns) / max(rows, 1))
    alone = np.sqrt(np.diag(covariance)) * rms_torque(columns)
    unknown = (NORMAL_95 * alone > MUCH * torque) | (TOGETHER * alone**2 > uncertain**2)
    numbers = {
        name: _beside_what(result, spread, own, int(unknown_place))
        for name, open_, unknown_place in zip(own.names, unknown, own.unknowns, strict=True)
        if open_
    }
    # What follows from a shape is not determined where its sign is not, unless it is small beside its like.
    numbers |= {
        name: LeftOut()
        for name in result.selected[place].answer.candidate.reported
        if name in parameters and _wide(parameters[name], parameters.values())
    }
    known = {name: sign_known(number.value, number.std) for name, number in parameters.items()}
    return {name: why for name, why in numbers.items() if name in known and not known[name]}


def _wide(number: Quantity, numbers: Iterable[Quantity]) -> bool:
    """Whether its interval is much of the largest number of its unit, as of a vector's components."""
    largest = max(abs(number.value) for number in numbers if number.unit == number.unit)
    return not NORMAL_95 * number.std < MUCH * largest


def _beside_what(result: SearchResult, spread: Spread, own: Own, unknown: int) -> LeftOut:
    """The parameter that changes with an unknown."""
    covariance = solve(spread.prediction.factor, np.eye(len(spread.prediction.rows.names)))
    variance = np.maximum(np.diag(covariance), np.finfo(float).tiny)
    common = covariance[unknown] ** 2 / (variance * variance[unknown])
    common[unknown] = 0.0
    other = int(np.argmax(common))
    name = dict(zip(own.unknowns, own.names, strict=True)).get(other, spread.prediction.rows.names[other])
    if 1.0 - common[other] > TOGETHER or name.startswith(UNNAMED):
        return LeftOut()
    return LeftOut(name, "" if other in own.unknowns else _effect_of(result, spread, other))


def _effect_of(result: SearchResult, spread: Spread, unknown: int) -> str:
    """What an unknown is a parameter of; empty for what is of no effect."""
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
