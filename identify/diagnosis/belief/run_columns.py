"""Columns of everything that may act on an arm, over a run that has not been made."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ...fit.identification import with_payloads
from ...recordings.recording import Recording, Signal
from ..blocks.prediction import CERTAIN
from ..questions.block_answer import Answer
from ..questions.candidate import Thinned
from ..runs.driven import Driven
from ..runs.rows import Rows, model_rows, with_nuisances
from ..search.mismatch import splines_of, with_mismatches
from ..search.problem import Problem, with_findings

LONGEST = 100.0
"""Length of a planned motion that is looked at at once [s]: columns of six joints take 0.4 GB of it, and
filters a few seconds off its ends."""
ENOUGH = 2.5
"""Samples a period of the highest frequency that a motion without noise needs: two, and a filter's edge."""


@dataclass(frozen=True, eq=False)
class RunColumns:
    """Products of the torques per unit of everything, over the rows of one run.

    No rows are kept: a study asks for tens of runs, each of which has hundreds of megabytes of them.

    Attributes:
        names: Unknowns of the model, its nuisances and all findings, b of them.
        std: How far each of these may be from its mean, shape (b,).
        suspects: The same of the coefficients of each suspect, in the order in which they were given.
        each: Products of all columns, those of suspects last, on each joint where it slides, (n, c, c).
        power: Mean square torque of each motor by the fitted model, shape (n,) [(N m)^2].
        rows: Number of rows.
    """

    names: tuple[str, ...]
    std: np.ndarray
    suspects: tuple[np.ndarray, ...]
    each: np.ndarray
    power: np.ndarray
    rows: int

    def products(self, names: Sequence[str], weight: np.ndarray) -> tuple[np.ndarray, int]:
        """Products of named unknowns, all suspects and then all other unknowns, joints weighted (n,).

        Others are what the run brings of its own: unknowns of a body that no run has carried so far.

        Returns:
            Products, shape (c, c), and the number of those that are shared with other runs.
        """
        place = {name: k for k, name in enumerate(self.names)}
        shared = [*(place[name] for name in names), *range(len(self.names), len(self.each[0]))]
        own = self._own(names)
        order = np.array([*shared, *own])
        return np.tensordot(weight, self.each, axes=1)[np.ix_(order, order)], len(shared)

    def known(self, names: Sequence[str]) -> np.ndarray:
        """Precision of the priors of those others, shape (e,)."""
        return np.maximum(self.std[self._own(names)], CERTAIN) ** -2.0

    def _own(self, names: Sequence[str]) -> list[int]:
        shared = set(names)
        return [k for k, name in enumerate(self.names) if name not in shared]


def run_columns(
    problem: Problem,
    found: Sequence[Answer],
    suspects: Sequence[Answer],
    recording: Recording,
    planned: bool = False,
) -> RunColumns:
    """What a recording would be explained by; of its torque or current only that it was recorded matters.

    Args:
        problem: Problem of the runs so far.
        found: Findings.
        suspects: What may be there beside them.
        recording: Recording of a planned motion as simulated, or one that exists.
        planned: Whether it is simulated, so that it has no noise that a lower rate would make more of.

    Raises:
        RecordingError: It cannot be filtered as the others were.
    """
    pieces = _pieces(recording) if planned else [recording]
    return _together([_piece_columns(problem, found, suspects, one, planned) for one in pieces])


def _pieces(recording: Recording) -> list[Recording]:
    """Stretches of equal length, of no more than `LONGEST`, and one after the other."""
    count = int(np.ceil(recording.duration / LONGEST))
    if count < 2:
        return [recording]
    times = [one.time for one in recording.signals.values()]
    ends = np.linspace(min(one[0] for one in times), max(one[-1] for one in times), count + 1)
    ends[-1] = np.inf
    return [
        replace(recording, signals={name: _within(one, *pair) for name, one in recording.signals.items()})
        for pair in pairwise(ends)
    ]


def _within(signal: Signal, begin: float, end: float) -> Signal:
    kept = (signal.time >= begin) & (signal.time < end)
    return replace(signal, time=signal.time[kept], values=signal.values[kept])


def _together(pieces: Sequence[RunColumns]) -> RunColumns:
    """Of several stretches of a run: products add up; the stretch that shows a suspect best limits it."""
    rows = np.array([one.rows for one in pieces])
    return replace(
        pieces[0],
        suspects=tuple(np.min(own, axis=0) for own in zip(*(one.suspects for one in pieces), strict=True)),
        each=sum((one.each for one in pieces[1:]), pieces[0].each),
        power=np.average([one.power for one in pieces], axis=0, weights=rows),
        rows=int(rows.sum()),
    )


def _piece_columns(
    problem: Problem, found: Sequence[Answer], suspects: Sequence[Answer], recording: Recording, planned: bool
) -> RunColumns:
    model = with_payloads(problem.model, [recording])
    before = dict(zip(problem.model.names, problem.known.values, strict=True))
    values = np.array(
        [before.get(name, nominal) for name, nominal in zip(model.names, model.nominal_values, strict=True)]
    )
    filtering, own = problem.runs[0].filtering, problem.runs[0].prepared
    if planned:
        thinned = own.decimation.thinned(ENOUGH * own.position_cutoff)
        filtering = replace(filtering, rate=thinned.rate / thinned.step)
    run = Driven.of(model, replace(recording, model=model), "offered", filtering)
    run = replace(problem.known, model=model, values=values).on(run)
    rows = with_nuisances(model_rows(model, [run], values), model, [run], values)
    formulas, here = problem.mismatches(found), [_over(one, run) for one in found]
    splines = {one.place: splines_of(one.effect, model, [run]) for one in formulas}
    rows = with_findings(with_mismatches(rows, formulas, here, splines), here)
    over = [_over(one, run).columns for one in suspects]
    torque = run.thinned(run.torque)
    return RunColumns(
        rows.names,
        rows.std,
        tuple(one.std for one in over),
        _by_joint(rows, over),
        np.mean(torque**2, axis=0),
        len(torque),
    )


def _by_joint(rows: Rows, suspects: Sequence[Thinned]) -> np.ndarray:
    """Products of all columns on each joint, rows weighted, shape (n, c, c)."""
    joints = rows.difference.shape[1]
    found = []
    for joint in range(joints):
        own = [one.values[:, one.joints == joint].sum(axis=1) for one in suspects]
        columns = np.concatenate([rows.columns[:, joint], *own], axis=1)[:, None]
        found.append(products(columns, rows.weight[:, joint, None]))
    return np.array(found)


def products(columns: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Products of columns (r, n, c) over rows and joints with a weight (r, n), shape (c, c)."""
    flat = (columns * np.sqrt(weight)[:, :, None]).reshape(-1, columns.shape[2])
    return flat.T @ flat


def _over(answer: Answer, run: Driven) -> Answer:
    """The answer over another run; columns of zeros where that has no record of what they take."""
    columns = Thinned.of(answer.candidate, [run])
    if columns.empty:
        count, joints = len(answer.candidate.names), answer.columns.joints
        nothing = np.zeros((run.rows, len(joints), count))
        columns = Thinned(joints, nothing, np.full(count, np.inf), np.zeros(count))
    return replace(answer, columns=columns)
