"""The belief after a search: products of all columns, and the questions that are open."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exidyn.identify.diagnosis.blocks.prediction import CERTAIN, LINEAR
from exidyn.identify.diagnosis.questions.block_answer import prior_std
from exidyn.identify.diagnosis.search.search import SearchResult

from ..columns import RunColumns
from .belief import Belief
from .questions import asked_of, unseen_of
from .suspects import Suspects


def belief_of(
    search: SearchResult, suspects: Suspects, runs: Sequence[RunColumns], left: np.ndarray | None = None
) -> Belief:
    """The belief after a search, and what runs on offer could show.

    Args:
        search: Of the diagnosis.
        suspects: What may be there beside what was found.
        runs: On offer.
        left: Squared torque of each joint that is left without a name, shape (n,) [(N m)^2]; else none.
    """
    prediction = search.prediction
    joints, fitted = prediction.joints, prediction.weighting.weight[prediction.blocks.number]
    columns = np.concatenate(
        [prediction.rows.columns, *(one.columns.everywhere(joints) for one in suspects.every)], axis=2
    )
    weight = fitted * prediction.rows.weight
    std = [prediction.rows.std, *(prior_std(one.candidate, one.columns) for one in suspects.rivals)]
    # no larger in any run than it may be there: the run that shows it best limits it
    std += [
        np.min([one.columns.std, *(run.suspects[place].std for run in runs)], axis=0)
        for place, one in enumerate(suspects.left, len(suspects.rivals))
    ]
    deviation = np.maximum(np.concatenate(std), CERTAIN)
    mean = np.concatenate([prediction.rows.mean, *(one.columns.mean for one in suspects.every)])
    belief = Belief(
        search,
        suspects.every,
        products(columns, weight),
        np.einsum("rnc,rn->c", columns, weight * prediction.rows.difference),
        deviation**-2.0,
        mean,
        prediction.weighting.independent / prediction.weighting.variance,
        _reaches(search, columns, weight > 0.0, runs),
    )
    left = np.zeros(joints) if left is None else left
    asked = (*asked_of(belief, suspects, left), *unseen_of(belief, len(suspects.rivals)))
    return replace(belief, questions=asked)


def products(columns: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Products of columns (r, n, c) over rows and joints with a weight (r, n), shape (c, c)."""
    flat = (columns * np.sqrt(weight)[:, :, None]).reshape(-1, columns.shape[2])
    return flat.T @ flat


def all_columns(run: RunColumns, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns of a run, and what it brings of its own: the unknowns of a body that no run has carried so far.

    Returns:
        Columns of named unknowns and all suspects (r, n, c); of the others (r, n, e); their precision (e,).
    """
    place = {name: k for k, name in enumerate(run.rows.names)}
    known = run.rows.columns[:, :, [place[name] for name in names]]
    joints = known.shape[1]
    every = np.concatenate([known, *(one.everywhere(joints) for one in run.suspects)], axis=2)
    more = [k for name, k in place.items() if name not in set(names)]
    return every, run.rows.columns[:, :, more], np.maximum(run.rows.std[more], CERTAIN) ** -2.0


def _reaches(
    search: SearchResult, columns: np.ndarray, counts: np.ndarray, runs: Sequence[RunColumns]
) -> np.ndarray:
    """As in `Belief`: the resolution is a share of the largest usual torque of each joint."""
    names = search.prediction.rows.names
    torque = np.concatenate([run.thinned(run.torque) for run in search.problem.runs])
    parts = [(columns, counts, torque)]
    parts += [(all_columns(run, names)[0], run.rows.weight > 0.0, run.torque) for run in runs]
    usual = np.sqrt(np.max([np.mean(torque**2, axis=0) for _, _, torque in parts], axis=0))
    resolution = LINEAR * np.maximum(usual, 1e-9)
    return np.array([products(own, seen / resolution**2 / max(len(own), 1)) for own, seen, _ in parts])
