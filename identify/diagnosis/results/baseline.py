"""Baseline: the fit of `identify`, to which a finding's share and every residual "before" refer.

Its unknowns are the parameters of the model and drive gains, within their tolerances. Gains scale the torque
without findings: otherwise they would scale whatever resembles the torque of a finding. The clock errors and
the reversals of dry friction that a search fits besides are no part of it, nor is the trust in blocks.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..blocks.blocks import BlockRows
from ..blocks.prediction import Prediction
from ..runs.rows import GAIN, Rows
from ..search.problem import with_findings
from ..search.search import SearchResult
from ..search.selected import answers_of

TURNS = 5
"""Number of alternations between parameters and the noise of joints, which then changes by less than 1 %."""


def baselines(result: SearchResult) -> Iterator[Prediction]:
    """Predictions of the baseline with none, with the first, with the first two, ... of the findings."""
    start, answers = result.without_findings, answers_of(result.selected)
    rows = _of_model(start.rows, len(result.problem.model.names))
    rows = replace(rows, weight=result.prediction.rows.weight)
    count, sums = len(rows.names), BlockRows.of(rows, start.blocks)
    for number in range(len(answers) + 1):
        extended = with_findings(rows, answers[:number])
        sums = sums.plus(extended, count)
        count = len(extended.names)
        yield _weighted(start, extended, sums)


def _of_model(rows: Rows, count: int) -> Rows:
    """Rows with the first `count` unknowns, those of the model, and drive gains."""
    names = rows.names
    places = [place for place, name in enumerate(names) if place < count or name.startswith(GAIN)]
    fields = {name: getattr(rows, name)[places] for name in ("std", "mean", "lower", "bounded")}
    columns = rows.columns_at(np.array(places))
    return replace(rows, parts=(columns,), names=tuple(names[k] for k in places), **fields)


def _weighted(start: Prediction, rows: Rows, sums: BlockRows) -> Prediction:
    """Prediction whose joints are weighted by their residuals, and all fitted blocks alike."""
    total = np.maximum(sums.counts[start.blocks.fitted].sum(axis=0), 1.0)
    alike = start.blocks.fitted[:, None] + np.zeros(sums.counts.shape)
    weighting = replace(start.weighting, trust=alike)
    for _ in range(TURNS):
        prediction = Prediction(rows, start.blocks, start.rate, sums, weighting)
        residual = sums.sums(np.square(sums.residual(prediction.values)))
        variance = residual[start.blocks.fitted].sum(axis=0) / total
        weighting = replace(weighting, variance=rows.row_variance(variance + 1e-30))
    return Prediction(rows, start.blocks, start.rate, sums, weighting)
