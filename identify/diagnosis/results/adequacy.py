"""Adequacy: whether the model with all findings fits the runs as correct models fit correct data.

A probability among hypotheses says nothing if none of them is right. So every block is predicted by the
others, with bodies of any mass: by parameters that all joints share, and by parameters of each joint alone.
If nothing of this kind fits, or if each joint fits by itself but not together with the others, then columns,
units, geometry or clocks are wrong, or an effect is missing that no hypothesis describes.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...positive_definite import solve
from ..blocks.prediction import UNKNOWN, Prediction, factored
from ..findings.adequacy import Adequacy, Misfit
from ..search.search import SearchResult

UNFITTED = 0.1
"""Left-out residual over torque, all joints of a unit together, above which nothing of this kind fits [-]."""
APART = 2.5
"""Left-out residual of a joint over that with separate parameters above which it fits only alone [-]."""
OWN = 1e-3
"""Weight of the shared parameters as a prior of separate ones, relative to the data [-]: it matters only in
directions that one joint hardly determines."""
CONCENTRATED = 3.0
"""Residual of a block over that of the joint's median block from which on the misfit is in this block [-]."""


def adequacy(result: SearchResult) -> Adequacy:
    """Compare the left-out residual of the model with all findings to that of correct models."""
    prediction, problem = result.prediction, result.problem
    shared = shared_values(prediction, len(problem.model.names))
    errors, fitted = prediction.sums.errors(shared), problem.blocks.fitted
    power = torque_power(result)[fitted].sum(axis=0)
    together, alone = errors[fitted].sum(axis=0), separate_errors(prediction, shared)[fitted].sum(axis=0)
    failing = failing_joints(together, alone, power, problem.model.robot.revolute)
    return Adequacy(
        np.sqrt(together / power),
        np.sqrt(alone / power),
        float(pooled_share(together, power, problem.model.robot.revolute)),
        failing,
        tuple(misfits(result, errors, failing)),
    )


def shared_values(prediction: Prediction, bodies: int) -> np.ndarray:
    """Unknowns fitted without each block, the first `bodies` of them without a prior, shape (k, b)."""
    precision = prediction.precision.copy()
    precision[:bodies] /= UNKNOWN**2
    rows, weight = prediction.rows, prediction.weighting.weight
    gram, right = prediction.sums.normal_equations(weight, len(rows.std))
    matrix, side = gram.sum(axis=0) + np.diag(precision), right.sum(axis=0) + precision * rows.mean
    return np.array([solve(factored(matrix - g), side - r) for g, r in zip(gram, right, strict=True)])


def separate_errors(prediction: Prediction, shared: np.ndarray) -> np.ndarray:
    """Squared errors of left-out blocks with parameters of each joint's own, shape (k, n) [(N m)^2].

    Args:
        prediction: Prediction with all findings.
        shared: Unknowns that all joints share, for each block, shape (k, b).
    """
    sums, weights = prediction.sums, prediction.weighting.weight
    errors = np.zeros(sums.counts.shape)
    for joint, (acting, gram, right) in enumerate(zip(sums.acting, sums.gram, sums.right, strict=True)):
        weight, own = weights[:, joint], shared[:, acting].copy()
        matrix, side = np.tensordot(weight, gram, 1), weight @ right
        prior = OWN * np.diag(matrix)
        for block, present in enumerate(weight):
            left_out = matrix - present * gram[block] + np.diag(prior)
            own[block] = solve(factored(left_out), side - present * right[block] + prior * own[block])
        errors[:, joint] = sums.joint_errors(joint, own)
    return errors


def torque_power(result: SearchResult) -> np.ndarray:
    """Squared torque of each block and joint, shape (k, n) [(N m)^2]; rows at standstill do not count."""
    runs = [run.prepared for run in result.problem.runs]
    torque = np.concatenate([run.gain * run.decimated_current for run in runs])
    counted = torque**2 * result.prediction.rows.weight
    return np.array([counted[piece].sum(axis=0) for piece in result.problem.blocks.rows])


def pooled_share(errors: np.ndarray, power: np.ndarray, revolute: np.ndarray) -> float:
    """Residual over torque of all joints together, the larger of those of N m and of N [-].

    Args:
        errors: Sum of squared errors of each joint, shape (n,) [(N m)^2].
        power: Sum of the squared torque of each joint, shape (n,) [(N m)^2].
        revolute: Whether the torque of each joint is in N m rather than N, shape (n,).
    """
    units = [joints for joints in (revolute, ~revolute) if power[joints].any()]
    return max((float(np.sqrt(errors[j].sum() / power[j].sum())) for j in units), default=0.0)


def failing_joints(
    together: np.ndarray, alone: np.ndarray, power: np.ndarray, revolute: np.ndarray
) -> tuple[int, ...]:
    """Joints that fit only alone, and the fewest joints without whose errors the others fit together.

    Args:
        together: Sum of squared errors of each joint with shared parameters, shape (n,) [(N m)^2].
        alone: The same with parameters of its own, shape (n,) [(N m)^2].
        power: Sum of the squared torque of each joint, shape (n,) [(N m)^2].
        revolute: Whether the torque of each joint is in N m rather than N, shape (n,).
    """
    failing = together > APART**2 * alone
    for unit in (revolute, ~revolute):
        joints = np.flatnonzero(unit)
        order = joints[np.argsort(-together[joints])]
        rest = together[order].sum() - np.cumsum(together[order])
        allowed = UNFITTED**2 * power[order].sum()
        if together[order].sum() > allowed:
            failing[order[: 1 + np.searchsorted(-rest, -allowed)]] = True
    return tuple(map(int, np.flatnonzero(failing & (power > 0.0))))


def misfits(result: SearchResult, errors: np.ndarray, failing: tuple[int, ...]) -> Iterator[Misfit]:
    """Runs and times in which the left-out residual of failing joints is far larger than elsewhere.

    Args:
        result: Result of the search.
        errors: Sum of squared errors of each block and joint, shape (k, n) [(N m)^2].
        failing: Joints that fail, from 0.
    """
    blocks, prediction = result.problem.blocks, result.prediction
    level = errors / np.maximum(prediction.sums.counts, 1.0)
    typical = np.median(level[blocks.fitted], axis=0)
    large = (level > CONCENTRATED**2 * typical) & blocks.fitted[:, None]
    for run, rows in zip(result.problem.runs, prediction.rows.runs, strict=True):
        time = run.motion.time[run.centres]
        inside = [k for k, piece in enumerate(blocks.rows) if rows.start <= piece.start < rows.stop]
        for joint in failing:
            for part in _stretches([k for k in inside if large[k, joint]]):
                first, last = blocks.rows[part[0]].start, blocks.rows[part[-1]].stop - 1
                start, end = float(time[first - rows.start]), float(time[last - rows.start])
                yield Misfit(run.prepared.name, start, end, joint)


def _stretches(numbers: list[int]) -> list[np.ndarray]:
    """Successive numbers in groups without gaps."""
    breaks = np.flatnonzero(np.diff(numbers) > 1) + 1
    return [part for part in np.split(np.array(numbers), breaks) if len(part)]


def gated(result: SearchResult) -> tuple[SearchResult, Adequacy]:
    """The result without names where the model does not fit, and its adequacy."""
    found = adequacy(result)
    selected = [
        finding._replace(fits=not found.fails(finding.answer.candidate.joints)) for finding in result.selected
    ]
    return replace(result, selected=tuple(selected)).ordered(), found
