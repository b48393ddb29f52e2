"""Evidence: traces of all runs out of a search's result, and how far the numbers of findings may be off."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...model import Model
from ...positive_definite import solve
from ..blocks.prediction import Prediction, factored
from ..findings.evidence import Evidence, Trace
from ..questions.block_answer import prior_std
from ..questions.candidate import Candidate, Thinned
from ..runs.driven import Driven
from ..runs.rows import CLOCK, GAIN, Rows
from ..search.search import SearchResult


def evidence(found: SearchResult, noise: np.ndarray) -> Evidence:
    """What the answer rests on, runs held out first; the noise floor of the joints is (n,) [N m]."""
    model, nominal, fitted = found.problem.model, nominal_unknowns(found), found.prediction.values
    rows, count = found.prediction.rows, len(model.names)
    before, parts = rows.difference - rows.columns @ nominal, explained(found, rows, fitted)
    traces = []
    for run, own in zip(found.problem.runs, rows.runs, strict=True):
        left = before[own], found.prediction.residual[own], parts[:, own], found.problem.base.weight[own]
        traces.append(_trace(model, run, *left))
    fitted_runs = len(found.problem.fitted)
    return Evidence(
        model=model,
        before=model.nominal_values + nominal[:count],
        after=model.nominal_values + fitted[:count],
        gain_before=_gains(found, nominal),
        gain_after=_gains(found, fitted),
        noise=noise,
        traces=(*traces[fitted_runs:], *traces[:fitted_runs]),
        filtering=found.problem.runs[0].filtering,
        peak=np.max([run.most for run in found.problem.fitted], axis=0),
    )


def nominal_unknowns(found: SearchResult) -> np.ndarray:
    """Unknowns (b,) of the nominal model, without any finding; what is unstated is fitted."""
    nominal = found.problem.nominal_unknowns(found.without_findings)
    return np.append(nominal, np.zeros(len(found.prediction.rows.names) - len(nominal)))


def places_of(found: SearchResult, place: int) -> np.ndarray:
    """Places of a finding's coefficients among all unknowns."""
    counts = [len(one.answer.values) for one in found.selected]
    start = len(found.prediction.rows.names) - sum(counts[place:])
    return np.arange(start, start + counts[place])


def explained(found: SearchResult, rows: Rows, values: np.ndarray) -> np.ndarray:
    """Torque of each finding by unknowns (b,), shape (f, r, n) [N m]."""
    own = [places_of(found, place) for place in range(len(found.selected))]
    parts = [rows.columns[:, :, places] @ values[places] for places in own]
    return np.array(parts).reshape(len(parts), *rows.difference.shape)


def _gains(found: SearchResult, values: np.ndarray) -> np.ndarray:
    """Drive gains out of the shares of torque that lack in nominal ones, among all unknowns (b,)."""
    nominal = found.problem.runs[0].prepared.gain
    places = dict(zip(found.prediction.rows.names, values, strict=True))
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
"""Step of the difference that gives a column, share of a number or of its bounds [-]."""


class Spread(NamedTuple):
    """What is known of all unknowns together, numbers of shapes among them.

    Attributes:
        prediction: Of all findings, with the torque by a little more of each shape's number as a column.
        shapes: Finding and name of each such number; their unknowns are the last.
        covariance: Of all unknowns, shape (b, b).
    """

    prediction: Prediction
    shapes: tuple[tuple[int, str], ...]
    covariance: np.ndarray

    def of(self, found: SearchResult, place: int) -> tuple[np.ndarray, tuple[str, ...]]:
        """Places of a finding's unknowns, coefficients first, and the names of those of its shape."""
        first = len(self.prediction.rows.names) - len(self.shapes)
        behind = [first + k for k, (one, _) in enumerate(self.shapes) if one == place]
        names = tuple(name for one, name in self.shapes if one == place)
        return np.append(places_of(found, place), behind).astype(int), names


def with_shapes(found: SearchResult) -> Spread:
    """The prediction of a search, with unknowns for the numbers of all shapes that may be refined.

    What a limit of physics holds is as uncertain as it is without the limit: beyond that its interval ends.
    """
    ranges = [one.answer.candidate.bounds for one in found.selected]
    every = tuple(
        (place, name)
        for place, shape in enumerate(ranges)
        for name, (_, low, high) in shape.items()
        if high > low  # a preload of a joint that bears no load is none
    )
    prediction, std = found.prediction, _unlimited(found)
    rows = replace(prediction.rows, std=std)
    if every:
        columns = np.stack([_more(found, place, name) for place, name in every], axis=2)
        # Anywhere within its bounds is as likely beforehand.
        bounds = [ranges[place][name] for place, name in every]
        spread = np.array([(one.high - one.low) / np.sqrt(12.0) for one in bounds])
        rows = rows.plus([name for _, name in every], columns, spread)
    if every or not np.array_equal(std, prediction.rows.std):
        prediction = Prediction.of(rows, prediction.blocks, prediction.rate)
    return Spread(prediction, every, _covariance(found, prediction))


def _unlimited(found: SearchResult) -> np.ndarray:
    """How far each unknown may be from its mean, shape (b,): as far where a limit of physics holds it."""
    std = np.array(found.prediction.rows.std)
    for place, one in enumerate(found.selected):
        answer = one.answer
        if one.once:  # its time is set aside
            continue
        held = places_of(found, place)[~answer.free]
        std[held] = prior_std(answer.candidate, answer.columns)[~answer.free]
    return std


PARTS = 4.0
"""Independent rows of a contact at least: its window is found to a quarter of its duration, so that what it
leaves there has as many parts."""


def _covariance(found: SearchResult, prediction: Prediction) -> np.ndarray:
    """Covariance of all unknowns (b, b), that of a contact by what it leaves of the rows set aside for it."""
    covariance = np.array(prediction.covariance)
    for place, one in enumerate(found.selected):
        own = places_of(found, place)
        columns = prediction.rows.columns[:, :, own]
        aside = found.problem.base.weight * np.any(columns, axis=2) if one.once else np.zeros((1, 1))
        if not np.any(aside * (prediction.rows.weight == 0.0)):  # no contact, or measured otherwise
            continue
        noise = prediction.weighting.variance / prediction.weighting.independent
        left = np.sum(aside * found.prediction.residual**2, axis=0) / PARTS  # as if it had that many rows
        weight = aside / np.maximum(noise, left)
        gram = np.einsum("rnp,rn,rnq->pq", columns, weight, columns)
        covariance[np.ix_(own, own)] = solve(factored(gram), np.eye(len(own)))
    return covariance


def deviations(
    found: SearchResult, spread: Spread | None = None
) -> list[tuple[np.ndarray, dict[str, float]]]:
    """Standard deviations of each finding: of its coefficients (p,), and of its shape by name."""
    spread = spread or with_shapes(found)
    std = np.sqrt(np.diag(spread.covariance))
    shapes = [dict.fromkeys(one.answer.candidate.bounds, 0.0) for one in found.selected]
    behind = std[len(std) - len(spread.shapes) :]
    for (place, name), deviation in zip(spread.shapes, behind, strict=True):
        shapes[place][name] = float(deviation)
    return [
        (std[places_of(found, place)], shape | _of_reported(found.selected[place].answer.candidate, shape))
        for place, shape in enumerate(shapes)
    ]


def _of_reported(candidate: Candidate, std: Mapping[str, float]) -> dict[str, float]:
    """Deviations of what follows from the shape, to first order."""
    changes = dict.fromkeys(candidate.reported, 0.0)
    for name, deviation in std.items():
        low, high = (_shaped(candidate, name, sign * deviation * STEP) for sign in (-1, 1))
        for one in changes:
            changes[one] += ((high.reported[one][0] - low.reported[one][0]) / (2 * STEP)) ** 2
    return {name: float(np.sqrt(change)) for name, change in changes.items()}


def _shaped(candidate: Candidate, name: str, more: float) -> Candidate:
    """The candidate with a little more of one number of its shape."""
    shape = {key: candidate.shape[key] for key in candidate.bounds}
    return candidate.reshaped(shape | {name: shape[name] + more})


def _more(found: SearchResult, place: int, name: str) -> np.ndarray:
    """Torque by a little more of one number of a finding's shape, shape (r, n) [N m per its unit]."""
    answer, rows = found.selected[place].answer, found.prediction.rows
    if np.any(answer.columns.whole):
        # A delay moves noise too, which shows nothing of it: what does shows how late a clock is.
        late = np.isin(np.arange(rows.difference.shape[1]), answer.columns.joints)
        return rows.columns[:, :, rows.names.index(CLOCK)] * late
    candidate, values = answer.candidate, found.prediction.values[places_of(found, place)]
    less, more, apart = around(candidate, name)
    torques = [Thinned.of(one, found.problem.runs).values @ values for one in (less, more)]
    whole = np.zeros(rows.difference.shape)
    whole[:, answer.columns.joints] = (torques[1] - torques[0]) / apart
    return whole


def around(candidate: Candidate, name: str) -> tuple[Candidate, Candidate, float]:
    """The candidate with a little less and a little more of one number of its shape, and how far apart."""
    at, bounds = candidate.shape[name], candidate.bounds[name]
    step = STEP * min(abs(at) or np.inf, bounds.high - bounds.low)
    low, high = max(-step, bounds.low - at), min(step, bounds.high - at)
    return _shaped(candidate, name, low), _shaped(candidate, name, high), high - low
