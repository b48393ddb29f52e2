"""Check of recordings before a fit: mistakes that a person would suspect before missing physics.

The check warns and never rejects: a large effect that no description has makes a correct log look wrong.
"""

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from ..model import Model
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from ..text_table import digits
from .block_prediction import BlockPrediction
from .evidence import Reading
from .flange import body_suspicions
from .gains import TELLS, gains
from .mistake import LogFacts
from .mistakes import MOUNTING
from .samples import joined, sampled_torques
from .suspicion import NONE_OF_THESE, Suspicion
from .units import encoder_steps
from .weigh import MOST, SURE, Weighed, supported, weigh

LIKELY = 0.5
"""Probability beyond which a mistake is reported."""
ALONE = 0.9
"""Probability required if only one of several runs shows a mistake: recorders seldom change between runs."""
UNEXPLAINED = 0.5
"""Unpredicted share of an effort's variance beyond which bodies and friction do not explain the effort."""


def doubts(runs: Sequence[Recording], model: Model) -> list[str]:
    """Sentences on probable mistakes in recordings: common to all of them, or else in single ones."""
    with threadpool_limits(limits=1):  # hundreds of small systems: threads would wait for one another
        bodies = [f"{run.name}: {suspicion}" for run, suspicion in body_suspicions(runs, model)]
        return bodies + _mistakes([run for run in runs if run.payload is None] or list(runs), model)


def _mistakes(runs: Sequence[Recording], model: Model) -> list[str]:
    together, explained = _checked(runs, model)
    if len(runs) == 1:
        return [] if together is None else [f"{runs[0].name}: {together}"]
    # A run that differs from the others corrupts the common evidence.
    if together is None and explained:
        return []
    suspicions = {run.name: suspect([run], model) for run in runs}
    others = {suspicion.name for suspicion in suspicions.values() if suspicion is not None}
    if together is not None and others <= {together.name}:
        return [f"all runs: {together}"]
    return [
        f"{name}: {suspicion}"
        for name, suspicion in suspicions.items()
        if suspicion is not None and (suspicion.probability is None or suspicion.probability > ALONE)
    ]


def suspect(runs: Sequence[Recording], model: Model) -> Suspicion | None:
    """Most probable mistake common to all recordings, if it is more probable than none."""
    with threadpool_limits(limits=1):
        return _checked(runs, model)[0]


def _checked(runs: Sequence[Recording], model: Model) -> tuple[Suspicion | None, bool]:
    """Suspicion about all recordings together, and whether each joint is explained without a correction.

    There is no suspicion if they are too short or nothing moves.
    """
    usable, logs, stated = sampled_torques(runs, model.robot)
    if not usable:
        return None, True
    reading = Reading(model, joined(logs).thinned(MOST), stated)
    if not reading.log.moving.any():
        return None, True
    torques = all("torque" in run.signals for run in usable)
    servo = all(is_servo_error(run.settings) for run in usable)
    steps = encoder_steps(np.concatenate([run.signals["position"].values for run in usable]))
    facts = LogFacts(model.robot, reading.log, _ratio(reading), model.robot.drive_gain, torques, servo, steps)
    weighed = weigh(reading, facts)
    parts = logs if len(logs) > 1 else logs[0].halves()
    suspicion = _suspicion(weighed, facts, [Reading(model, part.thinned(MOST), stated) for part in parts])
    return suspicion, bool(weighed.plain.trust[facts.moving].min(initial=1.0) > LIKELY)


def _suspicion(weighed: Weighed, facts: LogFacts, parts: Sequence[Reading]) -> Suspicion | None:
    probability, joints = weighed.probability, facts.joints
    if probability > LIKELY:
        best = weighed.cases[0]
        # A direction found by a search in the same data needs no check against parts of the data.
        searched = best.mistake is MOUNTING
        if probability > SURE and (searched or not supported(parts, best.change)):
            probability = SURE
        names = tuple(joints[j] for j in best.joints)
        mistake = best.mistake
        return Suspicion(mistake.name, names, best.clause, mistake.cure, probability)
    return _none_of_these(parts, facts)


def _none_of_these(parts: Sequence[Reading], facts: LogFacts) -> Suspicion | None:
    """Suspicion of an unlisted mistake if most joints are not explained at all."""
    share = np.mean([part.shares(BlockPrediction.fitted, part.log.effort) for part in parts], axis=0)
    unexplained = [j for j in facts.moving if share[j] > UNEXPLAINED]
    if len(unexplained) < 2 or 2 * len(unexplained) <= len(facts.moving):
        return None
    names = tuple(facts.joints[j] for j in unexplained)
    shares = ", ".join(f"{facts.joints[j]} {digits(100 * share[j], 2)} %" for j in unexplained)
    clause = f"bodies of any mass and friction do not explain most of the efforts ({shares})"
    cure = "check whether another arm was recorded, and check columns and units for an unlisted mistake"
    return Suspicion(NONE_OF_THESE, names, clause, cure, None)


def _ratio(reading: Reading) -> np.ndarray:
    """Gain from the log over the stated gain, shape (n,); NaN if either is unknown."""
    if not reading.stated:
        return np.full(reading.model.robot.dof, np.nan)
    return np.array([abs(g.value) if g.relative <= TELLS else np.nan for g in gains(reading)])
