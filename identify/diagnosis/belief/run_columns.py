"""Columns of everything that may act on an arm, over a run that has not been made."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...fit.identification import with_payloads
from ...recordings.recording import Recording
from ..blocks.prediction import CERTAIN
from ..questions.block_answer import Answer
from ..questions.candidate import Thinned
from ..runs.driven import Driven
from ..runs.rows import Rows, model_rows, with_nuisances
from ..search.problem import Problem, with_found

ENOUGH = 2.5
"""Samples a period of the highest frequency that a motion without noise needs: two, and a filter's edge."""


@dataclass(frozen=True, eq=False)
class RunColumns:
    """Torque per unit of everything, over the rows of one run.

    Attributes:
        rows: Unknowns of the model, its nuisances and all findings.
        suspects: Columns of each suspect, in the order in which they were given.
        torque: Torque of the motors by the fitted model, shape (r, n) [N m].
    """

    rows: Rows
    suspects: tuple[Thinned, ...]
    torque: np.ndarray

    def split(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Columns, and what the run brings of its own: unknowns of a body that no run has carried so far.

        Returns:
            Columns of named unknowns and all suspects (r, n, c), of the others (r, n, e); precision of these
            (e,).
        """
        place = {name: k for k, name in enumerate(self.rows.names)}
        known = self.rows.columns[:, :, [place[name] for name in names]]
        shared = np.concatenate([known, *(one.everywhere(known.shape[1]) for one in self.suspects)], axis=2)
        own = [k for name, k in place.items() if name not in set(names)]
        return shared, self.rows.columns[:, :, own], np.maximum(self.rows.std[own], CERTAIN) ** -2.0


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
    rows = with_found(rows, [_over(one, run) for one in found])
    return RunColumns(rows, tuple(_over(one, run).columns for one in suspects), run.thinned(run.torque))


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
