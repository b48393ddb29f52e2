"""Deviations of findings: how far their numbers may be off, those of their shapes with them.

A shape was chosen as the best of many; nearby ones do almost as well, with other coefficients. To first order
a little more of a shape's number is a further column, and a coefficient's deviation is that beside all such
columns, by how all of them change when blocks are left out.
"""

from collections.abc import Mapping

import numpy as np

from ..blocks.prediction import Prediction
from ..questions.candidate import Candidate, Thinned
from ..runs.nuisances import CLOCK
from ..search.search import SearchResult
from .evidence import places_of

STEP = 0.02
"""Of the difference that gives a column, share of a number or of its bounds [-]."""


def deviations(found: SearchResult) -> list[tuple[np.ndarray, dict[str, float]]]:
    """Standard deviations of each finding: of its coefficients (p,), and of its shape by name."""
    ranges = [one.answer.candidate.bounds for one in found.selected]
    every = [
        (place, name)
        for place, shape in enumerate(ranges)
        for name, (_, low, high) in shape.items()
        if high > low  # a preload of a joint that bears no load is none
    ]
    prediction = found.prediction
    count, rows = len(prediction.rows.names), prediction.rows
    if every:
        columns = np.stack([_more(found, place, name) for place, name in every], axis=2)
        # Anywhere within its bounds is as likely beforehand.
        bounds = [ranges[place][name] for place, name in every]
        spread = np.array([(one.high - one.low) / np.sqrt(12.0) for one in bounds])
        rows = rows.plus([name for _, name in every], columns, spread)
        prediction = Prediction.of(rows, prediction.blocks, prediction.rate)
    std = np.sqrt(np.diag(prediction.covariance))
    shapes = [dict.fromkeys(shape, 0.0) for shape in ranges]
    for (place, name), deviation in zip(every, std[count:], strict=True):
        shapes[place][name] = float(deviation)
    return [
        (std[places_of(found, place)], shape | _of_reported(found.selected[place].answer.candidate, shape))
        for place, shape in enumerate(shapes)
    ]


def _of_reported(candidate: Candidate, std: Mapping[str, float]) -> dict[str, float]:
    """Of what follows from the shape, to first order."""
    changes = {name: 0.0 for name in candidate.reported}
    for name, deviation in std.items():
        low, high = (_shaped(candidate, name, sign * deviation * STEP) for sign in (-1, 1))
        for one in changes:
            changes[one] += ((high.reported[one][0] - low.reported[one][0]) / (2 * STEP)) ** 2
    return {name: float(np.sqrt(change)) for name, change in changes.items()}


def _shaped(candidate: Candidate, name: str, more: float) -> Candidate:
    """The candidate with a little more of one number of its shape."""
    assert candidate.reshaped is not None
    shape = {key: candidate.shape[key] for key in candidate.bounds}
    return candidate.reshaped(shape | {name: shape[name] + more})


def _more(found: SearchResult, place: int, name: str) -> np.ndarray:
    """Torque by a little more of one number of a finding's shape, shape (r, n) [N m per its unit]."""
    answer, rows = found.selected[place].answer, found.prediction.rows
    if np.all(answer.columns.whole):
        # A delay moves noise too, which shows nothing of it: what does shows how late a clock is.
        late = np.isin(np.arange(rows.difference.shape[1]), answer.columns.joints)
        return rows.columns[:, :, rows.names.index(CLOCK)] * late
    candidate, values = answer.candidate, found.prediction.values[places_of(found, place)]
    at, bounds = candidate.shape[name], candidate.bounds[name]
    step = STEP * min(abs(at) or np.inf, bounds.high - bounds.low)
    low, high = max(-step, bounds.low - at), min(step, bounds.high - at)
    torques = [
        Thinned.of(_shaped(candidate, name, more), found.problem.runs).values @ values for more in (low, high)
    ]
    whole = np.zeros(rows.difference.shape)
    whole[:, answer.columns.joints] = (torques[1] - torques[0]) / (high - low)
    return whole
