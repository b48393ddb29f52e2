"""Adequacy: whether the model with all findings fits the runs as correct models fit correct data.

A probability among hypotheses says nothing if none of them is right. So every block is predicted by the
others, with bodies of any mass: by parameters that all joints share, and by parameters of each joint alone.
If nothing of this kind fits, or if each joint fits by itself but not together with the others, then columns,
units, geometry or clocks are wrong, or an effect is missing that no hypothesis describes.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...plausible.adequacy import failing_joints, pooled_share
from ...positive_definite import solve
from ..blocks.prediction import UNKNOWN, Prediction, factored
from ..findings.adequacy import Adequacy, Misfit
from ..questions.candidate import Candidate, covered_range
from ..runs.driven import Driven
from ..search.problem import Problem
from ..search.search import SearchResult

OWN = 1e-3
"""Weight of the shared parameters as a prior of separate ones, relative to the data [-]: it matters only in
directions that one joint hardly determines."""
SPANS = 10.0
"""Range of a joint, relative to the smallest that shows an effect, above which no error of columns, units or
geometry imitates it [-]: torque of bodies has at most two waves a turn, and so has what such an error makes
of it, while the effect has a dozen within the range."""
CONCENTRATED = 3.0
"""Residual of a block over that of the joint's median block from which on the misfit is in this block [-]."""


def gated(result: SearchResult) -> tuple[SearchResult, Adequacy]:
    """The result without names where the model does not fit, and its adequacy.

    One finding may make a joint fit that failed by far, without making another fail. If it takes several,
    they imitate what none of them describes, and the joint fails all the same. All joints share the bodies:
    if one joint still fails, so do all that failed before. A finding that no such error imitates is named all
    the same.
    """
    problem, answers = result.problem, [finding.answer for finding in result.selected]
    final, before = adequacy(problem, result.prediction), adequacy(problem, result.without_findings)
    imitated = set(before.failing) - set(final.failing)
    for answer in answers if imitated else ():
        failing = set(adequacy(problem, problem.prediction([answer], result.prediction)).failing)
        if failing <= set(before.failing):
            imitated &= failing
    more = set(before.failing) - set(final.failing) if imitated or final.failing else set()
    misfits = (*final.misfits, *(misfit for misfit in before.misfits if misfit.joint in more))
    final = replace(final, failing=tuple(sorted({*final.failing, *more})), misfits=misfits)
    fits = [not final.fails(a.candidate.joints) or _fine(a.candidate, problem.fitted) for a in answers]
    selected = (finding._replace(fits=fit) for finding, fit in zip(result.selected, fits, strict=True))
    return replace(result, selected=tuple(selected)).ordered(), final


def _fine(candidate: Candidate, runs: Sequence[Driven]) -> bool:
    """Whether an effect repeats so often within a joint's range that no torque of bodies resembles it."""
    return bool(candidate.span) and covered_range(candidate, runs) > SPANS * candidate.span


def adequacy(problem: Problem, prediction: Prediction) -> Adequacy:
    """Compare the left-out residual of a model to that of correct models."""
    fitted, revolute = problem.blocks.fitted, problem.model.robot.revolute
    shared = shared_values(prediction, len(problem.model.names))
    errors = prediction.sums.errors(shared)
    together, alone = (e[fitted].sum(axis=0) for e in (errors, separate_errors(prediction, shared)))
    runs = (run.prepared for run in problem.fitted)  # the first rows
    torque = np.concatenate([run.gain * run.decimated_current for run in runs])
    power = np.sum(prediction.rows.weight[: len(torque)] * torque**2, axis=0)
    failing = failing_joints(together, alone, power, revolute)
    share, own = (np.sqrt(e / np.where(power > 0.0, power, np.nan)) for e in (together, alone))
    pooled = pooled_share(together, power, revolute)
    return Adequacy(share, own, pooled, failing, tuple(large_misfits(problem, prediction, errors, failing)))


def shared_values(prediction: Prediction, bodies: int) -> np.ndarray:
    """Unknowns fitted without each block, the first `bodies` of them without a prior, shape (k, b)."""
    std = np.array(prediction.rows.std)
    std[:bodies] *= UNKNOWN
    return replace(prediction, rows=replace(prediction.rows, std=std)).left_out


def separate_errors(prediction: Prediction, shared: np.ndarray) -> np.ndarray:
    """Squared errors of left-out blocks with parameters of each joint alone, shape (k, n) [(N m)^2].

    These parameters stay near the shared ones, shape (k, b), where the joint does not determine them.
    """
    sums, alone = prediction.sums, []
    joints = zip(sums.acting, sums.squares, sums.products, prediction.weighting.weight.T, strict=True)
    for acting, squares, products, weight in joints:
        separate, grams, rights = shared[:, acting], (squares.T * weight).T, (products.T * weight).T
        matrix, side = grams.sum(axis=0), rights.sum(axis=0)
        prior = OWN * np.diag(matrix)
        for block, (gram, right) in enumerate(zip(grams, rights, strict=True)):
            factor = factored(matrix - gram + np.diag(prior))
            separate[block] = solve(factor, side - right + prior * separate[block])
        alone.append(separate)
    return sums.sums(np.square(sums.torque - sums.torque_of(alone)))


def large_misfits(
    problem: Problem, prediction: Prediction, errors: np.ndarray, failing: tuple[int, ...]
) -> Iterator[Misfit]:
    """Times in which squared errors (k, n) of failing joints are far larger than in most fitted blocks."""
    blocks = problem.blocks
    level = errors / np.maximum(prediction.sums.counts, 1.0)
    large = (level > CONCENTRATED**2 * np.median(level[blocks.fitted], axis=0)) & blocks.fitted[:, None]
    for run, here in zip(problem.runs, prediction.rows.runs, strict=True):
        time = run.motion.time[run.centres]
        for joint in failing:
            inside = np.pad(large[blocks.number[here], joint], 1)
            edges = np.flatnonzero(np.diff(inside.astype(int))).reshape(-1, 2)
            for first, last in edges - [0, 1]:
                yield Misfit(run.prepared.name, float(time[first]), float(time[last]), joint)
