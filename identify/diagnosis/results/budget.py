"""Budget: causes of the baseline residual, and the quantities on which it depends."""

from collections.abc import Iterable, Sequence
from itertools import chain

import numpy as np

from ..blocks.prediction import Prediction
from ..findings.evidence import Budget, Share
from ..questions.block_answer import Answer

NOISE, OTHER = "sensor noise", "nothing that was recorded"
TOLERATED = "drive gains, clock errors and reversals of friction"
"""What a search fits besides the model and its findings."""


def budget(
    baselines: Iterable[Prediction],
    final: Prediction,
    residual_answers: list[Answer],
    noise: np.ndarray,
    names: Sequence[str],
) -> Budget:
    """Shares of the squared residual of the baseline, in blocks that were not used to fit it.

    Findings take their shares in the order in which they were found, then the nuisances of the final model.
    The remaining residual is divided in proportion to what smooth functions of position, velocity, load,
    time, ... predict of it. The shares of a joint add up to one.

    Args:
        baselines: Predictions of the baseline with none, one, ... and all f findings; one is held at a time.
        final: Prediction of the final model.
        residual_answers: Answers of smooth functions added to the final prediction.
        noise: Noise of each joint's torque, shape (n,) [N m]; zero if unknown.
        names: Names of the held-out runs.
    """
    fitted = final.blocks.fitted
    judged = fitted if np.all(fitted) else ~fitted  # held-out blocks, or all if there are none
    # Residual power of each joint, shape (f + 2, n) [(N m)^2].
    powers = np.array([each.power(each.errors, judged) for each in chain(baselines, [final])])
    total = np.maximum(powers[0], 1e-300)
    steps = np.maximum(powers[:-1] - powers[1:], 0.0)
    # If a step makes a joint worse, the shares of the other steps shrink.
    scale = (powers[0] - powers[-1]) / np.maximum(steps.sum(axis=0), 1e-300)
    steps = steps * np.clip(scale, 0.0, 1.0)
    remainder = total - steps.sum(axis=0)
    quiet = np.minimum(noise**2, remainder)
    kinds = {TOLERATED: steps[-1]} | _kinds(residual_answers, remainder - quiet, judged)
    shares = [Share(place, "", 100.0 * step / total) for place, step in enumerate(steps[:-1])]
    shares += [Share(None, kind, 100.0 * power / total) for kind, power in kinds.items()]
    shares += [Share(None, NOISE, 100.0 * quiet / total)]
    measured = [share for share in shares if share.kind != NOISE or np.any(share.percent > 0.0)]
    return Budget(np.sqrt(total), np.sqrt(powers[-1]), tuple(sorted(measured, key=_order)), tuple(names))


def _order(share: Share) -> tuple[int, float]:
    """Sort key: findings in order, kinds by size, then noise and other parts."""
    if share.finding is not None:
        return 0, float(share.finding)
    return {NOISE: 2, OTHER: 3}.get(share.kind, 1), -float(np.nanmax(share.percent))


def _kinds(
    residual_answers: list[Answer], remainder: np.ndarray, judged: np.ndarray
) -> dict[str, np.ndarray]:
    """Remaining power (n,) by kind, in proportion to what each kind of smooth function alone predicts."""
    explained: dict[str, np.ndarray] = {}
    for answer in residual_answers:
        [joint] = answer.candidate.joints
        before = answer.predicted[judged, joint].sum()
        less = max(1.0 - answer.errors[judged, joint].sum() / max(float(before), 1e-300), 0.0)
        explained.setdefault(answer.candidate.effect, np.zeros(len(remainder)))[joint] = less
    total = sum(explained.values(), np.zeros(len(remainder)))
    scale = remainder / np.maximum(total, 1.0)
    shares = {kind: share * scale for kind, share in explained.items()}
    return shares | {OTHER: np.maximum(remainder - sum(shares.values(), np.zeros(len(remainder))), 0.0)}


LEAST = 0.01
"""Smallest share of a joint's squared residual that the table lists [-]: no formula is more exact."""
