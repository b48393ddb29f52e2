"""Motor torque with all findings, so that gain errors scale the torque of findings too.

A recorded current times the nominal gain is the motor torque, times one minus the relative error of the gain.
A search linearizes this product about the torque of the model, without the findings that gears do not
transmit. Without a correction, the parameters of those findings would be too small by the error of the gain,
and their intervals would not include its tolerance.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...text_table import NORMAL_95, digits
from ..candidates import kind_of
from ..questions.block_answer import Answer
from ..runs.driven import Driven
from ..runs.rows import GAIN, with_nuisances
from ..search.problem import Problem, anew
from ..search.search import SearchResult
from ..search.selected import answers_of
from .evidence import Spread, places_of

SHOWN = 0.5
"""Standard deviation of a gain above which the runs do not determine it, relative to its tolerance [-]."""
TURNS = 2
"""Number of alternations between torque and gains: with gain errors of a tenth, each reduces the error
tenfold, so about a thousandth remains."""


def with_all_torque(result: SearchResult) -> SearchResult:
    """The result with all findings in the motor torque; unchanged if torque was recorded.

    It is unchanged too if no gain is stated: torque then means current, whatever the gain.
    """
    start, answers = result.problem, answers_of(result.selected)
    unstated = bool(np.all(start.model.robot.drive_gain == 1.0))
    missing = [
        place
        for place, finding in enumerate(result.selected)
        if not finding.once and _is_missing(finding.answer)
    ]
    if not missing or unstated or start.runs[0].prepared.measures != "current":
        return result
    for _ in range(TURNS):
        values = [result.prediction.values[places_of(result, place)] for place in missing]
        problem, answers = _driving(start, answers, missing, values)
        pairs = zip(result.selected, answers, strict=True)
        selected = [finding._replace(answer=answer) for finding, answer in pairs]
        prediction = problem.prediction(answers, result.prediction)
        result = replace(result, problem=problem, selected=tuple(selected), prediction=prediction)
    return result


def undetermined_gains(result: SearchResult, spread: Spread) -> list[str]:
    """A warning that names the drive gains that the runs do not determine; empty without any.

    Only joints with a finding count, since the size of the finding is as uncertain as the gain.
    """
    names, joints = result.prediction.rows.names, result.problem.model.robot.joints
    std, half, open_gains = np.sqrt(np.diag(spread.covariance)), [], []
    lasting = [finding.answer for finding in result.selected if not finding.once]
    for joint in sorted({answer.joint for answer in lasting}):
        place = names.index(f"{GAIN}{joint + 1}") if f"{GAIN}{joint + 1}" in names else None
        if place is not None and std[place] > SHOWN * result.prediction.rows.std[place] > 0.0:
            half.append(100.0 * NORMAL_95 * float(std[place]))
            open_gains.append(joints[joint])
    if not open_gains:
        return []
    return [
        f"torques of {', '.join(open_gains)} are as uncertain as the gains, \N{PLUS-MINUS SIGN} "
        f"{digits(max(half), 2)} %: a run with a known payload helps"
    ]


def _is_missing(answer: Answer) -> bool:
    """Whether motors produce its torque and the torque of the runs does not contain it yet."""
    candidate = answer.candidate
    recorded_otherwise = candidate.reloads or kind_of(candidate.effect).sensor
    return not (candidate.carried or recorded_otherwise)


def _driving(
    problem: Problem, answers: Sequence[Answer], missing: Sequence[int], values: Sequence[np.ndarray]
) -> tuple[Problem, list[Answer]]:
    """The problem with the torque of some answers added to the motor torque, and the answers for it."""

    def driven(run: Driven) -> Driven:
        pairs = zip(missing, values, strict=True)
        added = [answers[place].candidate.columns(run) @ vector for place, vector in pairs]
        return replace(run, torque=run.torque + np.sum(added, axis=0))

    runs = tuple(map(driven, problem.runs))
    rows = with_nuisances(problem.base, problem.model, runs, problem.known.values)
    rows = replace(
        rows, weight=problem.rows.weight, std=problem.rows.std
    )  # these may be held at nominal values
    fresh = [replace(answer, columns=anew(answer.candidate, answer.columns, runs)) for answer in answers]
    return replace(problem, runs=runs, rows=rows), fresh
