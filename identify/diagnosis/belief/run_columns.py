"""Columns of all unknowns and suspects over a run that has not been made."""

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
"""Longest duration of a planned motion that is evaluated at once [s]: its columns take 0.4 GB for six joints;
filters cut a few seconds at the ends."""
ENOUGH = 2.5
"""Samples per period at the highest frequency of a motion without noise: two, plus a margin for filters."""


@dataclass(frozen=True, eq=False)
class RunColumns:
    """Products of the columns of all unknowns and suspects over the rows of one run.

    Rows are not stored: a study evaluates tens of runs, each with hundreds of megabytes of rows.
    """

    names: tuple[str, ...]  # names of the unknowns: model, nuisances and findings, b of them
    std: np.ndarray  # prior standard deviation of these unknowns, shape (b,)
    # expected deviations of the coefficients of each suspect, in the order of the suspects
    suspects: tuple[np.ndarray, ...]
    # products of all columns on each joint while it slides, suspects last, shape (n, c, c)
    by_joint: np.ndarray
    power: np.ndarray  # mean square torque of each motor by the fitted model, shape (n,) [(N m)^2]
    rows: int  # number of rows

    def products(self, names: Sequence[str], weight: np.ndarray) -> tuple[np.ndarray, int]:
        """Products of named unknowns, all suspects and then all other unknowns, joints weighted (n,).

        The other unknowns exist only in this run: those of a body that no run has carried so far.

        Returns:
            Products, shape (c, c), and the number of leading columns that other runs share.
        """
        place = {name: k for k, name in enumerate(self.names)}
        shared = [*(place[name] for name in names), *range(len(self.names), len(self.by_joint[0]))]
        order = np.array([*shared, *self._extra(names)])
        return np.tensordot(weight, self.by_joint, axes=1)[np.ix_(order, order)], len(shared)

    def known(self, names: Sequence[str]) -> np.ndarray:
        """Prior precision of the unknowns that are not among `names`, shape (e,)."""
        return np.maximum(self.std[self._extra(names)], CERTAIN) ** -2.0

    def _extra(self, names: Sequence[str]) -> list[int]:
        shared = set(names)
        return [k for k, name in enumerate(self.names) if name not in shared]


def run_columns(
    problem: Problem,
    findings: Sequence[Answer],
    suspects: Sequence[Answer],
    recording: Recording,
    planned: bool = False,
) -> RunColumns:
    """Columns of a recording; its torque or current does not matter, only which of them was recorded.

    Args:
        problem: Problem of the runs so far.
        findings: Answers of the findings.
        suspects: Effects besides the findings that may be there.
        recording: Simulated recording of a planned motion, or an existing one.
        planned: Whether it is simulated, so that it has no noise, which a lower rate would amplify.

    Raises:
        RecordingError: If it cannot be filtered like the others.
    """
    pieces = _pieces(recording) if planned else [recording]
    return _together([_piece_columns(problem, findings, suspects, piece, planned) for piece in pieces])


def _pieces(recording: Recording) -> list[Recording]:
    """Consecutive pieces of equal duration, no longer than `LONGEST`."""
    count = int(np.ceil(recording.duration / LONGEST))
    if count < 2:
        return [recording]
    times = [signal.time for signal in recording.signals.values()]
    ends = np.linspace(min(time[0] for time in times), max(time[-1] for time in times), count + 1)
    ends[-1] = np.inf
    return [
        replace(
            recording, signals={name: _within(signal, *span) for name, signal in recording.signals.items()}
        )
        for span in pairwise(ends)
    ]


def _within(signal: Signal, begin: float, end: float) -> Signal:
    within = (signal.time >= begin) & (signal.time < end)
    return replace(signal, time=signal.time[within], values=signal.values[within])


def _together(pieces: Sequence[RunColumns]) -> RunColumns:
    """Columns of a run from its pieces: products add up; the piece that shows a suspect best limits it."""
    rows = np.array([piece.rows for piece in pieces])
    by_suspect = zip(*(piece.suspects for piece in pieces), strict=True)
    return replace(
        pieces[0],
        suspects=tuple(np.min(deviations, axis=0) for deviations in by_suspect),
        by_joint=sum((piece.by_joint for piece in pieces[1:]), pieces[0].by_joint),
        power=np.average([piece.power for piece in pieces], axis=0, weights=rows),
        rows=int(rows.sum()),
    )


def _piece_columns(
    problem: Problem,
    findings: Sequence[Answer],
    suspects: Sequence[Answer],
    recording: Recording,
    planned: bool,
) -> RunColumns:
    model = with_payloads(problem.model, [recording])
    before = dict(zip(problem.model.names, problem.known.values, strict=True))
    values = np.array(
        [before.get(name, nominal) for name, nominal in zip(model.names, model.nominal_values, strict=True)]
    )
    filtering, prepared = problem.runs[0].filtering, problem.runs[0].prepared
    if planned:
        thinned = prepared.decimation.thinned(ENOUGH * prepared.position_cutoff)
        filtering = replace(filtering, rate=thinned.rate / thinned.step)
    run = Driven.of(model, replace(recording, model=model), "offered", filtering)
    run = replace(problem.known, model=model, values=values).on(run)
    rows = with_nuisances(model_rows(model, [run], values), model, [run], values)
    formulas, answers = problem.mismatches(findings), [_over(finding, run) for finding in findings]
    splines = {formula.place: splines_of(formula.effect, model, [run]) for formula in formulas}
    rows = with_findings(with_mismatches(rows, formulas, answers, splines), answers)
    columns = [_over(suspect, run).columns for suspect in suspects]
    torque = run.thinned(run.torque)
    return RunColumns(
        rows.names,
        rows.std,
        tuple(thinned.std for thinned in columns),
        _by_joint(rows, columns),
        np.mean(torque**2, axis=0),
        len(torque),
    )


def _by_joint(rows: Rows, suspects: Sequence[Thinned]) -> np.ndarray:
    """Products of all columns on each joint over weighted rows, shape (n, c, c)."""
    joints = rows.difference.shape[1]
    by_joint = []
    for joint in range(joints):
        on_joint = [suspect.values[:, suspect.joints == joint].sum(axis=1) for suspect in suspects]
        columns = np.concatenate([rows.columns[:, joint], *on_joint], axis=1)[:, None]
        by_joint.append(products(columns, rows.weight[:, joint, None]))
    return np.array(by_joint)


def products(columns: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Products of columns (r, n, c) over rows and joints, weighted (r, n), shape (c, c)."""
    flat = (columns * np.sqrt(weight)[:, :, None]).reshape(-1, columns.shape[2])
    return flat.T @ flat


def _over(answer: Answer, run: Driven) -> Answer:
    """The answer with its columns over another run; zero if that run lacks a signal they need."""
    columns = Thinned.of(answer.candidate, [run])
    if columns.empty:
        count, joints = len(answer.candidate.names), answer.columns.joints
        zeros = np.zeros((run.rows, len(joints), count))
        columns = Thinned(joints, zeros, np.full(count, np.inf), np.zeros(count))
    return replace(answer, columns=columns)
