"""Baseline: the fit of `identify`, to which a finding's share and every residual "before" refer.

Its unknowns are the parameters of the model, within their tolerances. Drive gains are unknown only if a known
payload determines them, and are fitted to the torque without findings: a free gain would scale with whatever
resembles the torque of a finding. The clock errors and the reversals of dry friction that a search fits
besides are no part of it.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...effects import Payload
from ...model import Model
from ..blocks.blocks import BlockSums
from ..blocks.prediction import Prediction
from ..runs.rows import GAIN, Rows
from ..search.problem import with_findings
from ..search.search import SearchResult
from ..search.selected import answers_of


def baseline(result: SearchResult) -> Prediction:
    """Prediction of all blocks by the model without findings."""
    return next(baselines(result))


def baselines(result: SearchResult) -> Iterator[Prediction]:
    """Predictions of the baseline with none, with the first, with the first two, ... of the findings."""
    start, answers, weight = (
        result.without_findings,
        answers_of(result.selected),
        result.prediction.rows.weight,
    )
    rows = replace(_of_model(start.rows, result.problem.model), weight=weight)
    count, sums, similar = len(rows.names), BlockSums.of(rows, start.blocks), None
    for number in range(len(answers) + 1):
        more = with_findings(rows, answers[:number])
        sums = sums.plus(more, count)
        prediction = Prediction.of(more, start.blocks, start.rate, similar, sums)
        count, similar = len(more.names), prediction.weighting
        yield prediction


def _of_model(rows: Rows, model: Model) -> Rows:
    """Rows with the unknowns of the model, and with gains if a payload of known mass determines them."""
    weighed = any(isinstance(body, Payload) and body.known for body in model.payloads.values())
    places = np.array(
        [
            place < len(model.names) or (weighed and name.startswith(GAIN))
            for place, name in enumerate(rows.names)
        ]
    )
    columns, fields = rows.columns[:, :, places], ("std", "mean", "lower", "bounded")
    names = tuple(name for name, kept in zip(rows.names, places, strict=True) if kept)
    return replace(
        rows, columns=columns, names=names, **{name: getattr(rows, name)[places] for name in fields}
    )
