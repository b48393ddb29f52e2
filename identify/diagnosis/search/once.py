"""Once: events that no other block predicts: contacts, whose samples are excluded, and other moments."""

import numpy as np

from ...positive_definite import inverse
from ..blocks.prediction import LINEAR, Prediction
from ..candidates.contact_event import Contact, candidate, contacts, share
from ..findings.diagnosis import Moment
from ..questions.block_answer import CERTAIN_ODDS, Answer
from ..questions.candidate import Thinned
from .problem import Problem
from .selected import Selected

FEW = 3
"""Maximum number of contacts in a search: what happens more often is a recurring effect, not a contact."""
MOST = 10
"""Maximum number of moments that are reported."""
SEEN = 0.05
"""Gain of a joint, relative to the joint that gains most, from which on it counts as affected [-]."""
MARGIN = 0.2
"""Time before and after a contact that is excluded with it [s]: a push begins and ends within it."""
INTERVAL = 1.96
"""Half width of a 95 % interval, in standard deviations."""
PARTS = 4.0
"""Least number of independent rows of a contact: its window is found to a quarter of its duration, so its
residual has that many independent parts."""


def with_contacts(problem: Problem, findings: list[Selected]) -> tuple[Problem, list[Selected]]:
    """The problem and the findings with all contacts; unchanged if there are too many to be contacts."""
    reduced, extended = problem, list(findings)
    for _ in range(FEW + 1):
        contact = _contact(reduced, reduced.prediction([finding.answer for finding in extended]))
        if contact is None:
            return reduced, extended
        reduced, extended = contact[0], [*extended, contact[1]]
    return problem, findings


def _contact(problem: Problem, prediction: Prediction) -> tuple[Problem, Selected] | None:
    """The problem without the samples of the most credible contact, and that contact; None without any."""
    best = next(iter(contacts(problem.model, prediction, problem.runs, problem.flange_torques)), None)
    if best is None or not _pushes(problem, prediction, best):
        return None
    odds = min(best.gain, best.gain_without_best_joint) - np.log(len(problem.tried))
    if not odds > CERTAIN_ODDS:
        return None
    selected = Selected(_answer(problem, prediction, best), odds, (), True)
    return problem.excluding(_during(problem, prediction, best)), selected


def _pushes(problem: Problem, prediction: Prediction, contact: Contact) -> bool:
    """Whether the interval of a contact's force excludes zero along at least one axis.

    On at least two joints, its torque must also exceed the sensors' error of their usual torque.
    """
    flange_torque, rows = problem.flange_torques[contact.run], prediction.rows.runs[contact.run]
    size = share(flange_torque.time, contact.start, contact.duration)
    columns = flange_torque.torque * size[:, None, None]
    torque, usual = columns @ contact.force, np.concatenate([run.torque for run in problem.runs])
    large = np.mean(torque[size > 0.0] ** 2, axis=0) > LINEAR**2 * np.mean(usual**2, axis=0)
    during = prediction.rows.weight[rows] * (size > 0.0)[:, None]
    unexplained = np.sum(during * (prediction.residual[rows] - torque) ** 2, axis=0)
    noise = np.maximum(prediction.weighting.variance / prediction.weighting.independent, unexplained / PARTS)
    std = np.sqrt(np.diag(inverse(np.einsum("rnp,rn,rnq->pq", columns, during / noise, columns))))
    return bool(np.count_nonzero(large) >= 2 and np.any(np.abs(contact.force) > INTERVAL * std))


def moments(problem: Problem, prediction: Prediction) -> list[Moment]:
    """Windows of all runs in which a force explains far more than at other times, largest gain first."""
    reported: list[Contact] = []
    for contact in contacts(problem.model, prediction, problem.runs, problem.flange_torques):
        if contact.gain < CERTAIN_ODDS or len(reported) == MOST:
            break
        same_run = [other for other in reported if other.run == contact.run]
        if all(abs(contact.middle - other.middle) >= contact.duration + other.duration for other in same_run):
            reported.append(contact)
    return [_moment(contact) for contact in reported]


def _moment(contact: Contact) -> Moment:
    joints = np.flatnonzero(contact.gains > SEEN * contact.gains.max())
    # A force on the flange would act on several joints, so one joint alone shows none.
    force = contact.force if len(joints) > 1 else np.full(3, np.nan)
    size = float(np.linalg.norm(force))
    end = contact.start + contact.duration
    return Moment(contact.name, contact.start, end, tuple(map(int, joints)), force / max(size, 1e-300), size)


def _during(problem: Problem, prediction: Prediction, contact: Contact) -> np.ndarray:
    """Whether each row belongs to a contact, shape (r,)."""
    during = np.zeros(len(prediction.rows.difference), bool)
    run, rows = problem.runs[contact.run], prediction.rows.runs[contact.run]
    time = run.motion.time[run.centres]
    during[rows] = (time > contact.start - MARGIN) & (time < contact.start + contact.duration + MARGIN)
    return during


def _answer(problem: Problem, prediction: Prediction, contact: Contact) -> Answer:
    """Answer for a contact, whose coefficients are the force fitted to its window."""
    pushed, errors = candidate(problem.model, contact), prediction.errors
    gains, zeros = np.zeros(errors.shape), np.zeros(len(errors))
    during = np.flatnonzero(_during(problem, prediction, contact))
    gains[prediction.blocks.number[during[len(during) // 2]]] = contact.gains
    columns, held = Thinned.of(pushed, problem.runs), np.zeros(len(contact.force), bool)
    weighting = prediction.weighting.independent, np.ones(len(errors), bool)
    return Answer(
        pushed,
        columns,
        contact.force,
        held,
        errors,
        errors,
        zeros,
        zeros,
        gains,
        *weighting,
        np.log(contact.among),
    )
