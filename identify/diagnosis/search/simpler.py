"""Simpler: of two effects, one of which contains the other, the smaller wins unless the larger is needed.

An offset is part of a spring, and a rotor inertia part of a link inertia. The larger effect always fits at
least as well, and its extra parameters absorb errors of the model elsewhere.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from ..blocks.prediction import Prediction
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.comparison import better, by_blocks
from .selected import Selected, log_prior, most_probable, odds_of

SAME = 1e-3
"""Relative difference between two ways of decimating the same torque [-]."""


def simplest(prediction: Prediction, best: Sequence[Answer], total: float) -> Selected | None:
    """The most probable credible hypothesis, or the part of it that suffices."""
    open_ = list(best)
    while True:
        finding = most_probable(open_, total, lambda first, second: by_blocks(prediction, first, second))
        if finding is None or not any(_part_suffices(prediction, finding.answer, open_, total)):
            return finding
        open_ = [answer for answer in open_ if answer is not finding.answer]


def _part_suffices(
    prediction: Prediction, larger: Answer, best: Sequence[Answer], total: float
) -> Iterator[bool]:
    """For each credible part of an effect, whether the remainder of the effect is not credible by itself.

    Each extra parameter of unknown size costs half the logarithm of the number of rows that show it, as in
    the Bayesian information criterion (Schwarz).
    """
    joint = larger.joint
    rows = larger.independent[joint] * prediction.sums.counts[larger.fitted, joint].sum()
    for part in best:
        more = larger.numbers - part.numbers
        if more <= 0 or odds_of(part, total) < CERTAIN_ODDS or not contains(larger, part):
            continue
        prior = log_prior(larger, total) - 0.5 * more * float(np.log(max(rows, 1.0)))
        yield better(larger, part, by_blocks(prediction, larger, part), prior) < CERTAIN_ODDS


def contains(larger: Answer, part: Answer) -> bool:
    """Whether the columns of one effect reproduce the torque of another on the same joints."""
    if not np.array_equal(larger.columns.joints, part.columns.joints):
        return False
    columns, torque = (answer.columns.values.reshape(-1, len(answer.values)) for answer in (larger, part))
    size = np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    residual = torque - columns / size @ np.linalg.lstsq(columns / size, torque, rcond=None)[0]
    return bool(np.all(np.linalg.norm(residual, axis=0) <= SAME * np.linalg.norm(torque, axis=0)))
