"""Where two arms, or one arm on two days, differ."""

from typing import NamedTuple

import numpy as np
from scipy import stats

from .learned import Learned
from .runs import ArmRuns

WRONG = 0.05
"""Probability that two equal arms are said to differ in anything at all."""


class Difference(NamedTuple):
    """What differs.

    Attributes:
        effect: In the vocabulary of the diagnosis.
        joint: From 0; -1 for a combination of links.
        parameter: Its name.
        unit: Of the amounts; empty where they are shares.
        first: Value of the first arm; NaN where there is none.
        amount: Second minus first.
        std: Of that.
    """

    effect: str
    joint: int
    parameter: str
    unit: str
    first: float
    amount: float
    std: float


def compared(learned: Learned, first: ArmRuns, second: ArmRuns) -> list[Difference]:
    """What differs, the surest first: one cause after the other, as long as equal arms would not show it.

    Each arm's values have the scatter from run to run in their covariance, and what temperature leaves open.
    """
    frame, size = learned.frame, len(learned.frame.scale)
    (one, one_covariance), (other, other_covariance) = (learned.level(runs) for runs in (first, second))
    apart = (other - one)[:size]
    precision = np.linalg.inv((one_covariance + other_covariance)[:size, :size])
    labels, directions = _asked(learned)
    threshold = stats.norm.isf(0.5 * WRONG / len(labels))
    chosen: list[int] = []
    while len(chosen) < len(labels):
        left = apart - _explained(directions[chosen], precision, apart) if chosen else apart
        best = _best(directions, chosen, precision, left, float(threshold))
        if best is None:
            break
        chosen.append(best)
    if not chosen:
        return []
    normal = directions[chosen] @ precision @ directions[chosen].T
    amounts = np.linalg.solve(normal, directions[chosen] @ precision @ apart)
    stds = np.sqrt(np.diag(np.linalg.inv(normal)))
    values = one[:size] * frame.scale
    rows = [
        Difference(*labels[k][:4], values[labels[k][4]] if labels[k][4] >= 0 else np.nan, float(a), float(s))
        for k, a, s in zip(chosen, amounts, stds, strict=True)
    ]
    return sorted(rows, key=lambda row: -abs(row.amount) / row.std)


def _asked(learned: Learned) -> tuple[list[tuple[str, int, str, str, int]], np.ndarray]:
    """Causes, and base parameters of the links; each direction in the frame's units for an amount of one."""
    frame = learned.frame
    labels = [(c.effect, c.joint, c.parameter, c.unit, c.place) for c in frame.causes]
    taken = {one.place for one in frame.causes if one.unit}
    base = frame.kind.base
    links = [k for k in range(len(base.kept)) if k not in taken]
    labels += [("link_inertia", -1, base.names[k], base.units[k], k) for k in links]
    return labels, np.concatenate(
        [frame.directions, np.eye(len(frame.scale))[links] / frame.scale[links, None]]
    )


def _explained(directions: np.ndarray, precision: np.ndarray, apart: np.ndarray) -> np.ndarray:
    along = directions @ precision
    return directions.T @ np.linalg.solve(along @ directions.T, along @ apart)


def _best(
    directions: np.ndarray, chosen: list[int], precision: np.ndarray, left: np.ndarray, threshold: float
) -> int | None:
    """The direction that explains most of what is left, the chosen ones free; None if it may be chance."""
    weighted = directions @ precision
    own = np.einsum("km,km->k", weighted, directions)
    if chosen:
        across = weighted[chosen] @ directions.T
        own = own - np.einsum("ck,ck->k", across, np.linalg.solve(across[:, chosen], across))
    free = own > 1e-9 * np.einsum("km,km->k", weighted, directions)
    free[chosen] = False
    deviations = np.where(free, np.abs(weighted @ left) / np.sqrt(np.where(free, own, 1.0)), 0.0)
    best = int(np.argmax(deviations))
    return best if deviations[best] > threshold else None
