"""Joint elasticity: a gear that gives way, on which its link lags behind the motor, and swings.

How motors feel that is in `measurements/twist.py`. The stiffness shapes it: little matters below the
resonance but the load over the stiffness, and near it the link's own swing.

Where encoders behind the gears were recorded, the twist is measured: it is the load over the stiffness,
beside a zero in each run, what the gear's own friction holds back, and the time by which one encoder is read
later than the other. At a millisecond that is most of what is measured, and torque, which friction makes
depend on velocity, would be taken for its cause. Whether load and stiffness are in the twist is asked of
blocks that are left out, as of any other effect. Motors are modelled where their own encoders measure, so
that a stiff gear adds nothing to the torque that is fitted.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...effects import Shape
from ...effects.smooth_sign import smooth_sign
from ...measurements import JointElasticity
from ...model import Model
from ...simulation.plant.link_size import link_size
from ..blocks.prediction import Prediction
from ..findings.arm import Arm
from ..findings.finding import Hypothesis
from ..findings.kind import Kind
from ..questions.block_answer import STRANGE, Answer
from ..questions.candidate import Candidate, Thinned
from ..questions.candidate_fit import FORMULA
from ..questions.comparison import colouring
from ..questions.question import ask
from ..runs.driven import Driven
from ..runs.rows import Rows
from .gears import bending

STEP = 1.3
"""From one resonance to the next that is tried [-]."""
RESONANCES = tuple(3.0 * STEP**step for step in range(12))
"""Resonances of the mean link on its gear that are tried [Hz], up to 54: below, no drive holds its arm;
above, the fastest motion twists its gears by less than a fifteenth of a link's acceleration."""
RATIO = (STEP - 1.0) / 2.0
"""Damping ratio of the first look [-], 0.02 for steel and 0.2 for much grease: the width of a resonance,
twice its damping ratio, is the step to the next that is tried, so that no gear lies between two."""
SCATTER = 0.1
"""Deviation of the coefficient from 1, since the stiffness gives the size of the effect [-]: as much as
link's inertia and damping are wrong."""
LEAST = 0.5
"""Coefficient below which what fits is something else that swings [-]."""
SIGN = 0.003
"""Speed within which a gear's friction reverses [rad/s]."""


def gears(model: Model) -> Iterator[Candidate]:
    """Every joint's gear, from soft to stiff."""
    for joint, inertia in enumerate(link_size(model)[0]):
        # A joint that moves nothing has nothing to bend.
        for resonance in RESONANCES if inertia > 0.0 and model.robot.geared[joint] else ():
            yield _gear(model, joint, inertia, resonance, RATIO)


def _gear(
    model: Model, joint: int, inertia: float, resonance: float, ratio: float, within: Shape | None = None
) -> Candidate:
    """A gear whose mean link has that resonance [Hz]; refined about it, or within bounds."""
    angular = 2 * np.pi * resonance
    stiffness, loss = inertia * angular**2, 2 * ratio * inertia * angular

    def columns(run: Driven) -> np.ndarray:
        return bending(model, run, joint, (stiffness, loss))[:, :, None]

    def reshaped(given: Mapping[str, float]) -> Candidate:
        return _gear(model, joint, inertia, given["resonance"], given["damping_ratio"], within)

    within_step = Shape("Hz", resonance / STEP, resonance * STEP)
    bounds = {"resonance": within or within_step, "damping_ratio": Shape("1", 0.005, 0.5)}
    return Candidate(
        "joint_elasticity", (joint,), columns, ("share",), ("1",), (LEAST,),
        {"resonance": resonance, "damping_ratio": ratio, "stiffness": stiffness}, bounds, reshaped,
        expected=((1.0, SCATTER),), reported={"stiffness": (stiffness, "N m/rad")}, loaded=True,
    )  # fmt: skip


def of_stiffness(model: Model, joint: int, stiffness: float, std: float) -> Candidate:
    """The gear of a stiffness that was measured, with its standard deviation [N m/rad]; refined within it."""
    inertia = max(float(link_size(model)[0][joint]), 1e-9)
    share = min(max(STRANGE * std / stiffness, FORMULA), 1.0 - FORMULA)
    angular = np.sqrt(stiffness * np.array([1.0 - share, 1.0, 1.0 + share]) / inertia)
    least, resonance, most = map(float, angular / (2 * np.pi))
    return _gear(model, joint, inertia, resonance, RATIO, Shape("Hz", least, most))


def measured(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> Iterator[tuple[Answer, Answer]]:
    """Gears between two encoders: how the twist answers for the load, and the gear of that stiffness."""
    if all(run.prepared.link_position is None for run in runs):
        return
    # Every run has a zero of its own, so that there is none to be predicted only.
    blocks = replace(prediction.blocks, fitted=np.ones(len(prediction.blocks), bool))
    twists = Prediction.of(_twist_rows(prediction, runs), blocks, prediction.rate)
    for answer in ask(twists, _loads(twists, runs)):
        evidence = colouring(twists, answer)
        yield evidence, _as_gear(model, twists, evidence)


def _twist_rows(prediction: Prediction, runs: Sequence[Driven]) -> Rows:
    """Twist of each gear (r, n) [rad], with friction's hold, time and the zero in each run as unknowns."""
    twist = np.concatenate([_twist(run) for run in runs])
    velocity = np.concatenate([run.thinned(run.motion.velocity) for run in runs])
    sign = np.concatenate([run.thinned(smooth_sign(run.motion.velocity, SIGN)) for run in runs])
    joints, each = twist.shape[1], len(runs) + 2
    columns = np.zeros((*twist.shape, joints * each))
    for joint in range(joints):
        columns[:, joint, joint * each] = sign[:, joint]
        columns[:, joint, joint * each + 1] = velocity[:, joint]
        for number, rows in enumerate(prediction.rows.runs):
            columns[rows, joint, joint * each + number + 2] = 1.0
    known, count = np.isfinite(twist), joints * each
    return Rows(
        prediction.rows.runs,
        np.where(known, twist, 0.0),
        prediction.rows.weight * known,
        columns,
        tuple(f"twist{place}" for place in range(count)),
        std=np.full(count, np.inf),
        mean=np.zeros(count),
        lower=np.full(count, -np.inf),
        bounded=np.zeros(count, bool),
    )


def _twist(run: Driven) -> np.ndarray:
    """How far motors lead their links, shape (r, n) [rad]; NaN where it was not measured."""
    behind = run.prepared.link_position
    if behind is None:
        return np.full((run.rows, run.motion.position.shape[1]), np.nan)
    return run.thinned(run.motion.position - behind)


def _loads(twists: Prediction, runs: Sequence[Driven]) -> Iterator[tuple[Candidate, Thinned]]:
    """The load of every gear whose twist was measured, per unit of compliance."""
    load = np.concatenate([run.thinned(run.motion.load) for run in runs])
    for joint in np.flatnonzero(twists.rows.weight.any(axis=0)):
        candidate = Candidate(
            "joint_elasticity", (int(joint),), _not_of_torque, ("compliance",), ("rad/(N m)",), (0.0,)
        )
        usual = float(np.sqrt(np.mean(load[:, joint] ** 2)))
        twist = float(np.sqrt(np.mean(twists.rows.difference[:, joint] ** 2)))
        std = np.array([twist / max(usual, 1e-12)])
        yield candidate, Thinned(np.array([joint]), load[:, [joint], None], std, np.zeros(1))


def _not_of_torque(run: Driven) -> np.ndarray:
    raise NotImplementedError("a compliance gives twist, not torque")


def _as_gear(model: Model, twists: Prediction, answer: Answer) -> Answer:
    """The gear of that stiffness among the columns of torque, there whole and without any torque."""
    [joint], [compliance] = answer.candidate.joints, answer.values
    left = list(_left_out(twists, answer))
    spread = float(np.sqrt((len(left) - 1) * np.var(left)))
    std = spread / float(compliance) ** 2
    gear = of_stiffness(model, joint, 1.0 / float(compliance), std)
    gear = replace(gear, bounds={}, known={"stiffness": std})
    still = np.zeros((len(twists.rows.difference), 1, 1))
    columns = replace(answer.columns, values=still, mean=np.ones(1))
    return replace(answer, candidate=gear, columns=columns, values=np.ones(1), free=np.zeros(1, bool))


def _left_out(twists: Prediction, answer: Answer) -> Iterator[float]:
    """The compliance without each block."""
    [joint] = answer.columns.joints
    own = twists.rows.columns[:, joint][:, twists.sums.acting[joint]]
    columns = np.column_stack([own, answer.columns.values[:, 0]])
    for rows in twists.blocks.rows:
        kept = twists.rows.weight[:, joint] > 0
        kept[rows] = False
        yield float(np.linalg.lstsq(columns[kept], twists.rows.difference[kept, joint], rcond=None)[0][-1])


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """A gear that gives way; the more of the effect was found, the softer it is."""
    known = {name: quantity.value for name, quantity in finding.parameters.items()}
    stiffness = known["stiffness"] / max(known["share"], 0.1)
    damping = 2 * known["damping_ratio"] * stiffness / (2 * np.pi * known["resonance"])
    joint = arm.model.robot.joints[finding.joints[0]]
    return arm.with_measurement(JointElasticity(joint, stiffness, damping))


KINDS = {
    "joint_elasticity": Kind(
        family="elasticity",
        sentence="{joint} has an elastic gear[: {stiffness}][, resonant at {resonance}]",
        drawn_against=("acceleration", "load"),
        ask=gears,
        measured=measured,
        held=_held,
        gear=True,
        mistaken_for=("backlash", "time_delay", "rotor_inertia"),
        settled_by="a swept sine (exidyn excite --kind chirp)",
    )
}
