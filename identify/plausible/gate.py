"""The check of recordings before anything is fitted: what a person would suspect before missing physics.

It warns and never refuses: a log that is right looks wrong where an effect is large that no description has.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from ..model import Model
from ..recordings.recording import Recording
from ..recordings.servo_error import is_servo_error
from ..text_table import digits
from .evidence import Reading
from .flange import body_suspicions
from .gains import TELLS, gains
from .log_facts import LogFacts
from .mistakes import MOUNTING
from .sampled_runs import sampled_torques
from .samples import joined
from .suspicion import NONE_OF_THESE, Suspicion
from .units import encoder_steps
from .weigh import MOST, SURE, Weighed, supported, weigh

LIKELY = 0.5
"""Probability from which on a mistake is told."""
ALONE = 0.9
"""The same of a mistake that only one of several runs shows: a recorder seldom changes between runs."""
UNEXPLAINED = 0.5
"""Share of an effort's variance, from which on bodies of any mass and friction explain nothing of it."""


def doubts(runs: Sequence[Recording], model: Model) -> list[str]:
    """What seems to be wrong with recordings, in sentences: of all together, else of single ones."""
    with threadpool_limits(limits=1):  # hundreds of small systems: threads would wait for one another
        bodies = [f"{run.name}: {suspicion}" for run, suspicion in body_suspicions(runs, model)]
        return bodies + _mistakes([run for run in runs if run.payload is None] or list(runs), model)


def _mistakes(runs: Sequence[Recording], model: Model) -> list[str]:
    checked = _checked(runs, model)
    if checked is None:
        return []
    together = checked.suspicion
    if len(runs) == 1:
        return [] if together is None else [f"{runs[0].name}: {together}"]
    # A run that differs from the others spoils what all have in common.
    if together is None and checked.explained:
        return []
    each = {run.name: suspect([run], model) for run in runs}
    others = {of_run.name for of_run in each.values() if of_run is not None}
    if together is not None and others <= {together.name}:
        return [f"all runs: {together}"]
    alone = {name: of_run for name, of_run in each.items() if of_run is not None and _stands_alone(of_run)}
    return [f"{name}: {of_run}" for name, of_run in alone.items()]


def _stands_alone(suspicion: Suspicion) -> bool:
    """Whether one run shows enough for a mistake that the others do not show."""
    return suspicion.probability is None or suspicion.probability > ALONE


def suspect(runs: Sequence[Recording], model: Model) -> Suspicion | None:
    """The likeliest mistake that all of these recordings have, if one is likelier than none."""
    with threadpool_limits(limits=1):
        checked = _checked(runs, model)
    return None if checked is None else checked.suspicion


class Checked(NamedTuple):
    """What is suspected of recordings, and whether they are explained as they are, joint by joint."""

    suspicion: Suspicion | None
    explained: bool


def _checked(runs: Sequence[Recording], model: Model) -> Checked | None:
    """Recordings taken together; None where they are too short, or nothing moves."""
    kept, logs, stated = sampled_torques(runs, model.robot)
    if not kept:
        return None
    reading = Reading(model, joined(logs).thinned(MOST), stated)
    if not reading.log.moving.any():
        return None
    torques = all("torque" in run.signals for run in kept)
    servo = all(is_servo_error(run.settings) for run in kept)
    steps = encoder_steps(np.concatenate([run.signals["position"].values for run in kept]))
    facts = LogFacts(model.robot, reading.log, _ratio(reading), model.robot.drive_gain, torques, servo, steps)
    weighed = weigh(reading, facts)
    parts = logs if len(logs) > 1 else logs[0].halves()
    suspicion = _told(weighed, facts, [Reading(model, part.thinned(MOST), stated) for part in parts])
    return Checked(suspicion, bool(weighed.plain.trust[facts.moving].min(initial=1.0) > LIKELY))


def _told(weighed: Weighed, facts: LogFacts, parts: Sequence[Reading]) -> Suspicion | None:
    probability, joints = weighed.probability, facts.joints
    if probability > LIKELY:
        best = weighed.cases[0]
        # A direction was searched for in the same data, which then speak for it.
        searched = best.mistake is MOUNTING
        if probability > SURE and (searched or not supported(parts, best.change)):
            probability = SURE
        names = tuple(joints[j] for j in best.joints)
        mistake = best.mistake
        return Suspicion(mistake.name, names, best.what, mistake.cure, probability)
    return _none_of_these(parts, facts)


def _none_of_these(parts: Sequence[Reading], facts: LogFacts) -> Suspicion | None:
    """That most joints are not explained at all, and no mistake of the table changes that."""
    left = np.mean([part.prediction.fitted(part.log.effort) for part in parts], axis=0)
    lost = [j for j in facts.moving if left[j] > UNEXPLAINED]
    if len(lost) < 2 or 2 * len(lost) <= len(facts.moving):
        return None
    names = tuple(facts.joints[j] for j in lost)
    shares = ", ".join(f"{name} {digits(100 * left[j], 2)} %" for name, j in zip(names, lost, strict=True))
    what = f"bodies of any mass and friction leave most of the efforts unexplained ({shares})"
    cure = "another arm was recorded, or the log has a mistake that is not listed; look at columns and units"
    return Suspicion(NONE_OF_THESE, names, what, cure, None)


def _ratio(reading: Reading) -> np.ndarray:
    """Gain over the one stated, where one is stated and the log tells it, shape (n,)."""
    if not reading.stated:
        return np.full(reading.model.robot.dof, np.nan)
    return np.array([abs(g.value) if g.relative <= TELLS else np.nan for g in gains(reading)])
