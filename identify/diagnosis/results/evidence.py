"""Evidence: traces of all runs from the result of a search, and standard deviations of findings."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...effects.torque_curve import ABSCISSAE, SPLINES
from ...model import Model
from ...positive_definite import NOTHING, solve
from ..blocks.prediction import Prediction, factored
from ..candidates import dependence_of
from ..findings.evidence import Evidence, Trace
from ..questions.block_answer import prior_std
from ..questions.candidate import Candidate, Thinned
from ..questions.candidate_fit import FORMULA
from ..runs.driven import Driven
from ..runs.rows import CLOCK, GAIN, Rows
from ..search.search import SearchResult
from .other_shapes import deviations_over_shapes


def evidence(result: SearchResult, baseline: Prediction, noise: np.ndarray) -> Evidence:
    """Evidence of a diagnosis, held-out runs first; `noise` is the noise floor of each joint (n,) [N m]."""
    model, fitted = result.problem.model, _with_phases(result)
    rows, count = result.prediction.rows, len(model.names)
    remaining, parts = rows.difference - rows.torque(fitted), explained(result, rows, fitted)
    traces = []
    for run, places in zip(result.problem.runs, rows.runs, strict=True):
        weight = result.problem.base.weight[places]
        residuals = baseline.residual[places], remaining[places], parts[:, places], weight
        traces.append(_trace(model, run, *residuals))
    fitted_runs = len(result.problem.fitted)
    return Evidence(
        model=model,
        before=model.nominal_values + baseline.values[:count],
        after=model.nominal_values + fitted[:count],
        gain_before=_gains(result, baseline),
        gain_after=_gains(result, result.prediction),
        noise=noise,
        traces=(*traces[fitted_runs:], *traces[:fitted_runs]),
        filtering=result.problem.runs[0].filtering,
        peak=np.max([run.most for run in result.problem.fitted], axis=0),
    )


def _with_phases(result: SearchResult) -> np.ndarray:
    """Unknowns (b,) of the fit, with those that each run has to itself fitted to the held-out runs too."""
    values, rows = np.array(result.prediction.values), result.prediction.rows
    weight = rows.weight * ~result.problem.blocks.fitted[result.problem.blocks.number][:, None]
    for place, selected in enumerate(result.selected):
        unknowns = places_of(result, place)
        columns = (rows.columns_at(unknowns) * weight[:, :, None]).reshape(-1, len(unknowns))
        shown = np.any(columns, axis=0) & selected.answer.candidate.by_run
        residual = ((rows.difference - rows.torque(values)) * weight).ravel()
        values[unknowns[shown]] += np.linalg.lstsq(columns[:, shown], residual, rcond=None)[0]
    return values


def places_of(result: SearchResult, place: int) -> np.ndarray:
    """Indices of the coefficients of a finding among all unknowns."""
    counts = [len(selected.answer.values) for selected in result.selected]
    start = len(result.prediction.rows.names) - sum(counts[place:])
    return np.arange(start, start + counts[place])


def explained(result: SearchResult, rows: Rows, values: np.ndarray) -> np.ndarray:
    """Torque of each finding for these unknowns (b,), shape (f, r, n) [N m]."""
    unknowns = [places_of(result, place) for place in range(len(result.selected))]
    parts = [rows.columns_at(places) @ values[places] for places in unknowns]
    return np.array(parts).reshape(len(parts), *rows.difference.shape)


def _gains(result: SearchResult, prediction: Prediction) -> np.ndarray:
    """Drive gains (n,) of a prediction, whose unknowns are the shares of torque that nominal gains lack."""
    nominal = result.problem.runs[0].prepared.gain
    places = dict(zip(prediction.rows.names, prediction.values, strict=True))
    lacking = np.array([places.get(f"{GAIN}{joint + 1}", 0.0) for joint in range(len(nominal))])
    return nominal / (1.0 - lacking)


def _trace(
    model: Model, run: Driven, before: np.ndarray, after: np.ndarray, parts: np.ndarray, weight: np.ndarray
) -> Trace:
    prepared, robot, motion, places = run.prepared, model.robot, run.motion, run.centres
    return Trace(
        name=prepared.name,
        role=run.role,
        time=motion.time[places],
        position=motion.position[places],
        velocity=motion.velocity[places],
        acceleration=motion.acceleration[places],
        load=motion.load[places],
        temperature=motion.temperature[places],
        motor_angle=motion.position[places] @ robot.coupling.T * robot.gear_ratio,
        measured=prepared.gain * prepared.decimated_current[: run.rows],
        before=before,
        after=after,
        explained=parts,
        weight=weight,
    )


STEP = 0.02
"""Step of finite differences, relative to a number or to the range of its bounds [-]."""


class Spread(NamedTuple):
    """Joint covariance of all unknowns, including the numbers of shapes."""

    # prediction with all findings, with the derivative by each shape number as a column
    prediction: Prediction
    # index of the finding and name of each shape number; their unknowns are the last
    shapes: tuple[tuple[int, str], ...]
    covariance: np.ndarray  # covariance of all unknowns, shape (b, b)

    def of(self, result: SearchResult, place: int) -> tuple[np.ndarray, tuple[str, ...]]:
        """Indices of the unknowns of a finding, coefficients first, and names of its shape numbers."""
        first = len(self.prediction.rows.names) - len(self.shapes)
        behind = [first + k for k, (finding, _) in enumerate(self.shapes) if finding == place]
        names = tuple(name for finding, name in self.shapes if finding == place)
        return np.append(places_of(result, place), behind).astype(int), names


def with_shapes(result: SearchResult) -> Spread:
    """The prediction of a search, with unknowns for all shape numbers that may be refined.

    An unknown at a physical limit is as uncertain as without that limit; its interval ends at the limit.
    """
    ranges = [selected.answer.candidate.bounds for selected in result.selected]
    numbers = tuple(
        (place, name)
        for place, shape in enumerate(ranges)
        for name, (_, low, high) in shape.items()
        if high > low  # equal bounds: the preload of a joint without load
    )
    prediction, std = result.prediction, _unlimited(result)
    rows = replace(prediction.rows, std=std)
    if numbers:
        columns = np.stack([_more(result, place, name) for place, name in numbers], axis=2)
        # Uniform prior within the bounds.
        bounds = [ranges[place][name] for place, name in numbers]
        spread = np.array([(shape.high - shape.low) / np.sqrt(12.0) for shape in bounds])
        rows = rows.plus([name for _, name in numbers], columns, spread)
    if numbers or not np.array_equal(std, prediction.rows.std):
        prediction = Prediction.of(rows, prediction.blocks, prediction.rate)
    of_all = Spread(prediction, numbers, _covariance(result, prediction))
    for place, selected in enumerate(result.selected):
        if ranges[place] and dependence_of(selected.answer.candidate) not in ABSCISSAE:
            _add_formula_error(result, of_all, place)
    return of_all


def _add_formula_error(result: SearchResult, spread: Spread, place: int) -> None:
    """Add the error of a finding's formula to its covariance, unless that is among the unknowns as a curve.

    It is alike in all blocks, so their scatter does not show it. As in a curve, it has `SPLINES` parts,
    and each number alone may explain one of them.
    """
    prediction, (unknowns, _), own = spread.prediction, spread.of(result, place), places_of(result, place)
    rows, weight = prediction.rows, prediction.weighting.weight[prediction.blocks.number]
    torque = rows.columns_at(own) @ result.prediction.values[own]
    part = FORMULA**2 * np.sum(weight * torque**2) / SPLINES
    slopes = np.einsum("rnq,rn->q", rows.columns_at(unknowns) ** 2, weight)
    spread.covariance[unknowns, unknowns] += 1.0 / (slopes / max(part, NOTHING) + rows.std[unknowns] ** -2.0)


def _unlimited(result: SearchResult) -> np.ndarray:
    """Prior standard deviation of each unknown without physical limits, shape (b,)."""
    std = np.array(result.prediction.rows.std)
    for place, selected in enumerate(result.selected):
        answer = selected.answer
        if selected.once:  # its time is excluded
            continue
        held = places_of(result, place)[~answer.free]
        std[held] = prior_std(answer.candidate, answer.columns)[~answer.free]
    return std


PARTS = 4.0
"""Least number of independent rows of a contact: its window is found to a quarter of its duration, so its
residual has that many independent parts."""


def _covariance(result: SearchResult, prediction: Prediction) -> np.ndarray:
    """Covariance of all unknowns (b, b); that of a contact comes from the residual of its excluded rows."""
    covariance = np.array(prediction.covariance)
    for place, selected in enumerate(result.selected):
        places = places_of(result, place)
        columns = prediction.rows.columns_at(places)
        aside = result.problem.base.weight * np.any(columns, axis=2) if selected.once else np.zeros((1, 1))
        if not np.any(aside * (prediction.rows.weight == 0.0)):  # not a contact, or measured by other signals
            continue
        noise = prediction.weighting.variance / prediction.weighting.independent
        # as if there were `PARTS` rows
        unexplained = np.sum(aside * result.prediction.residual**2, axis=0) / PARTS
        weight = aside / np.maximum(noise, unexplained)
        gram = np.einsum("rnp,rn,rnq->pq", columns, weight, columns)
        covariance[np.ix_(places, places)] = solve(factored(gram), np.eye(len(places)))
    return covariance


def deviations(
    result: SearchResult, spread: Spread | None = None
) -> list[tuple[np.ndarray, dict[str, float]]]:
    """Standard deviations of each finding: coefficients (p,), and shape numbers by name.

    Each is that near the best shape, or the deviation over all likely shapes if that is larger.
    """
    spread = spread or with_shapes(result)
    near, fixed = (
        np.sqrt(np.diag(covariance)) for covariance in (spread.covariance, result.prediction.covariance)
    )
    deviations_of_all = []
    for place, selected in enumerate(result.selected):
        candidate, (unknowns, names) = selected.answer.candidate, spread.of(result, place)
        over, shape_over = deviations_over_shapes(result, place)
        count = len(over)
        std = np.maximum(near[unknowns[:count]], np.hypot(fixed[unknowns[:count]], over))
        shape = dict(zip(names, near[unknowns[count:]].tolist(), strict=True))
        shape = {name: max(shape.get(name, 0.0), shape_over[name]) for name in candidate.bounds}
        expected = selected.answer.columns.mean
        share = float(np.linalg.norm(std[expected != 0.0] / expected[expected != 0.0]))
        deviations_of_all.append((std, shape | _of_reported(candidate, shape, share)))
    return deviations_of_all


def _of_reported(candidate: Candidate, std: Mapping[str, float], share: float) -> dict[str, float]:
    """Standard deviations of results derived from the shape, whose torque has the relative std `share`."""
    changes = {name: (share * value) ** 2 for name, (value, _) in candidate.reported.items()}
    for name, deviation in std.items():
        low, high = (_shaped(candidate, name, sign * deviation * STEP) for sign in (-1, 1))
        for quantity in changes:
            changes[quantity] += ((high.reported[quantity][0] - low.reported[quantity][0]) / (2 * STEP)) ** 2
    return {name: float(np.sqrt(change)) for name, change in changes.items()}


def _shaped(candidate: Candidate, name: str, more: float) -> Candidate:
    """The candidate with one number of its shape increased."""
    shape = {key: candidate.shape[key] for key in candidate.bounds}
    return candidate.reshaped(shape | {name: shape[name] + more})


def _more(result: SearchResult, place: int, name: str) -> np.ndarray:
    """Derivative of the torque by one shape number of a finding, shape (r, n) [N m per its unit]."""
    answer, rows = result.selected[place].answer, result.prediction.rows
    if np.any(answer.columns.whole):
        # A delay also shifts noise, which says nothing about it; the column of the clock error does.
        late = np.isin(np.arange(rows.difference.shape[1]), answer.columns.joints)
        return rows.columns_at(np.array([rows.names.index(CLOCK)]))[:, :, 0] * late
    candidate, values = answer.candidate, result.prediction.values[places_of(result, place)]
    less, more, apart = around(candidate, name)
    torques = [Thinned.of(other, result.problem.runs).values @ values for other in (less, more)]
    torque = np.zeros(rows.difference.shape)
    torque[:, answer.columns.joints] = (torques[1] - torques[0]) / apart
    return torque


def around(candidate: Candidate, name: str) -> tuple[Candidate, Candidate, float]:
    """The candidate with one shape number decreased and increased, and the difference between both."""
    at, bounds = candidate.shape[name], candidate.bounds[name]
    step = STEP * min(abs(at) or np.inf, bounds.high - bounds.low)
    low, high = max(-step, bounds.low - at), min(step, bounds.high - at)
    return _shaped(candidate, name, low), _shaped(candidate, name, high), high - low
