"""The check of recordings before anything is fitted: what a person would suspect before missing physics.

It warns and never refuses: a log that is right looks wrong where an effect is large that no description has.
"""

from collections.abc import Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from ..model import Model
from ..recordings.recording import EFFORT, Recording
from ..recordings.servo_error import is_servo_error
from ..text_table import digits
from .evidence import Reading
from .gains import TELLS, gains
from .mistakes import Asked
from .samples import Sampled, joined, sampled
from .suspicion import NONE_OF_THESE, Suspicion
from .weigh import MOST, SURE, Weighed, supported, weigh

LIKELY = 0.5
"""Probability from which on a mistake is told."""
ALONE = 0.9
"""The same of a mistake that only one of several runs shows: a recorder seldom changes between runs."""
UNEXPLAINED = 0.5
"""Share of an effort's variance, from which on bodies of any mass and friction explain nothing of it."""
FEWEST = 100
"""Samples of a recording that can be weighed."""


def doubts(runs: Sequence[Recording], model: Model) -> list[str]:
    """What seems to be wrong with recordings, in sentences: of all together, else of single ones."""
    together = suspect(runs, model)
    if len(runs) == 1:
        return [] if together is None else [f"{runs[0].name}: {together}"]
    each = {run.name: suspect([run], model) for run in runs}
    if together is not None and all(
        of_run is None or of_run.name == together.name for of_run in each.values()
    ):
        return [f"all runs: {together}"]
    return [
        f"{name}: {of_run}" for name, of_run in each.items() if of_run is not None and _stands_alone(of_run)
    ]


def _stands_alone(suspicion: Suspicion) -> bool:
    """Whether one run shows enough for a mistake that the others do not show."""
    return suspicion.probability is None or suspicion.probability > ALONE


def suspect(runs: Sequence[Recording], model: Model) -> Suspicion | None:
    """The likeliest mistake that all of these recordings have, if one is likelier than none."""
    with threadpool_limits(limits=1):  # hundreds of small systems: threads would wait for one another
        return _suspect(runs, model)


def _suspect(runs: Sequence[Recording], model: Model) -> Suspicion | None:
    kept = [(run, log) for run, log in ((run, _sampled(run)) for run in runs) if log is not None]
    if not kept:
        return None
    torques = {"torque" in run.signals for run, _ in kept}
    constants = model.robot.drive_gain
    stated = len(torques) == 1 and (torques == {True} or not np.all(constants == 1.0))
    factor = constants if stated and torques == {False} else np.ones(model.robot.dof)
    logs = [log._replace(effort=log.effort * factor) for _, log in kept]
    reading = Reading(model, joined(logs).thinned(MOST), stated)
    servo = all(is_servo_error(run.settings) for run, _ in kept)
    asked = Asked(model.robot, reading.log, _ratio(reading), constants, torques == {True}, servo)
    weighed = weigh(reading, asked)
    parts = logs if len(logs) > 1 else logs[0].halves()
    return _told(weighed, asked, [Reading(model, part.thinned(MOST), stated) for part in parts])


def _told(weighed: Weighed, asked: Asked, parts: Sequence[Reading]) -> Suspicion | None:
    probability, joints = weighed.probability, asked.joints
    if probability > LIKELY:
        best = weighed.cases[0]
        if probability > SURE and not supported(parts, best.change):
            probability = SURE
        names = tuple(joints[j] for j in best.joints)
        mistake = best.mistake
        return Suspicion(mistake.name, names, best.what, mistake.cure, probability, mistake.physical)
    return _none_of_these(parts, asked)


def _none_of_these(parts: Sequence[Reading], asked: Asked) -> Suspicion | None:
    """That most joints are not explained at all, and no mistake of the table changes that."""
    left = np.mean([part.prediction.fitted(part.log.effort) for part in parts], axis=0)
    lost = [j for j in asked.moving if left[j] > UNEXPLAINED]
    if len(lost) < 2 or 2 * len(lost) <= len(asked.moving):
        return None
    names = tuple(asked.joints[j] for j in lost)
    shares = ", ".join(f"{name} {digits(100 * left[j], 2)} %" for name, j in zip(names, lost, strict=True))
    what = f"bodies of any mass and friction leave most of the efforts unexplained ({shares})"
    cure = "another arm was recorded, or the log has a mistake that is not listed; look at columns and units"
    return Suspicion(NONE_OF_THESE, names, what, cure, None)


def _ratio(reading: Reading) -> np.ndarray:
    """Gain over the one stated, where one is stated and the log tells it, shape (n,)."""
    if not reading.stated:
        return np.full(reading.model.robot.dof, np.nan)
    return np.array([abs(g.value) if g.relative <= TELLS else np.nan for g in gains(reading)])


def _sampled(run: Recording) -> Sampled | None:
    """Positions and efforts at the same samples; None where there are too few."""
    name = next((name for name in EFFORT if name in run.signals), "")
    if not name or min(len(run.signals["position"]), len(run.signals[name])) < FEWEST:
        return None
    position, effort = run.signals["position"], run.signals[name]
    known = np.isfinite(position.values).all(axis=1)
    time = position.time[known]
    efforts = np.column_stack([np.interp(time, effort.time, values) for values in effort.values.T])
    if not np.isfinite(efforts).all() or np.any(np.diff(time) <= 0.0):
        return None
    return sampled(time, position.values[known], efforts)
