"""Link encoders: gears whose twist is measured, by encoders before and behind them.

The twist is the load over the stiffness, beside a zero in each run, what the gear's own friction holds back,
and the time by which one encoder is read later than the other. At a millisecond that is most of what is
measured, and torque, which friction makes depend on velocity, would be taken for its cause. The stiffness is
asked for like any other effect: do the load and the blocks of other times predict the twist? Motors are
modelled where their own encoders measure, so that a stiff gear adds nothing to the torque that is fitted;
the torque of a soft one, by which its link swings, is taken where the blocks show it, with its damping.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...effects.smooth_sign import smooth_sign
from ..blocks.blocks import period
from ..blocks.prediction import Prediction
from ..candidates.joint_elasticity import of_stiffness
from ..questions.block_answer import Answer
from ..questions.candidate import Candidate, Thinned
from ..questions.comparison import colouring
from ..questions.question import ask
from ..questions.shape import refined
from ..runs.driven import Driven
from ..runs.rows import Rows
from .problem import Problem
from .selected import CERTAIN_ODDS, Selected, odds_of

SIGN = 0.003
"""Speed within which a gear's friction reverses [rad/s]."""


def measured_gears(problem: Problem) -> list[Selected]:
    """Elastic gears whose twist depends on their load, the most certain first."""
    if all(run.prepared.link_position is None for run in problem.runs):
        return []
    # Every run has a zero of its own, so that there is none to be predicted only.
    blocks = replace(problem.blocks, fitted=np.ones(len(problem.blocks), bool))
    prediction = Prediction.of(_rows(problem), blocks, 1.0 / period(problem.runs[0]))
    found = []
    for answer in ask(prediction, _loads(problem, prediction)):
        one = colouring(prediction, answer)
        odds = odds_of(one, prediction.joints)
        if odds > CERTAIN_ODDS:
            found.append(Selected(_as_gear(problem, prediction, one), odds, (), once=True))
    found.sort(key=lambda one: -one.odds)
    for place, gear in enumerate(found):
        before = problem.prediction([other.answer for other in found[:place]])
        found[place] = _swinging(problem, before, gear.answer.candidate) or gear
    return found


def _swinging(problem: Problem, prediction: Prediction, gear: Candidate) -> Selected | None:
    """The gear with the torque of a link that swings on it; None where blocks do not show that."""
    gear = of_stiffness(problem.model, gear.joints[0], gear.shape["stiffness"], gear.known["stiffness"])
    for answer in ask(prediction, [(gear, Thinned.of(gear, problem.runs))]):
        best = refined(prediction, answer, problem.runs)
        odds = odds_of(best, prediction.joints)
        if odds > CERTAIN_ODDS:
            return Selected(best, odds)
    return None


def _rows(problem: Problem) -> Rows:
    """Twist of each gear (r, n) [rad], with friction's hold, time and the zero in each run as unknowns."""
    joints, each = problem.model.robot.dof, len(problem.runs) + 2
    twist = np.concatenate([_twist(run) for run in problem.runs])
    velocity = np.concatenate([run.thinned(run.motion.velocity) for run in problem.runs])
    sign = np.concatenate([run.thinned(smooth_sign(run.motion.velocity, SIGN)) for run in problem.runs])
    columns = np.zeros((*twist.shape, joints * each))
    for joint in range(joints):
        columns[:, joint, joint * each] = sign[:, joint]
        columns[:, joint, joint * each + 1] = velocity[:, joint]
        for number, rows in enumerate(problem.base.runs):
            columns[rows, joint, joint * each + number + 2] = 1.0
    known, count = np.isfinite(twist), joints * each
    return Rows(
        problem.base.runs,
        np.where(known, twist, 0.0),
        problem.base.weight * known,
        columns,
        tuple(f"twist{place}" for place in range(count)),
        np.full(count, np.inf),
        np.zeros(count),
    )


def _twist(run: Driven) -> np.ndarray:
    """How far motors lead their links, shape (r, n) [rad]; NaN where it was not measured."""
    behind = run.prepared.link_position
    if behind is None:
        return np.full((run.rows, run.motion.position.shape[1]), np.nan)
    return run.thinned(run.motion.position - behind)


def _loads(problem: Problem, prediction: Prediction) -> Iterator[tuple[Candidate, Thinned]]:
    """The load of every gear whose twist was measured, per unit of compliance."""
    load = np.concatenate([run.thinned(run.motion.load) for run in problem.runs])
    for joint in np.flatnonzero(prediction.rows.weight.any(axis=0)):
        candidate = Candidate(
            "joint_elasticity", (int(joint),), _not_of_torque, ("compliance",), ("rad/(N m)",), (0.0,)
        )
        usual = float(np.sqrt(np.mean(load[:, joint] ** 2)))
        twist = float(np.sqrt(np.mean(prediction.rows.difference[:, joint] ** 2)))
        std = np.array([twist / max(usual, 1e-12)])
        yield candidate, Thinned(np.array([joint]), load[:, [joint], None], std, np.zeros(1))


def _not_of_torque(run: Driven) -> np.ndarray:
    raise NotImplementedError("a compliance gives twist, not torque")


def _as_gear(problem: Problem, prediction: Prediction, answer: Answer) -> Answer:
    """The gear of that stiffness among the columns of torque, there whole."""
    [joint], [compliance] = answer.candidate.joints, answer.values
    left = list(_left_out(prediction, answer))
    spread = float(np.sqrt((len(left) - 1) * np.var(left)))
    std = spread / float(compliance) ** 2
    gear = of_stiffness(problem.model, joint, 1.0 / float(compliance), std)
    gear = replace(gear, bounds={}, known={"stiffness": std})
    still = np.zeros((len(prediction.rows.difference), 1, 1))
    columns = replace(answer.columns, values=still, mean=np.ones(1))
    return replace(answer, candidate=gear, columns=columns, values=np.ones(1), free=np.zeros(1, bool))


def _left_out(prediction: Prediction, answer: Answer) -> Iterator[float]:
    """The compliance without each block."""
    [joint] = answer.columns.joints
    own = prediction.rows.columns[:, joint][:, prediction.sums.acting[joint]]
    columns = np.column_stack([own, answer.columns.values[:, 0]])
    for rows in prediction.blocks.rows:
        kept = prediction.rows.weight[:, joint] > 0
        kept[rows] = False
        yield float(
            np.linalg.lstsq(columns[kept], prediction.rows.difference[kept, joint], rcond=None)[0][-1]
        )
