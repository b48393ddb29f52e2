"""Once: what no other block predicts: contacts, which are set aside, and other moments that differ."""

import numpy as np

from ..blocks.prediction import LINEAR, Prediction
from ..candidates.contact_event import Contact, candidate, contacts, share
from ..findings.diagnosis import Moment
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.candidate import Thinned
from .problem import Problem
from .selected import Selected

FEW = 3
"""Contacts of one search: what happens more often is no contact, but something that comes again."""
MOST = 10
"""Moments that are reported."""
SEEN = 0.05
"""Share of what is gained on the joint that sees most from which on another sees it too [-]."""
MARGIN = 0.2
"""Time about a contact that is set aside with it [s]: a push begins and ends within it."""


def only_once(problem: Problem, found: list[Selected]) -> tuple[Problem, list[Selected]]:
    """The problem and the findings with all contacts beside them; none where there are too many to be any."""
    wider, more = problem, list(found)
    for _ in range(FEW + 1):
        pushed = _contact(wider, wider.prediction([one.answer for one in more]))
        if pushed is None:
            return wider, more
        wider, more = pushed[0], [*more, pushed[1]]
    return problem, found


def _contact(problem: Problem, prediction: Prediction) -> tuple[Problem, Selected] | None:
    """The most credible contact, and the problem without the time that it takes; None without any.

    At least two joints must feel more than the sensors' error of their usual torque.
    """
    best = next(iter(contacts(problem.model, prediction, problem.runs, problem.reaches)), None)
    if best is None:
        return None
    usual = np.sqrt(np.mean(np.concatenate([run.torque for run in problem.runs]) ** 2, axis=0))
    odds = min(best.gain, best.without_one) - np.log(len(problem.tried))
    if np.count_nonzero(_torque(problem, best) > LINEAR * usual) < 2 or not odds > CERTAIN_ODDS:
        return None
    found = Selected(_answer(problem, prediction, best), odds, (), True)
    return problem.without(_during(problem, prediction, best)), found


def _torque(problem: Problem, one: Contact) -> np.ndarray:
    """Root mean square of the torque of a contact while it lasts, shape (n,) [N m]."""
    reach = problem.reaches[one.run]
    during = (reach.time >= one.start) & (reach.time <= one.start + one.duration)
    size = share(reach.time[during], one.start, one.duration)
    torque = reach.torque[during] @ one.force * size[:, None]
    return np.asarray(np.sqrt(np.mean(torque**2, axis=0)))


def moments(problem: Problem, prediction: Prediction) -> list[Moment]:
    """Windows of all runs in which a force explains far more than at other times, the greatest first."""
    found: list[Contact] = []
    for one in contacts(problem.model, prediction, problem.runs, problem.reaches):
        if one.gain < CERTAIN_ODDS or len(found) == MOST:
            break
        same = [other for other in found if other.run == one.run]
        if all(abs(one.middle - other.middle) >= one.duration + other.duration for other in same):
            found.append(one)
    return [_moment(one) for one in found]


def _moment(one: Contact) -> Moment:
    joints = np.flatnonzero(one.gains > SEEN * one.gains.max())
    # What one joint alone shows is no force on the flange, which the others would feel.
    force = one.force if len(joints) > 1 else np.full(3, np.nan)
    size = float(np.linalg.norm(force))
    end = one.start + one.duration
    return Moment(one.name, one.start, end, tuple(map(int, joints)), force / max(size, 1e-300), size)


def _during(problem: Problem, prediction: Prediction, one: Contact) -> np.ndarray:
    """Rows of a contact, shape (r,)."""
    found = np.zeros(len(prediction.rows.difference), bool)
    run, rows = problem.runs[one.run], prediction.rows.runs[one.run]
    time = run.motion.time[run.centres]
    found[rows] = (time > one.start - MARGIN) & (time < one.start + one.duration + MARGIN)
    return found


def _answer(problem: Problem, prediction: Prediction, one: Contact) -> Answer:
    """As columns whose coefficients are what they were where it happened."""
    pushed, errors = candidate(problem.model, one), prediction.errors
    gains, still = np.zeros(errors.shape), np.zeros(len(errors))
    during = np.flatnonzero(_during(problem, prediction, one))
    gains[prediction.blocks.number[during[len(during) // 2]]] = one.gains
    columns, held = Thinned.of(pushed, problem.runs), np.zeros(len(one.force), bool)
    weighed = prediction.weighting.independent, np.ones(len(errors), bool)
    return Answer(
        pushed, columns, one.force, held, errors, errors, still, still, gains, *weighed, np.log(one.among)
    )
