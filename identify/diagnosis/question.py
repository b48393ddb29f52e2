"""Question: would candidate columns have predicted the blocks that were left out better?"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .block_likelihood import log_odds, strain, trusted
from .candidate import Candidate, Thinned
from .prediction import CERTAIN, Prediction, rms_torque, solve

STRANGE = 4.0
"""Standard deviations from what physics expects at which something is not that effect: one in 16 000."""

FORMULA = 0.1
"""Error of a formula of friction or gears, share of its torque [-]: none is right to better than a tenth."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What a candidate does for the blocks that are left out.

    Attributes:
        candidate: In one shape.
        columns: Its columns.
        values: Its coefficients by all fitted blocks, shape (p,).
        free: Which of them are not at a limit of physics, shape (p,).
        predicted: Sums of squares of the blocks as they are predicted without it, shape (k, n) [(N m)^2].
        errors: The same with it.
        along: Of each block, its residual along the predicted effect, over noise, shape (k,).
        size: Of each block, square of the predicted effect, over noise, shape (k,).
        gains: Logarithm of how much more probable each block is on each joint, shape (k, n).
        cost: Logarithm of the number of shapes of which it is the choice, over that of signs it cannot have.
        independent: Independent rows over all rows by which the gains are weighed, shape (n,).
        fitted: Whether a block is fitted, shape (k,); the others are only predicted.
        relief: Logarithm of how much more probable all that was believed is, beside it.
    """

    candidate: Candidate
    columns: Thinned
    values: np.ndarray
    free: np.ndarray
    predicted: np.ndarray
    errors: np.ndarray
    along: np.ndarray
    size: np.ndarray
    gains: np.ndarray
    cost: float = 0.0
    independent: np.ndarray | None = None
    fitted: np.ndarray | None = None
    relief: float = 0.0

    @cached_property
    def gain(self) -> float:
        """Logarithm of how much more probable blocks are, each predicted by the others, and beliefs."""
        return float(self.gains.sum()) + self.relief - self.cost

    @cached_property
    def by_joint(self) -> np.ndarray:
        """The same of each joint, shape (n,)."""
        return self.gains.sum(axis=0)

    @cached_property
    def by_block(self) -> np.ndarray:
        """The same of each block, shape (k,)."""
        return self.gains.sum(axis=1)

    @cached_property
    def held_out(self) -> float:
        """The same of blocks that are only predicted; zero without any."""
        return 0.0 if self.fitted is None else float(self.by_block[~self.fitted].sum())

    @cached_property
    def amplitude(self) -> tuple[float, float, float]:
        """How much of the predicted effect the blocks have, its t over blocks, and their effective number.

        One is all of it. A block says as much as the effect is large in it.
        """
        total = float(self.size.sum())
        if total <= 0.0:
            return 0.0, 0.0, 1.0
        amplitude = float(self.along.sum()) / total
        left = self.along - amplitude * self.size
        error = np.sqrt(float(left @ left) * len(left) / (len(left) - 1.0)) / total
        return amplitude, amplitude / max(float(error), 1e-9), total**2 / float(self.size @ self.size)

    @property
    def odds(self) -> float:
        """Logarithm of the odds that blocks left out have the effect, by how they scatter, and by beliefs."""
        _, t, effective = self.amplitude
        return log_odds(t, max(effective - 1.0, 1.0)) + self.relief

    @property
    def torque(self) -> np.ndarray:
        """Its torque, shape (r, m) of the joints of its columns [N m]."""
        return self.columns.values @ self.values

    @property
    def std(self) -> np.ndarray:
        """How far each coefficient may be from its mean once the effect is in the model, shape (p,)."""
        return np.where(self.free, prior_std(self.candidate, self.columns), CERTAIN)

    @property
    def mean(self) -> np.ndarray:
        """What each coefficient is then held to be, shape (p,)."""
        return np.where(self.free, self.columns.mean, self.values)


LINEAR = 0.03
"""Share by which a torque may be wrong all over [-]: current sensors are linear to a few per cent."""
SEEN = 1.0
"""Logarithm of the probability gained from which on a joint counts as seeing an effect."""
USUAL = 10.0
"""How far a coefficient may be, over what is expected of it: alone it gives the joint's usual torque."""
WIDE = 1000.0
"""The same where coefficients cancel, as those of a spring and its pretension do."""


def prior_std(candidate: Candidate, columns: Thinned) -> np.ndarray:
    """How far each coefficient may be from its mean, shape (p,): flat where physics does not say."""
    if candidate.expected is not None:
        return columns.std
    return (WIDE if candidate.cancels else USUAL) * columns.std


@dataclass(frozen=True, eq=False)
class _Products:
    """Products of candidates' columns, all of the same joints, with themselves and with the prediction's.

    Attributes:
        joints: Those they give torque to, shape (m,).
        places: Columns of each candidate among all c of them.
        own: Columns with each other, of each block and joint, shape (k, m, c, c).
        parts: With the prediction's columns (a, c) and with the torque (c,) of each block and joint.
        mixed: With the prediction's, of each block, all joints weighted, shape (k, b, c).
        torque: With what is to be explained, likewise, shape (k, c).
        weighted: `own` over all joints, weighted, shape (k, c, c).
    """

    joints: np.ndarray
    places: list[np.ndarray]
    own: np.ndarray
    parts: list[list[tuple[np.ndarray, np.ndarray]]]
    mixed: np.ndarray
    torque: np.ndarray
    weighted: np.ndarray

    @classmethod
    def of(cls, prediction: Prediction, every: Sequence[Thinned]) -> "_Products":
        """Over all blocks."""
        sums, weight, joints = prediction.sums, prediction.weighting.weight, every[0].joints
        stops = np.cumsum([0, *(one.values.shape[2] for one in every)])
        values = np.concatenate([one.values for one in every], axis=2)
        values = values * prediction.rows.weight[:, joints, None]
        blocks, count = prediction.blocks.rows, values.shape[2]
        pieces = [values[rows].transpose(1, 0, 2) for rows in blocks]
        own = np.stack([piece.transpose(0, 2, 1) @ piece for piece in pieces])
        mixed, torque = (
            np.zeros((len(blocks), len(prediction.rows.std), count)),
            np.zeros((len(blocks), count)),
        )
        parts: list[list[tuple[np.ndarray, np.ndarray]]] = []
        for block, piece in enumerate(pieces):
            parts.append([])
            for one, joint in zip(piece, joints, strict=True):
                by_columns = sums.columns[block][joint].T @ one
                by_torque = one.T @ sums.torque[block][joint]
                parts[-1].append((by_columns, by_torque))
                mixed[block][sums.acting[joint]] += weight[block, joint] * by_columns
                torque[block] += weight[block, joint] * by_torque
        weighted = np.einsum("km,kmpq->kpq", weight[:, joints], own)
        places = [np.arange(a, b) for a, b in zip(stops[:-1], stops[1:], strict=True)]
        return cls(joints, places, own, parts, mixed, torque, weighted)


class _Fitted(NamedTuple):
    """Coefficients of one candidate by all fitted blocks (p,), which of them are free, and their priors."""

    values: np.ndarray
    free: np.ndarray
    precision: np.ndarray
    mean: np.ndarray


TOGETHER = 48
"""Candidates that are asked for at once: some tens of megabytes of products."""


def ask(prediction: Prediction, asked: Iterable[tuple[Candidate, Thinned]]) -> list[Answer]:
    """Answers of all blocks, each left out in turn, without those that physics excludes."""
    by_joints: dict[tuple[int, ...], list[tuple[Candidate, Thinned]]] = {}
    for pair in asked:
        by_joints.setdefault(tuple(pair[1].joints), []).append(pair)
    return [
        answer
        for alike in by_joints.values()
        for start in range(0, len(alike), TOGETHER)
        for answer in _answers(prediction, alike[start : start + TOGETHER])
    ]


def _answers(prediction: Prediction, alike: Sequence[tuple[Candidate, Thinned]]) -> list[Answer]:
    products = _Products.of(prediction, [columns for _, columns in alike])
    mixed = products.mixed.sum(axis=0)
    apart = solve(prediction.factor, mixed)
    matrix = products.weighted.sum(axis=0) - mixed.T @ apart
    right = products.torque.sum(axis=0) - mixed.T @ prediction.values
    fitted = [
        _beside_limits(
            prediction,
            apart[:, own],
            matrix[np.ix_(own, own)],
            columns,
            _fitted(matrix[np.ix_(own, own)], right[own], candidate, columns),
        )
        for (candidate, columns), own in zip(alike, products.places, strict=True)
    ]
    errors, along, size = _predicted(prediction, products, fitted)
    share = prediction.weighting.independent
    gains = prediction.log_probability(errors, share) - prediction.log_probability(prediction.errors, share)
    return [
        Answer(
            candidate, columns, one.values, one.free, prediction.errors, errors[i], along[i], size[i],
            gains[i], _cost(candidate), share,
            prediction.blocks.fitted,
            _relief(prediction, apart[:, products.places[i]], one, candidate)
            - _surprise(prediction, errors[i], candidate, columns),
        )
        for i, ((candidate, columns), one) in enumerate(zip(alike, fitted, strict=True))
        if one is not None
    ]  # fmt: skip


def _cost(candidate: Candidate) -> float:
    """Logarithm of the number of shapes; with one sign only, half as many values may be."""
    signs = sum(limit == 0.0 for limit in candidate.lower)
    return float(np.log(candidate.among) - np.log(2.0) * signs)


def _surprise(prediction: Prediction, errors: np.ndarray, candidate: Candidate, columns: Thinned) -> float:
    """By how much less probable an effect is for its torque, where its cause says how large that is."""
    if np.isinf(candidate.size) or columns.usual is None:
        return 0.0
    explained = prediction.power(prediction.errors) - prediction.power(errors)
    torque = np.sqrt(np.maximum(explained[columns.joints], 0.0))
    return strain(np.max(torque / np.maximum(columns.usual, 1e-300)) / candidate.size)


def _relief(prediction: Prediction, apart: np.ndarray, one: _Fitted, candidate: Candidate) -> float:
    """By how much more probable beliefs are beside a candidate, what physics expects of itself included."""
    rows, values = prediction.rows, prediction.values
    known = np.isfinite(rows.std) & (rows.std > CERTAIN)
    before, after = ((x - rows.mean)[known] / rows.std[known] for x in (values, values - apart @ one.values))
    own = np.zeros(0)
    if candidate.expected is not None:
        own = ((one.values - one.mean) * np.sqrt(one.precision))[one.free]
    return strain(before) - strain(after) - strain(own)


def _fitted(matrix: np.ndarray, right: np.ndarray, candidate: Candidate, columns: Thinned) -> _Fitted | None:
    """Coefficients of one candidate; None where the effect cannot be.

    Those that physics does not let below a limit stay there.
    """
    precision, lower = prior_std(candidate, columns) ** -2.0, np.array(candidate.lower)
    matrix, right = matrix + np.diag(precision), right + precision * columns.mean
    free, values = np.ones(len(lower), bool), np.zeros(len(lower))
    while np.any(free):
        values[free] = _solved(matrix, right, values, free)
        below = free & (values < lower)
        if not np.any(below):
            break
        free &= ~below
        values[below] = lower[below]
    known = columns.mean != 0.0
    strange = np.abs(values - columns.mean)[known] > STRANGE * columns.std[known]
    strange = np.append(strange, np.abs(values) > candidate.most)
    led = candidate.led > 0 and not np.any(free[: candidate.led])
    if led or not np.any(free) or np.any(strange) or not np.all(np.isfinite(values)):
        return None
    return _Fitted(values, free, precision, columns.mean)


def _beside_limits(
    prediction: Prediction, apart: np.ndarray, matrix: np.ndarray, columns: Thinned, one: _Fitted | None
) -> _Fitted | None:
    """The coefficients; None where something else would have to be beyond its limit of physics beside them.

    A friction that needs the viscous friction to be negative is not that friction; by a tenth of its own
    torque it may, since no formula is better.

    Args:
        prediction: Without it.
        apart: By how much less the other unknowns are per unit of each coefficient, shape (b, p).
        matrix: Normal matrix of the coefficients beside the others, shape (p, p).
        columns: Of the coefficients.
        one: The coefficients.
    """
    places = prediction.rows.limited
    if one is None or not len(places):
        return one
    lower, before = prediction.rows.lower[places], prediction.values[places]
    after = before - apart[places] @ one.values
    free = matrix[np.ix_(one.free, one.free)] + np.diag(one.precision[one.free])
    moved = apart[np.ix_(places, one.free)]
    own = np.sum(moved * np.linalg.solve(free, moved.T).T, axis=1)
    std = np.sqrt(prediction.limited_std**2 + np.maximum(own, 0.0))
    torque = float(rms_torque((columns.values @ one.values)[:, :, None])[0])
    spare = STRANGE * std + FORMULA * torque / np.maximum(prediction.limited_size, 1e-300)
    return None if np.any(after < np.minimum(lower, before) - spare) else one


def _solved(matrix: np.ndarray, right: np.ndarray, values: np.ndarray, free: np.ndarray) -> np.ndarray:
    """The free unknowns of a small system, the others being what they are."""
    if len(free) == 1:
        return right / np.maximum(matrix[0], 1e-300)
    held = np.where(free, 0.0, values)
    size = np.sqrt(np.maximum(np.diag(matrix)[free], 1e-300))
    scaled = matrix[np.ix_(free, free)] / np.outer(size, size) + 1e-10 * np.eye(int(free.sum()))
    return np.linalg.solve(scaled, (right - matrix @ held)[free] / size) / size


def _predicted(
    prediction: Prediction, products: _Products, fitted: Sequence[_Fitted | None]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of blocks (i, k, n), their residuals along each effect (i, k), and its squares (i, k)."""
    sums, noise = prediction.sums, 1.0 / prediction.weighting.variance
    errors = np.repeat(prediction.errors[None], len(fitted), axis=0)
    along, size = np.zeros(errors.shape[:2]), np.zeros(errors.shape[:2])
    whole, torque = products.mixed.sum(axis=0), products.torque.sum(axis=0)
    matrix, share = products.weighted.sum(axis=0), prediction.weighting.independent
    rows = share * sums.counts
    for block in range(errors.shape[1]):
        mixed, base = whole - products.mixed[block], prediction.left_out[block]
        apart = solve(prediction.factors[block], mixed)
        own = matrix - products.weighted[block] - mixed.T @ apart
        coefficients = _without(own, torque - products.torque[block] - mixed.T @ base, products, fitted)
        change = apart @ coefficients  # of the other unknowns, downwards
        for joint in range(errors.shape[2]):
            acting = sums.acting[joint]
            gram, moved, here = sums.gram[block][joint], change[acting], base[acting]
            linear = -moved.T @ (sums.right[block][joint] - gram @ here)
            square = np.sum(moved * (gram @ moved), axis=0)
            for place in np.flatnonzero(products.joints == joint):
                one, two = products.parts[block][place]
                linear += coefficients.T @ (two - one.T @ here)
                square += np.sum(
                    coefficients * (products.own[block, place] @ coefficients - 2.0 * one.T @ moved), axis=0
                )
            errors[:, block, joint] = np.maximum(errors[:, block, joint] - 2.0 * linear + square, 1e-12)
            # A block that was predicted from motions too unlike its own says as little of the effect.
            sound = trusted(share[joint] * noise[joint] * errors[:, block, joint], rows[block, joint])
            along[:, block] += sound * noise[joint] * linear
            size[:, block] += sound * noise[joint] * square
    return errors, along, size


def _without(
    matrix: np.ndarray, right: np.ndarray, products: _Products, fitted: Sequence[_Fitted | None]
) -> np.ndarray:
    """Coefficients of every candidate by the blocks that are not left out, in its own columns, (c, i)."""
    found = np.zeros((len(right), len(fitted)))
    for place, (own, one) in enumerate(zip(products.places, fitted, strict=True)):
        if one is None:
            continue
        values = np.where(one.free, 0.0, one.values)
        whole = matrix[np.ix_(own, own)] + np.diag(one.precision)
        values[one.free] = _solved(whole, right[own] + one.precision * one.mean, values, one.free)
        found[own, place] = values
    return found


def colouring(prediction: Prediction, answer: Answer) -> Answer:
    """The answer with as many independent rows as the effect has through what it leaves."""
    torque = np.zeros(prediction.rows.difference.shape)
    torque[:, answer.columns.joints] = answer.torque
    return weighed(prediction, answer, prediction.independent_of(torque))


def weighed(prediction: Prediction, answer: Answer, independent: np.ndarray) -> Answer:
    """The answer with so many independent rows over all rows (n,): answers are compared by the same."""
    gains = prediction.log_probability(answer.errors, independent) - prediction.log_probability(
        prediction.errors, independent
    )
    return replace(answer, gains=gains, independent=independent)


def levelled(prediction: Prediction, answers: Sequence[Answer]) -> list[Answer]:
    """The answers with as many independent rows of each joint as what the foremost of that joint leaves has.

    Weighed each with its own, what leaves more of a misfit could come out ahead, only because it is faster.
    """
    if not answers:
        return []
    coloured: dict[int, np.ndarray] = {}
    independent = np.ones(prediction.joints)
    for joint in range(prediction.joints):
        first = max(range(len(answers)), key=lambda place: float(answers[place].by_joint[joint]))
        if first not in coloured:
            torque = np.zeros(prediction.rows.difference.shape)
            torque[:, answers[first].columns.joints] = answers[first].torque
            coloured[first] = prediction.independent_of(torque)
        independent[joint] = coloured[first][joint]
    return [weighed(prediction, one, independent) for one in answers]


def competing(one: Answer, other: Answer) -> bool:
    """Whether both give torque to one joint, and so may explain the same."""
    return bool(np.intersect1d(one.columns.joints, other.columns.joints).size)


def _as_good(one: Answer, other: Answer) -> bool:
    """Whether what two answers leave differs by less than the sensors' error of what is explained.

    So it has to be on every joint that sees either of them.
    """
    seen = (one.by_joint > SEEN) | (other.by_joint > SEEN)
    left = np.array([answer.errors.sum(axis=0) for answer in (one, other)])
    explained = one.predicted.sum(axis=0) - left.min(axis=0)
    return bool(np.all(np.abs(left[0] - left[1])[seen] < LINEAR**2 * explained[seen]))


def better(one: Answer, other: Answer, prior: float = 0.0) -> float:
    """Logarithm of the odds that one predicts better than another, by their blocks.

    What the blocks say is no more than the scatter of the difference over them allows, and nothing where the
    two differ by less than torque may be wrong; what shapes cost, and `prior`, is known without them.
    """
    apart = one.by_block - other.by_block
    if _as_good(one, other):
        apart = np.zeros(len(apart))
    error = float(np.std(apart, ddof=1)) * np.sqrt(len(apart)) + 1e-9
    scatter = log_odds(float(apart.sum()) / error, len(apart) - 1.0)
    return (
        min(float(apart.sum()), max(scatter, 0.0)) + other.cost - one.cost + one.relief - other.relief + prior
    )
