"""Simpler: an effect whose torque another contains wins, unless what the other has beyond it is needed.

An offset is a part of a spring, the inertia of a rotor one of a link. The larger effect always fits as well,
and its further parameters take up what the model misses elsewhere.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from ..blocks.prediction import Prediction
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.comparison import better, by_blocks
from .selected import Selected, judged, log_prior, odds_of

SAME = 1e-3
"""Share of a torque by which two ways of thinning it out differ [-]."""


def simplest(prediction: Prediction, best: Sequence[Answer], total: float) -> Selected | None:
    """The most probable hypothesis that is credible, or the part of it that is.

    Args:
        prediction: Without any of them.
        best: One answer for each hypothesis, the most probable first.
        total: Sum of the prior weights of all hypotheses.
    """
    open_ = list(best)
    while True:
        found = judged(open_, total, lambda one, other: by_blocks(prediction, one, other))
        if found is None or not any(_enough(prediction, found.answer, open_, total)):
            return found
        open_ = [answer for answer in open_ if answer is not found.answer]


def _enough(prediction: Prediction, larger: Answer, best: Sequence[Answer], total: float) -> Iterator[bool]:
    """For each credible part of an effect, whether what is beyond it is not credible as an effect of its own.

    Each further parameter, whose size nothing gives, costs half the logarithm of the rows that show it, as in
    Schwarz's criterion.
    """
    joint = int(np.argmax(larger.by_joint))
    rows = larger.independent[joint] * prediction.sums.counts[larger.fitted, joint].sum()
    for part in best:
        more = len(larger.values) - len(part.values)
        if more <= 0 or odds_of(part, total) < CERTAIN_ODDS or not contains(larger, part):
            continue
        prior = log_prior(larger, total) - 0.5 * more * float(np.log(max(rows, 1.0)))
        yield better(larger, part, by_blocks(prediction, larger, part), prior) < CERTAIN_ODDS


def contains(larger: Answer, part: Answer) -> bool:
    """Whether any torque of one effect is a torque of another on the same joints."""
    if not np.array_equal(larger.columns.joints, part.columns.joints):
        return False
    columns, torque = (answer.columns.values.reshape(-1, len(answer.values)) for answer in (larger, part))
    size = np.maximum(np.linalg.norm(columns, axis=0), np.finfo(float).tiny)
    left = torque - columns / size @ np.linalg.lstsq(columns / size, torque, rcond=None)[0]
    return bool(np.all(np.linalg.norm(left, axis=0) <= SAME * np.linalg.norm(torque, axis=0)))
