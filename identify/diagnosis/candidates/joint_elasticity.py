"""Joint elasticity: a gear bends under load, so its link lags behind the motor and oscillates.

`measurements/twist.py` has the motor torque. The stiffness shapes it: well below the resonance, only load
over stiffness matters; near the resonance, the oscillation of the link.

If encoders behind the gears were recorded, the twist is measured. It is the load over the stiffness, plus an
encoder zero in each run, the hold of the gear's friction, and the delay between the two encoders. A delay of
a millisecond is most of the measured twist, and friction torque, which depends on velocity, would be mistaken
for its cause. Left-out blocks decide whether the twist contains the load, as for any other effect. Motors are
modeled at their own encoders, so a stiff gear adds nothing to the fitted torque.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...effects import Shape
from ...effects.smooth_sign import smooth_sign
from ...measurements import JointElasticity
from ...measurements.gears import Gear
from ...model import Model
from ...simulation.plant.gears import link_size
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
from .parts import on_motors

STEP = 1.3
"""Ratio between successive resonances [-]."""
RESONANCES = tuple(3.0 * STEP**step for step in range(12))
"""Resonances of the mean link on its gear that are tried [Hz], up to 54: below, no drive can control the arm;
above, the fastest motion twists a gear by less than 1/15 of a link's acceleration."""
RATIO = (STEP - 1.0) / 2.0
"""Damping ratio on the grid [-]; steel has 0.02 and a lot of grease 0.2. The width of a resonance, twice its
damping ratio, equals the step of the grid, so no gear lies between two grid points."""
SCATTER = 0.1
"""Standard deviation of the coefficient from 1, since the stiffness gives the size of the effect [-]: the
error of the link's inertia and damping."""
LEAST = 0.5
"""Smallest coefficient [-]; below it, another oscillation is being fitted."""


def gears(model: Model) -> Iterator[Candidate]:
    """Gears of all joints, from soft to stiff."""
    for joint, inertia in enumerate(link_size(model)[0]):
        # A joint that moves no inertia does not bend its gear.
        for resonance in RESONANCES if inertia > 0.0 and model.robot.geared[joint] else ():
            yield _gear(model, joint, inertia, resonance, RATIO)


def gear_torque(model: Model, run: Driven, gear: Gear) -> np.ndarray:
    """Motor torque beyond that of a rigid gear, shape (t, n) [N m]."""
    joint, tangent = model.robot.index(gear.joint), run.unloaded.tangent
    step = float(np.median(np.diff(run.motion.time)))
    twist = gear.twist(tangent, run.motion.load[:, joint], joint, step)
    return on_motors(model.robot, -tangent.torque(joint, *twist)[:, :, None])[:, :, 0]


def _gear(
    model: Model, joint: int, inertia: float, resonance: float, ratio: float, within: Shape | None = None
) -> Candidate:
    """A gear whose mean link has a resonance [Hz], refined around it or within given bounds."""
    angular = 2 * np.pi * resonance
    stiffness = inertia * angular**2
    gear = JointElasticity(model.robot.joints[joint], stiffness, 2 * ratio * inertia * angular)

    def columns(run: Driven) -> np.ndarray:
        return gear_torque(model, run, gear)[:, :, None]

    def reshaped(shape: Mapping[str, float]) -> Candidate:
        return _gear(model, joint, inertia, shape["resonance"], shape["damping_ratio"], within)

    within_step = Shape("Hz", resonance / STEP, resonance * STEP)
    bounds = {"resonance": within or within_step, "damping_ratio": Shape("1", 0.005, 0.5)}
    return Candidate(
        "joint_elasticity", (joint,), columns, ("share",), ("1",), (LEAST,),
        {"resonance": resonance, "damping_ratio": ratio, "stiffness": stiffness}, bounds, reshaped,
        expected=((1.0, SCATTER),), reported={"stiffness": (stiffness, "N m/rad")}, loaded=True,
    )  # fmt: skip


def of_stiffness(model: Model, joint: int, stiffness: float, std: float) -> Candidate:
    """The gear with a measured stiffness, refined within its standard deviation, both [N m/rad]."""
    inertia = max(float(link_size(model)[0][joint]), 1e-9)
    share = min(max(STRANGE * std / stiffness, FORMULA), 1.0 - FORMULA)
    angular = np.sqrt(stiffness * np.array([1.0 - share, 1.0, 1.0 + share]) / inertia)
    least, resonance, most = map(float, angular / (2 * np.pi))
    return _gear(model, joint, inertia, resonance, RATIO, Shape("Hz", least, most))


def measured(model: Model, prediction: Prediction, runs: Sequence[Driven]) -> Iterator[tuple[Answer, Answer]]:
    """Gears between two encoders: the answer of the twist to the load, and the gear of that stiffness."""
    if all(run.prepared.link_position is None for run in runs):
        return
    # The encoder zero differs between runs, so no run can be held out.
    blocks = replace(prediction.blocks, fitted=np.ones(len(prediction.blocks), bool))
    twists = Prediction.of(_twist_rows(prediction, runs), blocks, prediction.rate)
    for answer in ask(twists, _loads(twists, runs)):
        evidence = colouring(twists, answer)
        yield evidence, _as_gear(model, twists, evidence)


def _twist_rows(prediction: Prediction, runs: Sequence[Driven]) -> Rows:
    """Twist of each gear (r, n) [rad], with friction, delay and the zero in each run as unknowns."""
    twist = np.concatenate([_twist(run) for run in runs])
    velocity = np.concatenate([run.thinned(run.motion.velocity) for run in runs])
    sign = np.concatenate([run.thinned(smooth_sign(run.motion.velocity)) for run in runs])
    joints, per_joint = twist.shape[1], len(runs) + 2
    columns = np.zeros((*twist.shape, joints * per_joint))
    for joint in range(joints):
        columns[:, joint, joint * per_joint] = sign[:, joint]
        columns[:, joint, joint * per_joint + 1] = velocity[:, joint]
        for number, rows in enumerate(prediction.rows.runs):
            columns[rows, joint, joint * per_joint + number + 2] = 1.0
    measured, count = np.isfinite(twist), joints * per_joint
    return Rows(
        prediction.rows.runs,
        np.where(measured, twist, 0.0),
        prediction.rows.weight * measured,
        (columns,),
        tuple(f"twist{place}" for place in range(count)),
        std=np.full(count, np.inf),
        mean=np.zeros(count),
        lower=np.full(count, -np.inf),
        bounded=np.zeros(count, bool),
    )


def _twist(run: Driven) -> np.ndarray:
    """Angle by which motors lead their links, shape (r, n) [rad]; NaN where it was not measured."""
    behind = run.prepared.link_position
    if behind is None:
        return np.full((run.rows, run.motion.position.shape[1]), np.nan)
    return run.thinned(run.motion.position - behind)


def _loads(twists: Prediction, runs: Sequence[Driven]) -> Iterator[tuple[Candidate, Thinned]]:
    """Candidates for the compliance of every gear whose twist was measured, and their columns: the load."""
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
    """The gear of the measured stiffness as an answer, with columns of zero torque."""
    [joint], [compliance] = answer.candidate.joints, answer.values
    replicates = list(_left_out(twists, answer))
    spread = float(np.sqrt((len(replicates) - 1) * np.var(replicates)))
    std = spread / float(compliance) ** 2
    gear = of_stiffness(model, joint, 1.0 / float(compliance), std)
    gear = replace(gear, bounds={}, known={"stiffness": std})
    no_torque = np.zeros((len(twists.rows.difference), 1, 1))
    columns = replace(answer.columns, values=no_torque, mean=np.ones(1))
    return replace(answer, candidate=gear, columns=columns, values=np.ones(1), free=np.zeros(1, bool))


def _left_out(twists: Prediction, answer: Answer) -> Iterator[float]:
    """Compliance estimated without each block, for the jackknife."""
    [joint] = answer.columns.joints
    unknowns = twists.rows.columns_at(twists.sums.acting[joint])[:, joint]
    columns = np.column_stack([unknowns, answer.columns.values[:, 0]])
    for block in range(len(twists.blocks)):
        used = (twists.rows.weight[:, joint] > 0) & (twists.blocks.number != block)
        yield float(np.linalg.lstsq(columns[used], twists.rows.difference[used, joint], rcond=None)[0][-1])


def _held(arm: Arm, finding: Hypothesis) -> Arm:
    """The arm with an elastic gear, which is softer the larger the coefficient of the effect."""
    known = finding.numbers
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
        settled_by="a swept sine (exidyn excite --kind chirp)",
    )
}
