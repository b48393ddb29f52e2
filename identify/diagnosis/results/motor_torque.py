"""Motor torque with all findings: what drive gains scale, so that a finding's numbers have their tolerance.

A recorded current times the nominal gain is the motor's torque, times one less the share by which that gain
is too small. A search takes this product to first order about the model's torque without the findings that
gears do not transmit. The numbers of those would then be too small by the same share, and their intervals
would not contain the tolerance of the gain.
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
"""Standard deviation of a gain over its stated tolerance above which the runs show less of it than is stated:
of two that know the same, one and a half."""
TURNS = 2
"""Times that torque and gains are fitted in turn: what is wrong after each is smaller by a gain's share of a
tenth, so that a thousandth is left."""


def with_all_torque(result: SearchResult) -> SearchResult:
    """The result with motor torque that has all findings in it; as it is where torque was recorded."""
    start, answers = result.problem, answers_of(result.selected)
    missing = [
        place
        for place, finding in enumerate(result.selected)
        if not finding.once and _is_missing(finding.answer)
    ]
    if not missing or start.runs[0].prepared.measures != "current":
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
    """A sentence that names the drive gains of which the runs tell less than is stated; none without any.

    Only of joints on which a finding is: what is said of its size is as uncertain as they are.
    """
    names, joints = result.prediction.rows.names, result.problem.model.robot.joints
    std, half, open_gains = np.sqrt(np.diag(spread.covariance)), [], []
    lasting = [finding.answer for finding in result.selected if not finding.once]
    for joint in sorted({int(np.argmax(answer.by_joint)) for answer in lasting}):
        place = names.index(f"{GAIN}{joint + 1}") if f"{GAIN}{joint + 1}" in names else None
        if place is not None and std[place] > SHOWN * result.prediction.rows.std[place] > 0.0:
            half.append(100.0 * NORMAL_95 * float(std[place]))
            open_gains.append(joints[joint])
    if not open_gains:
        return []
    return [
        f"these runs do not determine the drive gain of {', '.join(open_gains)}: torques and masses there "
        f"are as uncertain as stated gains are, \N{PLUS-MINUS SIGN} {digits(max(half), 2)} % (95 %). "
        "A run with a body of known mass on the flange determines them"
    ]


def _is_missing(answer: Answer) -> bool:
    """Whether motors give its torque, and that torque is not in the runs' yet."""
    candidate = answer.candidate
    recorded_otherwise = candidate.reloads or kind_of(candidate.effect).sensor
    return not (candidate.carried or recorded_otherwise)


def _driving(
    problem: Problem, answers: Sequence[Answer], missing: Sequence[int], values: Sequence[np.ndarray]
) -> tuple[Problem, list[Answer]]:
    """The problem with the torque of some answers in that of its motors, and the answers at that torque."""

    def driven(run: Driven) -> Driven:
        pairs = zip(missing, values, strict=True)
        more = [answers[place].candidate.columns(run) @ own for place, own in pairs]
        return replace(run, torque=run.torque + np.sum(more, axis=0))

    runs = tuple(map(driven, problem.runs))
    rows = with_nuisances(problem.base, problem.model, runs, problem.known.values)
    rows = replace(rows, weight=problem.rows.weight, std=problem.rows.std)  # which may be held at nominal
    fresh = [replace(answer, columns=anew(answer.candidate, answer.columns, runs)) for answer in answers]
    return replace(problem, runs=runs, rows=rows), fresh
